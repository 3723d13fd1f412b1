"""Relations by evidence of an ``interpretation/1``: of hypotheses whose poses are withheld, and of posed ones beside.

``withheld(document, ["h2"])`` is the document of somebody who does not know where h2 stands. It keeps what was judged
of h2 (which of its features are expected of it alone, and which were detected: its ev), and loses its relations, what
it hides and what hides it, and where it is in space. What its evidence says of its relations to what is accepted is in
the facts of the document. ``weighed(document)`` adds what evidence says of two whose poses are known: the mean of the
two distributions in which the one's pose, or the other's, is not.
"""

from collections import Counter, defaultdict
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from itertools import combinations
from typing import cast

import numpy as np

from geometry.arrays import Floats
from geometry.camera import camera_from_dict
from geometry.visibility.occlusion import drawn, occlusion
from geometry.visibility.roc import Roc, converse
from plogic.base.errors import InputError
from plogic.facts.dependence import Scene
from plogic.facts.document import HypothesisRow, Interpretation, RejectedRow
from plogic.facts.hypothesis import FeatureFact, Hypothesis
from plogic.facts.interpretation import evidence_row, facts_of, situation_of
from plogic.facts.situation import EvidenceFact, Situation, pair_facts
from plogic.facts.spatial import space_document
from plogic.sequence.next_view.expected import Cloud, Prospect
from plogic.sequence.next_view.reading import prospect_of
from plogic.sequence.unposed.annealed import systematic
from plogic.sequence.unposed.drawn import Prior
from plogic.sequence.unposed.relations import TOLD, Posterior, placed, posterior, states
from plogic.sequence.unposed.standing import Reports, Stander, Target


def withheld(document: Interpretation, names: Sequence[str]) -> Interpretation:
    """The document without the poses of these hypotheses, and with what evidence says of their relations.

    Raises InputError for what is no hypothesis of Δh, and InterpretationError for an old document.
    """
    situation = situation_of(document)
    ids = [h.id for h in situation.hypotheses]
    strange = [name for name in names if name not in ids]
    if strange:
        raise InputError(f"withhold: {', '.join(strange)}: should be among {', '.join(ids) or 'no hypothesis'}")
    without = _without(situation, frozenset(names))
    told = replace(without, evidence=(*without.evidence, evidence(document, list(dict.fromkeys(names)))))
    by_id = {h.id: h for h in told.hypotheses}
    changed = {
        "facts": facts_of(told),
        "space": space_document(told.space),
        "hypotheses": [_row(h, by_id.get(h["id"]), told.withheld) for h in document["hypotheses"]],
        "relations": [row for row in document.get("relations", ()) if not set(names) & set(row["args"])],
        "doubts": [row for row in document.get("doubts", ()) if not set(names) & set(row["args"])],
    }
    return cast("Interpretation", {**document, **changed})


def _row(h: HypothesisRow | RejectedRow, told: Hypothesis | None, withheld: frozenset[str]) -> dict[str, object]:
    if told is None or h["status"] == "rejected":
        return {**h}
    hidden_by = {f.id: list(f.hidden_by) for f in told.features}
    features = [{**f, "hidden_by": hidden_by[f["id"]]} for f in h["features"]]
    stances = [row for row in h.get("stances", ()) if not withheld & {h["id"], row["on"]}]
    known = {key: value for key, value in h.items() if key != "level" or h["id"] not in withheld}
    return {
        **known,
        "features": features,
        **({} if told.pixel_table is None else told.pixel_table.document()),
        **({"stances": stances} if "stances" in h else {}),
    }


def _without(situation: Situation, names: frozenset[str]) -> Situation:
    """What is left where nobody knows where some stand."""
    others = [h.id for h in situation.hypotheses if h.id not in names]
    return replace(
        situation,
        hypotheses=tuple(
            h.told(
                features=tuple(replace(f, hidden_by=_unhidden(h.id, f, names)) for f in h.features),
                pixel_table=None if h.pixel_table is None else h.pixel_table.among(() if h.id in names else others),
            )
            for h in situation.hypotheses
        ),
        relations=tuple(r for r in situation.relations if not names & {r.x, r.y}),
        part_relations=tuple(r for r in situation.part_relations if not names & {r.x, r.y}),
        space=replace(situation.space.among(others), shared=situation.space.shared),
        gravity=None if situation.gravity is None else situation.gravity.among(others),
        support=None if situation.support is None else situation.support.among(others),
        evidence=tuple(
            fact for fact in situation.evidence if not names & {name for pair in fact.pairs for name in pair}
        ),
    )


