"""The occlusion relations of hypotheses, and of their parts, that can be present together (§3.5-3.7).

Of parts those that are objects and have a body (``kb.clouds.cloud``), each with the parts and the whole of every
other hypothesis; parts of one hypothesis are not compared. A part's body is taken alone: what else of its own object
stands before it is not looked at. The relation of two wholes is in ``relations_of``.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

from geometry.visibility.occlusion import PosedSurface, drawn, occlusion
from plogic.facts.situation import pair_facts

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from geometry.camera import Camera
    from geometry.visibility.outline import Area
    from geometry.visibility.roc import Roc
    from kb.surfaces.surface import Surface
    from plogic.facts.hypothesis import Hypothesis
    from plogic.facts.situation import PairFact

MOST_PART_PAIRS = 400
"""Pairs with a part in them that are looked at in one image, those of the first hypotheses first: the nearest to being
accepted."""


class Drawn(NamedTuple):
    """A posed body with its image."""

    surface: PosedSurface
    image: Area


def relations_of(
    posed: Mapping[str, Hypothesis], pairs: Sequence[tuple[str, str]], camera: Camera
) -> tuple[PairFact, ...]:
    """The occlusion relation of each pair of hypotheses that have surfaces, of the ordered pair that it is said of (§3.6)."""
    named = dict.fromkeys(name for pair in pairs for name in pair)
    bodies = {
        name: _drawn(surface, posed[name], camera)
        for name in named
        if (surface := posed[name].object_type.surface) is not None
    }
    some = [(x, y) for x, y in pairs if x in bodies and y in bodies]
    return tuple(fact for x, y in some for fact in pair_facts(_relation(bodies[x], bodies[y], camera), x, y))


def part_relations_of(
    posed: Mapping[str, Hypothesis], pairs: Sequence[tuple[str, str]], camera: Camera
) -> tuple[PairFact, ...]:
    """The same of the first ``MOST_PART_PAIRS`` pairs of nodes of which one at least is a part."""
    nodes = [(x, y, parts) for x, y in pairs for parts in _nodes(posed[x], posed[y])][:MOST_PART_PAIRS]
    asked = dict.fromkeys((name, part) for x, y, parts in nodes for name, part in zip((x, y), parts, strict=True))
    bodies = {(name, part): _drawn(_bodies(posed[name])[part], posed[name], camera) for name, part in asked}
    return tuple(
        fact
        for x, y, (p, q) in nodes
        for fact in pair_facts(_relation(bodies[x, p], bodies[y, q], camera), x, y, (p, q))
    )


def _nodes(x: Hypothesis, y: Hypothesis) -> list[tuple[str, str]]:
    """The pairs of nodes with bodies, but for that of the wholes."""
    return [(p, q) for p in _bodies(x) for q in _bodies(y) if p or q]


def _bodies(posed: Hypothesis) -> dict[str, Surface]:
    kind = posed.object_type
    return ({} if kind.surface is None else {"": kind.surface}) | kind.part_bodies


def _drawn(surface: Surface, posed: Hypothesis, camera: Camera) -> Drawn:
    placed = PosedSurface(surface.vertices, surface.triangles, surface.rays, posed.camera_from_object)
    return Drawn(placed, drawn(placed, camera))


def _relation(x: Drawn, y: Drawn, camera: Camera) -> Roc:
    return occlusion(x.surface, y.surface, camera, images=(x.image, y.image))
