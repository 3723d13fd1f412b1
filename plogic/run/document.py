"""The whole ``interpretation/1`` document of one image (contract), from the typed parts.

Of learned types it leaves out what no question needs, and says so: descriptors of appearances, features that are case B
in every world (``left_out`` per hypothesis, and one feature that stands for those in the image, see
``plogic.cycle.lumped``), and with a vocabulary of words the causes of what nothing is matched to (``causes_else``:
"noise").
"""

from collections.abc import Collection, Mapping, Sequence
from math import floor, hypot, log10
from typing import TYPE_CHECKING, cast

import numpy as np
from numpy.typing import NDArray

from geometry.camera import camera_to_dict
from kb.clouds.cloud import KnowledgeBase
from plogic.cycle.delta import Delta
from plogic.cycle.lumped import left_out, looked_at, support_document, told, told_as, types_told
from plogic.facts.dependence import Scene
from plogic.facts.document import (
    ApartKey,
    AppearanceRow,
    Case,
    HypothesisRow,
    Interpretation,
    Listed,
    RejectedRow,
    RelationRow,
    SharesRow,
    Status,
    StepRow,
    UnweighedKey,
    Verdict,
    WorldRow,
)
from plogic.facts.hypothesis import Hypothesis
from plogic.facts.interpretation import FORMAT, facts_of, hypothesis_document
from plogic.facts.situation import OTHERS, PairFact, Situation
from plogic.facts.spatial import apart_of, gravity_document, space_document
from plogic.facts.stances import Stood, stances_document, standing_document
from plogic.match.judged.evidence import outline_rings
from plogic.match.judged.rivals import in_the_way
from plogic.measures.distinctiveness import distinctiveness, instance_counts, probability_of_distinctiveness
from plogic.measures.explanatory import case_of, probability_of_ev
from plogic.run.carried import image_asset, mesh_assets, sensing_document, types_document
from plogic.run.painted import paint_assets
from plogic.scene.asking.stood import stood
from plogic.scene.factors.asked_formulas import together
from plogic.scene.readings.standing import with_standing
from plogic.scene.readings.world_weights import p_ev
from plogic.scene.worlds.predictions import doubts
from plogic.scene.worlds.ranked_worlds import Ranking
from sensing.appearance import Gamma
from sensing.files.gamma_files import appearance_to_dict
from sensing.uncollected import uncollected

if TYPE_CHECKING:
    from geometry.camera_row import CameraRow

LISTED_REJECTED = 12
"""Rejected hypotheses that are written, the best first; the trace names them all."""


IMPOSSIBLE = "no possible world holds it: its probability is 0"
"""Said of what is accepted all the same."""


@uncollected()
def document_of(
    kb: KnowledgeBase,
    gamma: Gamma,
    delta: Delta,
    rejected: Sequence[Hypothesis],
    trace: list[StepRow],
    ranking: Ranking,
    image: NDArray[np.uint8] | None,
    *,
    seconds: float | None = None,
) -> Interpretation:
    """Everything that ``worlds``, ``query``, ``explain``, ``report`` and ``program`` need.

    With ``seconds``, what is known of relations by then.
    """
    situation = delta.situation
    counts, dv = instance_counts(kb.types), delta.dv
    over_types = types_told(distinctiveness(counts), kb, situation.hypotheses)
    kinds = {b.object_type.name: b.object_type for b in delta.beliefs.values()}
    stands = stood(situation, seconds)
    document: Interpretation = {
        "format": FORMAT,
        "reading": situation.reading,
        "reconsider": situation.reconsider,
        "smoothing": situation.smoothing,
        "kb": {"name": kb.name, "digest": kb.digest},
        "camera": cast("CameraRow", camera_to_dict(gamma.camera)),
        "appearances": [
            cast("AppearanceRow", appearance_to_dict(a, described=False) | {"clutter": fact.clutter})
            for a, fact in zip(gamma.appearances, situation.appearances, strict=True)
        ],
        "hypotheses": [*_hypotheses(delta, gamma, ranking, stands), *_rejected(rejected, gamma, dv)],
        **_worlds(ranking, situation, short=kb.words is not None),
        "unlisted_mass": list(ranking.unlisted),
        **_unweighed(delta, rejected),
        "relations": relation_probabilities(situation, seconds),
        "doubts": [doubt.document() for doubt in doubts(situation)],
        "facts": facts_of(situation),
        "space": space_document(situation.space),
        **gravity_document(situation.gravity),
        **standing_document(situation.support, stands),  # type: ignore[typeddict-item] # no deadline's marks yet
        "measures": {
            "dv": situation.dv,
            **_shares(situation, over_types, probability_of_distinctiveness(counts)),
            "rank": situation.rank,
        },
        "priors": situation.priors,
        "rules": situation.rules,
        "labels": {},
        "sensing": sensing_document(kb),
        "types": types_document(kinds, kb),
        "assets": {**image_asset(image), **mesh_assets(kinds), **paint_assets(kinds)},
        "trace": trace,
    }
    better = surpassed(document)
    for row in document["hypotheses"]:
        if row["id"] in better:
            row["why"] = f"{row['why']}; {better[row['id']]}"
    return document


