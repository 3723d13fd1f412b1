"""Layer 2 of the program: the facts that geometry computed.

Constraints and support.

The facts of space: middles, distances, who is over and on whom, which way is up; a hypothesis whose body nobody
described is a point at its origin. Support: who may hold whom (layer 2), an excuse for each that may float (layer 3),
and that none floats without one (evidence).
"""

import math
from collections.abc import Iterator
from itertools import combinations

from plogic.base.bounds import bounded
from plogic.facts.hypothesis import FeatureFact, Hypothesis
from plogic.facts.situation import PairFact, both_ways
from plogic.facts.spatial import GROUND, BodyFact, Gravity, words_of_shared
from plogic.scene.text.layout import Writer, coordinate, number


def holds(w: Writer) -> Iterator[str]:
    """``weighs(h1). open_foot(h1, 0.0, 0.02).``, then ``body_rests(h2, h1).``.

    Nothing where nobody said that gravity holds.
    """
    gravity = w.scene.situation.gravity
    if gravity is None:
        return
    yield "% Gravity: whom it is said of; between which heights they begin, m, where the ground's is not told; who rests on whom."
    if gravity.silent:
        yield f"% It keeps silent: {gravity.silent}"
    for foot in gravity.feet:
        height = (
            f" open_foot({w.names.atom(foot.id)}, {number(foot.low)}, {number(foot.high)})."
            if gravity.ground is None
            else ""
        )
        yield w.fact("weighs", foot.id) + height
    yield from (
        f"body_rests({w.names.atom(x)}, {GROUND if y == GROUND else w.names.atom(y)})." for x, y in gravity.rests
    )


def excuses(w: Writer) -> Iterator[str]:
    """``0.1::excused(h2).`` for each that floats in some world."""
    gravity = w.scene.situation.gravity
    if gravity is None:
        return
    yield ""
    yield "% Something that the KB does not know may hold what seems to float, each by itself."
    yield "excused(_) :- fail."
    yield from (
        f"{number(bounded(gravity.unknown_support))}::excused({w.names.atom(name)})." for name in may_float(gravity)
    )


def support_evidence(w: Writer) -> Iterator[str]:
    """Nothing floats without an excuse."""
    gravity = w.scene.situation.gravity
    if gravity is not None:
        yield from (f"evidence(\\+ violated(floats({w.names.atom(name)})))." for name in may_float(gravity))


def may_float(gravity: Gravity) -> list[str]:
    """Those that float in some assignment of present/1."""
    return [
        foot.id
        for foot in gravity.feet
        if (gravity.lower(foot.id) if gravity.ground is None else GROUND not in gravity.holders(foot.id))
    ]


VIEWS = {"inside": "inside_image", "cut": "cut_by_image"}


def whereabouts(w: Writer) -> Iterator[str]:
    """One line a hypothesis, one a pair that can be together, then who is over whom."""
    situation = w.scene.situation
    space, known = situation.space, {body.id: body for body in situation.space.bodies}
    yield "% Space: the middles of bodies and their nearest places to the camera, metres, camera frame; then the gaps between two, and up."
    bodies = [known.get(h.id) or _point(h) for h in situation.hypotheses if h.id not in situation.withheld]
    yield from (_body(w, body) for body in bodies)
    yield from (f"body_gap({w.atoms(x, y)}, {coordinate(gap)})." for x, y, gap in space.gaps)
    yield from (
        f"body_gap({w.atoms(x.id, y.id)}, {coordinate(math.dist(x.middle, y.middle))})."
        for x, y in combinations(bodies, 2)
        if x.id not in known or y.id not in known  # one is a point at its origin: nobody measured the gap
    )
    if space.up is not None:
        yield f"up_direction({', '.join(coordinate(x) for x in space.up)}). % from: {space.up_from}"
    yield from (w.fact("body_over", *pair) for pair in space.above)
    yield from (w.fact("body_on", *pair) for pair in space.on)
    yield from (w.fact("body_on_both", *three) for three in space.on_both)
    yield from (f"% overlap({w.atoms(s.x, s.y)}): {words_of_shared(s)}" for s in space.shared)
    yield from holds(w)


def _point(h: Hypothesis) -> BodyFact:
    x, y, z = h.camera_from_object[:3, 3].tolist()
    return BodyFact(h.id, (x, y, z), math.hypot(x, y, z), "outside")


def _body(w: Writer, body: BodyFact) -> str:
    """``body_middle(h1, 0.1, 0.0, 0.9). body_nearest(h1, 0.85). inside_image(h1).``."""
    name, at = w.names.atom(body.id), ", ".join(map(coordinate, body.middle))
    facts = f"body_middle({name}, {at}). body_nearest({name}, {coordinate(body.nearest)})."
    return f"{facts} {w.fact(VIEWS[body.view], body.id)}" if body.view in VIEWS else facts