def _unhidden(name: str, f: FeatureFact, names: frozenset[str]) -> tuple[str, ...]:
    return () if name in names else tuple(other for other in f.hidden_by if other not in names)


def evidence(document: Interpretation, names: Sequence[str], *, elsewhere: bool = False) -> EvidenceFact:
    """How these, whose poses are withheld, stand to what is accepted, and to each other, jointly.

    Each is placed by itself; of two of them what the one hides of the other speaks for nothing. ``elsewhere``: they are
    seen in another image, so that their own reports say nothing here.
    """
    targets = {name: target_of(document, name, _beside(document, name, names)) for name in names}
    if elsewhere:
        targets = {name: target.unreported for name, target in targets.items()}
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):  # a file may hold bodies without extent
        found = {name: posterior(target) for name, target in targets.items()}
    pairs = [(name, one.body.id) for name, target in targets.items() for one in target.standers]
    if len(names) == 1:
        (name,) = names
        return EvidenceFact(tuple(pairs), tuple((p, s) for s, p in states(targets[name], found[name]).items()), (name,))
    pairs += list(combinations(names, 2))
    return EvidenceFact(tuple(pairs), _together(targets, found, pairs), tuple(names))


def _beside(document: Interpretation, name: str, withheld: Iterable[str]) -> list[str]:
    """The accepted ones that it can be present with, their poses known; without a surface there is no relation."""
    scene, meshes = Scene(situation_of(document)), document.get("assets", {}).get("meshes", {})
    bodies = [h["id"] for h in document["hypotheses"] if h["status"] == "accepted" and h["type"] in meshes]
    unknown = {name, *withheld, *scene.situation.withheld}
    others = {*bodies} - unknown if scene.by_id[name].type in meshes else set()
    return [x for x in bodies if x in others and (x, name) not in scene.apart]


def _together(
    targets: Mapping[str, Target], found: Mapping[str, Posterior], pairs: Sequence[tuple[str, str]]
) -> tuple[tuple[float, tuple[Roc, ...]], ...]:
    """The joint states of several: poses of each, drawn by their shares, in an order of its own."""
    rng = np.random.default_rng(0)
    drawn_poses = {name: one.poses[rng.permutation(systematic(one.share, TOLD))] for name, one in found.items()}
    camera = next(iter(targets.values())).prior.camera
    standing = {
        one.body.id: placed(one.body.cloud, one.body.reference_from_object)
        for t in targets.values()
        for one in t.standers
    }
    counted: Counter[tuple[Roc, ...]] = Counter()
    for i in range(TOLD):
        bodies = standing | {name: placed(targets[name].prior.cloud, poses[i]) for name, poses in drawn_poses.items()}
        images = {name: drawn(body, camera) for name, body in bodies.items()}
        counted[tuple(occlusion(bodies[x], bodies[y], camera, images=(images[x], images[y])) for x, y in pairs)] += 1
    return tuple((n / TOLD, state) for state, n in sorted(counted.items(), key=lambda item: (-item[1], item[0])))


def weighed(document: Interpretation) -> Interpretation:
    """The document with what evidence says of the accepted, whose poses are known, two by two."""
    accepted = [h["id"] for h in document["hypotheses"] if h["status"] == "accepted"]
    alone = {name: evidence(document, [name]) for name in accepted}
    told = [beside(alone[x], alone[y], x, y) for x, y in combinations(accepted, 2) if (x, y) in alone[x].pairs]
    return {**document, "facts": [*document["facts"], *(evidence_row(fact) for fact in told)]}


def beside(one: EvidenceFact, other: EvidenceFact, x: str, y: str) -> EvidenceFact:
    """What evidence says of x and y: the mean of where x's pose is withheld, ``one``, and where y's is, ``other``."""
    shares: defaultdict[Roc, float] = defaultdict(float)
    for share, relations in one.states:
        shares[relations[one.pairs.index((x, y))]] += share / 2.0
    for share, relations in other.states:
        shares[converse(relations[other.pairs.index((y, x))])] += share / 2.0
    return EvidenceFact(((x, y),), tuple((p, (r,)) for r, p in sorted(shares.items(), key=lambda i: (-i[1], i[0]))))


MOST_DOUBTS = 5
"""Pairs whose doubts get a number: each takes up to two seconds."""