def _shares(situation: Situation, over_types: dict[str, float], shares: Mapping[str, float]) -> SharesRow:
    """P(dv) of each feature type, and where dv is over the instances in Δ, that over the types of Σo too."""
    if situation.dv_over == "types":
        return {"p_dv": {name: p for name, p in shares.items() if name in situation.dv}}
    p_dv = {name: 1.0 - value for name, value in situation.dv.items()}
    return {"p_dv": p_dv, "dv_over": situation.dv_over, "dv_types": over_types}


def _worlds(ranking: Ranking, situation: Situation, *, short: bool) -> Listed:
    """The listed worlds.

    ``short``: an appearance that no feature is matched to is noise in all of them, and is not repeated.
    """
    matched = {f.match for h in situation.hypotheses for f in h.features}
    named = [a.id for a in situation.appearances if a.id in matched or not short]
    rows: list[WorldRow] = [
        {"probability": w.probability, "present": list(w.present), "causes": {a: w.causes[a] for a in named}}
        for w in ranking.worlds
    ]
    worlds = [with_standing(row, w.told) for row, w in zip(rows, ranking.worlds, strict=True)]
    return {"worlds": worlds, "causes_else": "noise"} if short else {"worlds": worlds}


def relation_probabilities(situation: Situation, seconds: float | None = None) -> list[RelationRow]:
    """P(relation) of each pair: that both are present, most probable first.

    With ``seconds``, the middle of its ``interval`` by then.
    """
    chances = together(situation, [(fact.x, fact.y) for fact in situation.relations], seconds)
    rows = [
        _relation(fact, low, high, told=seconds is not None)
        for fact, (low, high) in zip(situation.relations, chances, strict=True)
    ]
    return sorted(rows, key=lambda row: (-row["probability"], row["relation"], row["args"]))


def _relation(fact: PairFact, low: float, high: float, *, told: bool) -> RelationRow:
    middle = low if low == high else (low + high) / 2.0
    row: RelationRow = {"relation": fact.relation, "args": [fact.x, fact.y], "probability": middle}
    if fact.roc:
        row["roc"] = fact.roc
    if told:
        row["interval"] = [low, high]
    return row


def _hypotheses(delta: Delta, gamma: Gamma, ranking: Ranking, stands: Stood | None) -> list[HypothesisRow]:
    apart = apart_of(delta.situation.space, {name: h.type for name, h in delta.beliefs.items()})
    return [
        {
            **hypothesis_document(belief, _cases(belief)),
            "label": belief.type,
            "status": cast("Status", belief.status),
            **_verdict(belief, gamma, delta.dv),
            **stances_document(name, delta.situation.support, stands),
            "why": _why(belief, ranking.marginals[name]),
            "ev_reconsidered": _reconsidered(name, delta),
            **_apart(apart.get(name)),
            "probability": ranking.marginals[name],
        }
        for name, belief in delta.beliefs.items()
    ]