def geometry(w: Writer, *, data: bool = True) -> Iterator[str]:
    """Layer 2: poses, one line a feature, Γ (``data``: what is in it, too), and relations of pairs."""
    for h in w.scene.situation.hypotheses:
        yield ""
        known = h.id not in w.scene.situation.withheld
        yield from [_position(w, h)] * known
        yield from (_feature(w, h, f, placed=known) for f in h.features)
    yield from _data(w, told=data)
    yield from _pairs(w)
    yield from whereabouts(w)


def _position(w: Writer, h: Hypothesis) -> str:
    origin, name = h.camera_from_object[:3, 3].tolist(), w.names.atom(h.id)
    return f"at({name}, {', '.join(map(coordinate, origin))}). distance({name}, {coordinate(math.hypot(*origin))})."


def _feature(w: Writer, h: Hypothesis, f: FeatureFact, *, placed: bool) -> str:
    facts = [f"at({w.node(h, f.id)}, {', '.join(coordinate(x) for x in f.at)})."] if placed else []
    flags = (("in_image", f.in_image), ("in_lobe", f.in_lobe), ("self_hidden", f.self_hidden))
    facts += [w.fact(name, h.id, f.id) for name, holds in flags if holds]
    facts += [w.fact("behind_surface", h.id, f.id, g) for g in f.hidden_by if g != h.id]
    if f.match is not None:
        facts.append(w.fact("match", h.id, f.id, f.match))
    return " ".join(facts)


def _data(w: Writer, *, told: bool) -> Iterator[str]:
    """Γ, where it is ``told``.

    Who is preferred where several candidate features are matched to one appearance: the smaller residual, then the
    order of Δh.
    """
    yield ""
    yield "% Γ: appearance, type."
    for a in w.scene.situation.appearances:
        if told:
            yield w.fact("datum", a.id, a.type)
        claimants = sorted(
            w.scene.claimants.get(a.id, ()), key=lambda c: math.inf if c[1].residual is None else c[1].residual
        )
        nodes = [w.node(h, f.id) for h, f in claimants]
        for i, first in enumerate(nodes):
            yield from (f"preferred({w.names.atom(a.id)}, {first}, {second})." for second in nodes[i + 1 :])


def _pairs(w: Writer) -> Iterator[str]:
    situation = w.scene.situation
    yield ""
    for name, pairs in (
        ("overlap", situation.overlaps),
        ("rival_pair", situation.rivals),
        ("exclusive", situation.exclusive),
    ):
        yield from (w.fact(name, x, y) for x, y in _once(w, pairs))
    for r in situation.relations:
        yield from _relation(w, r, ("outline_relation", "outline_roc"), *(w.names.atom(name) for name in (r.x, r.y)))
    for r in situation.part_relations:
        x, y = (
            w.node(w.scene.by_id[name], part) if part else w.names.atom(name)
            for name, part in zip((r.x, r.y), r.parts, strict=True)
        )
        yield from _relation(w, r, ("part_relation", "part_roc"), x, y)


def _relation(w: Writer, r: PairFact, predicates: tuple[str, str], x: str, y: str) -> Iterator[str]:
    """The coarse relation of the ordered pair that it is said of, and the fine ones of both."""
    coarse, fine = predicates
    yield f"{coarse}({w.names.atom(r.relation)}, {x}, {y})."
    pairs = zip(both_ways(r), (f"{x}, {y}", f"{y}, {x}"), strict=False)
    yield from (f"{fine}({w.names.atom(name)}, {pair})." for name, pair in pairs)


def _once(w: Writer, pairs: frozenset[tuple[str, str]]) -> list[tuple[str, str]]:
    """Each unordered pair once, in the order of Δh."""
    order = {h.id: i for i, h in enumerate(w.scene.situation.hypotheses)}
    x_first = {(x, y) if order[x] <= order[y] else (y, x) for x, y in pairs}
    return sorted(x_first, key=lambda pair: (order[pair[0]], order[pair[1]]))


def constraints(w: Writer) -> Iterator[str]:
    """One evidence atom per constraint: none is violated (§8)."""
    situation = w.scene.situation
    for x, y in _once(w, situation.overlaps):
        yield f"evidence(\\+ violated(shares_volume({w.atoms(x, y)})))."
    if situation.reading == "score":
        for x, y in _once(w, situation.exclusive):
            yield f"evidence(\\+ violated(shares_data({w.atoms(x, y)})))."
    yield from support_evidence(w)
