"""Which hypotheses exclude each other: A4, and claims on the same appearances (§3.1, §4.1).

Rivalry by claims is decided in the world that holds just the two: what one hides of the other is not expected there and
claims nothing. Otherwise a window of the tower in front, taken for a hidden window of the tower behind, would make
rivals of two towers that both stand.
"""

from __future__ import annotations

from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np

from geometry.bodies.overlap import Solid, solid_overlap
from plogic.match.judged.expectation import hidden_by

if TYPE_CHECKING:
    from collections.abc import Sequence

    from geometry.arrays import Floats, Mask
    from kb.surfaces.surface import Surface
    from plogic.facts.hypothesis import Hypothesis

SHARED_VOLUME = 0.02
"""Share of the smaller volume that two estimated poses may have in common before A4 counts as violated: what 2 % of
pose error makes."""
SHARED_CLAIMS = 0.5
"""Share of the smaller claim, in appearances, above which two hypotheses explain the same data, so that only one can be
present."""


@lru_cache(maxsize=256)
def solid_of(surface: Surface) -> Solid:
    """The volume of a type's closed surface, built once a type."""
    return Solid(surface.vertices, surface.triangles)


def overlap(one: Hypothesis, other: Hypothesis) -> bool:
    """A4: whether the two bodies share volume beyond what pose errors make of touching ones.

    Of one that is no solid nobody knows.
    """
    a, b = one.object_type.surface, other.object_type.surface
    if a is None or b is None:
        return False
    apart = np.linalg.norm(_middle(one, a) - _middle(other, b))
    if apart >= 0.5 * (a.diameter + b.diameter):
        return False
    first, second = a.solid, b.solid
    if first is None or second is None:  # refused (kb.surfaces.surface)
        return False
    volume = _shared(first, one.camera_from_object.tobytes(), second, other.camera_from_object.tobytes())
    return bool(volume > SHARED_VOLUME * min(first.volume, second.volume))


@lru_cache(maxsize=4096)
def _shared(first: Surface, pose: bytes, second: Surface, other: bytes) -> float:
    """The volume that two posed bodies share, m³; the cycle asks it of the same pair again and again."""
    poses = (np.frombuffer(some).reshape(4, 4) for some in (pose, other))
    return solid_overlap(solid_of(first), next(poses), solid_of(second), next(poses))


def hidden_among(posed: Hypothesis, others: Sequence[Hypothesis]) -> Mask:
    """(F,) what opaque others hide of a hypothesis; those that A4 excludes beside it hide nothing (D7)."""
    hidden = np.zeros(len(posed.uv), bool)
    for other in others:
        if other is not posed and other.object_type.opaque and not overlap(posed, other):
            hidden |= hidden_by(posed, other)
    return hidden


def apart_on_screen(one: Hypothesis, other: Hypothesis, f: float, margin: float) -> bool:
    """Whether two bodies are sure to stand more than ``margin`` pixels apart in the image (focal length ``f``), by the balls around them.

    Then neither hides anything of the other, shares volume with it, or takes data that it might take.
    """
    spans = []
    for posed in (one, other):
        surface = posed.object_type.surface
        if surface is None:
            return False
        middle, radius = _middle(posed, surface), 0.5 * surface.diameter
        if middle[2] <= 2.0 * radius:
            return False
        spans.append(
            (middle[:2] / middle[2] * f, f * radius * np.linalg.norm(middle) / (middle[2] * (middle[2] - radius)))
        )
    (first, a), (second, b) = spans
    return bool(np.linalg.norm(first - second) > a + b + margin)


def _middle(posed: Hypothesis, surface: Surface) -> Floats:
    """The middle (3,) of the posed bounding box, camera frame."""
    return np.asarray(posed.camera_from_object[:3, :3] @ surface.centre + posed.camera_from_object[:3, 3])


def claims(posed: Hypothesis, beside: Hypothesis | None = None) -> dict[int, float]:
    """The data that its expected features take, with the residual in pixels; ``beside`` stands in the same world."""
    mine = posed.candidate & posed.detected
    if beside is not None and beside.object_type.opaque:
        mine = mine & ~hidden_by(posed, beside)
    return {int(posed.matches[f]): float(posed.residual[f]) for f in np.flatnonzero(mine)}


def shared_claims(one: Hypothesis, other: Hypothesis) -> tuple[set[int], float]:
    """The data that both claim in their common world, and their share of the smaller claim."""
    mine, theirs = claims(one, other), claims(other, one)
    both = set(mine) & set(theirs)
    return both, len(both) / max(1, min(len(mine), len(theirs)))


def excludes(one: Hypothesis, other: Hypothesis) -> bool:
    """Whether no world holds both: A4, or they explain the same data."""
    return overlap(one, other) or shared_claims(one, other)[1] > SHARED_CLAIMS