def _unweighed(delta: Delta, rejected: Sequence[Hypothesis]) -> UnweighedKey:
    """How many rivals of each accepted hypothesis are not weighed, where some are not."""
    beyond = [h for h in rejected if h.status == "unweighed"]
    accepted = {name: belief for name, belief in delta.beliefs.items() if belief.status == "accepted"}
    counts = {name: sum(in_the_way(h, belief) for h in beyond) for name, belief in accepted.items()}
    told = {name: count for name, count in counts.items() if count}
    return {"unweighed": told} if told else {}


def _why(belief: Hypothesis, probability: float) -> str:
    return f"{belief.why}; {IMPOSSIBLE}" if belief.status == "accepted" and probability == 0.0 else belief.why


def _apart(lines: list[str] | None) -> ApartKey:
    return {} if lines is None else {"apart": lines}


def _reconsidered(name: str, delta: Delta) -> float | None:
    """Ev beside Δi in the situation's mode (§5.5), None where it is 0/0; the cycle itself judges by ``to_B``."""
    if delta.situation.reconsider == "to_B":
        return delta.beliefs[name].ev_reconsidered
    scene = Scene(delta.situation)
    present = {key: np.array([key == name or other.status == "accepted"]) for key, other in delta.beliefs.items()}
    share = float(p_ev(scene, scene.by_id[name], present)[0])
    return None if np.isnan(share) else 2.0 * share - 1.0


def _cases(posed: Hypothesis) -> dict[str, tuple[bool, bool, Case | None]]:
    """(expected, detected, case) of each feature that is told, beside Δi; outside the image, no case."""
    expected = posed.expected(posed.hidden)
    some = told(posed)
    rows = zip(some, *(mask[some].tolist() for mask in (expected, posed.detected, posed.in_image)), strict=True)
    cases: dict[str, tuple[bool, bool, Case | None]] = {
        told_as(posed, f).name: (e, d, case_of(expected=e, detected=d) if inside else None) for f, e, d, inside in rows
    }
    return cases | {OTHERS: (False, False, "B")}


def _verdict(belief: Hypothesis, gamma: Gamma, dv: Mapping[str, float]) -> Verdict:
    """What the cycle decided of one hypothesis, with its measures and outline."""
    posed, ev = belief, belief.ev
    missing = left_out(posed)
    verdict: Verdict = {
        "why": belief.why,
        "ev": ev,
        "p_ev": None if ev is None else probability_of_ev(ev),
        "ev_reconsidered": belief.ev_reconsidered,
        "log_likelihood_ratio": belief.worth,
        "support": support_document(posed, dv),
    }
    if belief.pixels is not None:
        verdict["pixels"] = belief.pixels
    if belief.pixel_table is not None:
        verdict |= belief.pixel_table.document()  # type: ignore[typeddict-item] # keys of a verdict
    if belief.pose_probability is not None:
        verdict["pose_probability"] = belief.pose_probability
    if missing is not None:
        verdict["left_out"] = missing
    verdict["outline"] = outline_rings(posed, gamma.camera)
    return verdict


def _rejected(rejected: Sequence[Hypothesis], gamma: Gamma, dv: Mapping[str, float]) -> list[RejectedRow]:
    best = sorted(rejected, key=lambda b: -b.worth)[:LISTED_REJECTED]
    ids = [a.id for a in gamma.appearances]
    return [
        {
            "id": f"r{i}",
            "type": b.object_type.name,
            "T_camera_object": b.camera_from_object.tolist(),
            "opaque": b.object_type.opaque,
            "group": None,
            "probability": 0.0,
            "parts": [],
            "features": looked_at(b, ids, dv),
            "label": b.object_type.name,
            "status": "rejected",
            **_verdict(b, gamma, dv),
        }
        for i, b in enumerate(best, 1)
    ]


