"""The facts of space in the program's layer 2: middles, distances, who is over and on whom, which way is up.

A hypothesis whose body nobody described is a point at its origin.
"""

from __future__ import annotations

import math
from itertools import combinations
from typing import TYPE_CHECKING

from plogic.facts.spatial import BodyFact, words_of_shared
from plogic.scene.text.layout import coordinate
from plogic.scene.text.support_text import holds

if TYPE_CHECKING:
    from collections.abc import Iterator

    from plogic.facts.hypothesis import Hypothesis
    from plogic.scene.text.layout import Writer

VIEWS = {"inside": "inside_image", "cut": "cut_by_image"}


def whereabouts(w: Writer) -> Iterator[str]:
    """One line a hypothesis, one a pair that can be together, then who is over whom."""
    situation = w.scene.situation
    space, known = situation.space, {body.id: body for body in situation.space.bodies}
    yield "% Space: the middles of bodies and their nearest places to the camera, metres, camera frame; then the gaps between two, and up."
    bodies = [known.get(h.id) or _point(h) for h in situation.hypotheses]
    yield from (_body(w, body) for body in bodies)
    yield from (f"body_gap({w.atoms(x, y)}, {coordinate(gap)})." for x, y, gap in space.gaps)
    yield from (
        f"body_gap({w.atoms(x.id, y.id)}, {coordinate(math.dist(x.middle, y.middle))})."
        for x, y in _unmeasured(bodies, known)
    )
    if space.up is not None:
        yield f"up_direction({', '.join(coordinate(x) for x in space.up)}). % from: {space.up_from}"
    yield from (w.fact("body_over", *pair) for pair in space.above)
    yield from (w.fact("stands_on", *pair) for pair in space.on)
    yield from (w.fact("stands_on_both", *three) for three in space.on_both)
    yield from (f"% overlap({w.atoms(s.x, s.y)}): {words_of_shared(s)}" for s in space.shared)
    yield from holds(w)


def _point(h: Hypothesis) -> BodyFact:
    x, y, z = h.camera_from_object[:3, 3].tolist()
    return BodyFact(h.id, (x, y, z), math.hypot(x, y, z), "outside")


def _body(w: Writer, body: BodyFact) -> str:
    """``body_middle(h1, 0.1, 0.0, 0.9). body_nearest(h1, 0.85). inside_image(h1).``."""
    at = ", ".join(coordinate(x) for x in body.middle)
    facts = f"body_middle({w.names.atom(body.id)}, {at}). body_nearest({w.names.atom(body.id)}, {coordinate(body.nearest)})."
    return f"{facts} {w.fact(VIEWS[body.view], body.id)}" if body.view in VIEWS else facts


def _unmeasured(bodies: list[BodyFact], known: dict[str, BodyFact]) -> Iterator[tuple[BodyFact, BodyFact]]:
    """Pairs of which one is a point at its origin: nobody measured the gap."""
    return ((x, y) for x, y in combinations(bodies, 2) if x.id not in known or y.id not in known)