def doubts_weighed(document: Interpretation) -> Interpretation:
    """The document with the probability that evidence gives to each relation of accepted ones that is in doubt."""
    accepted = {h["id"] for h in document["hypotheses"] if h["status"] == "accepted"}
    rows = list(document.get("doubts", []))
    told = dict.fromkeys((min(row["args"]), max(row["args"])) for row in rows if accepted.issuperset(row["args"]))
    opaque = {h["id"]: h["opaque"] for h in document["hypotheses"]}
    chances: defaultdict[tuple[str, ...], float] = defaultdict(float)
    pairs = list(told)[:MOST_DOUBTS]
    alone = {name: evidence(document, [name]) for name in dict.fromkeys(name for pair in pairs for name in pair)}
    for x, y in pairs:
        for share, (relation,) in beside(alone[x], alone[y], x, y).states:
            for fact in pair_facts(relation, x, y, opaque=(opaque[x], opaque[y])):
                chances[fact.relation, fact.x, fact.y] += share
    for i, row in enumerate(rows):
        if (min(row["args"]), max(row["args"])) in pairs:
            rows[i] = {**row, "evidence": min(chances[row["relation"], *row["args"]], 1.0)}
    return {**document, "doubts": rows} if rows else document


def target_of(document: Interpretation, name: str, beside: Sequence[str]) -> Target:
    """What is known of ``name`` without its pose, and of those ``beside`` it, which it can be present with."""
    scene = Scene(situation_of(document))
    prospect = prospect_of(document, [(1.0, [name, *beside])])
    bodies = {body.id: body for body in prospect.bodies}
    camera = camera_from_dict(document["camera"])
    own, cloud, row = scene.by_id[name], bodies[name].cloud, {f.id: f for f in scene.by_id[name].features}
    chances = {other: _chances(bodies[other].cloud, prospect, camera.width * camera.height) for other in bodies}
    facing = [row[f] if f in row and _faces(own, row[f]) else None for f in cloud.features]
    shown = [f for f in facing if f is not None]
    asked = _surest([i for i, f in enumerate(shown) if f.in_image], shown)
    standers = tuple(
        Stander(
            bodies[other],
            *_known(scene, scene.by_id[other], {*beside} - {other}, chances[other]),
            rival=scene.rival(name, other),
        )
        for other in beside
    )
    others = tuple(one.body for one in standers)
    aspect = np.array([f is not None for f in facing], bool)
    prior = Prior(cloud, aspect, others, camera)
    inside = np.array([f.in_image for f in shown], bool)
    own_reports = _reports([shown[i] for i in asked], chances[name])
    return Target(prior, own.opaque, inside, np.array(asked, np.intp), own_reports, standers)


MOST = 80
"""Features of one hypothesis whose reports are looked at, the surest: a pair then takes less than a second."""


def _surest(places: Sequence[int], features: Sequence[FeatureFact]) -> list[int]:
    return sorted(sorted(places, key=lambda i: -features[i].hit_rate)[:MOST])


def _faces(h: Hypothesis, f: FeatureFact) -> bool:
    return f.in_lobe and not (f.self_hidden and h.opaque)


def _known(scene: Scene, h: Hypothesis, beside: set[str], chances: Mapping[str, float]) -> tuple[Floats, Reports]:
    """The features of a posed hypothesis that are expected beside these others, and what was reported of them."""
    some = [f for f in h.features if f.stands_for == 1 and h.expects(f) and not beside & set(scene.hiders(h, f))]
    some = [some[i] for i in _surest(range(len(some)), some)]
    return np.array([f.at for f in some]).reshape(-1, 3), _reports(some, chances)


def _reports(some: Sequence[FeatureFact], chances: Mapping[str, float]) -> Reports:
    return Reports(
        np.array([f.match is not None for f in some], bool),
        np.array([f.hit_rate for f in some]),
        np.array([chances.get(f.id, 0.0) for f in some]),
    )


def _chances(cloud: Cloud, prospect: Prospect, area: float) -> dict[str, float]:
    """By feature: the probability that clutter of one of its looks is within the tolerance of its place."""
    looks = {(f, name) for f, name in zip(cloud.lobes.feature.tolist(), cloud.lobes.types, strict=True)}
    expected = np.zeros(cloud.lobes.features)
    for f, name in looks:
        expected[f] += prospect.clutter.get(name, 1.0) / area * np.pi * prospect.tolerance**2
    return dict(zip(cloud.features, (-np.expm1(-expected)).tolist(), strict=True))