def accepted_in(document: Interpretation) -> tuple[str, ...]:
    """The accepted objects: ``h1 t1 (0.941)``; of what is unfinished, with the interval; none of 0.000."""
    rows = [h for h in document["hypotheses"] if h["status"] == "accepted" and _possible(h)]
    return tuple(f"{h['id']} {h['type']} ({_chance(h)})" for h in rows)


SHOWN = 0.0005
"""Least probability, or difference of two, that three places show: what is less is told as 0.000, or as none."""


def _possible(h: HypothesisRow) -> bool:
    """Whether what was accepted is told as found: not where its rivals left it nothing."""
    return (h.get("interval") or (0.0, h["probability"]))[1] >= SHOWN


def surpassed(document: Interpretation) -> dict[str, str]:
    """Of each accepted hypothesis, by id, that has a rival as probable, or a more probable one: that one, in words.

    As probable are two that differ by less than ``SHOWN``.
    """
    chances = {h["id"]: h["probability"] for h in document["hypotheses"] if h["status"] == "accepted"}
    found = {}
    for name, best in best_rivals(document).items():
        more = best["probability"] - chances[name]
        if more > -SHOWN and best["probability"] > 0.0:
            how, than = ("a more probable", "than") if more > SHOWN else ("as probable a", "as")
            who = f"{best['id']} ({best.get('label') or best['type']}, P {_chance(best)})"
            found[name] = f"{who} is {how} reading of the same data {than} {name}"
    return found


def best_rivals(document: Interpretation) -> dict[str, HypothesisRow]:
    """Of each accepted hypothesis, by id, that has any rival: the most probable one."""
    pairs = {tuple(fact["args"]) for fact in document["facts"] if fact["fact"] in ("overlap", "rival", "exclusive")}
    rows = [h for h in document["hypotheses"] if h["status"] != "rejected"]
    found: dict[str, HypothesisRow] = {}
    for h in (row for row in rows if row["status"] == "accepted"):
        rivals = [r for r in rows if r["status"] != "accepted" and (_are(h, r, pairs) or r["group"] == h["group"])]
        if rivals:
            found[h["id"]] = max(rivals, key=lambda r: r["probability"])
    return found


def _are(one: HypothesisRow, other: HypothesisRow, pairs: Collection[tuple[str, ...]]) -> bool:
    """Whether some fact names the two of them."""
    return (one["id"], other["id"]) in pairs or (other["id"], one["id"]) in pairs


def placed_in(document: Interpretation) -> tuple[str, ...]:
    """Each accepted object, and where the origin of its frame is in the camera's.

    ``h1 t1 (0.941) at (0.12, -0.03, 0.84) m, 0.85 m away``.
    """
    accepted = [h for h in document["hypotheses"] if h["status"] == "accepted" and _possible(h)]
    places = [place_of(h["T_camera_object"]) for h in accepted]
    return tuple(f"{name} {place}" for name, place in zip(accepted_in(document), places, strict=True))


def place_of(camera_from_object: Sequence[Sequence[float]]) -> str:
    """Where the origin of a pose (4, 4) is, m, in words.

    To centimetres, of what is nearer than 0.1 m to two digits of its distance.
    """
    origin = [float(row[3]) for row in camera_from_object[:3]]
    away = hypot(*origin)
    digits = max(2, 1 - floor(log10(away))) if away > 0.0 else 2
    x, y, z = (f"{round(value, digits) + 0.0:.{digits}f}" for value in origin)  # + 0.0: no -0.00
    return f"at ({x}, {y}, {z}) m, {away:.{digits}f} m away"


def _chance(h: HypothesisRow) -> str:
    low, high = h.get("interval") or (None, None)
    return f"{h['probability']:.3f}" + ("" if low is None else f" in {low:.3f}..{high:.3f}")
