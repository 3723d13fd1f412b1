"""Scoring of ``plogic bench many``, pure.

Which accepted objects stand right, who was missed, how far bodies reach into each other.

* ``Verdict``: what one side made of one scene

An accepted object is right that stands for a true one of its type within 5 degrees and 5 % of its distance, up to
symmetries; each true one is stood for once. Objects less than 40 % visible need not be found; who stands right for one
is no mistake.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations
from typing import TYPE_CHECKING

from benchmarks.clutter.scenes import CAMERA
from benchmarks.many.placing import body_of
from benchmarks.recognition.score import errors_of, matched, pose_right
from geometry.bodies.overlap import reach

if TYPE_CHECKING:
    from collections.abc import Sequence

    import numpy as np
    from numpy.typing import NDArray

    from benchmarks.recognition.score import Found, Truth
    from kb.clouds.cloud import KnowledgeBase, ObjectType

    Floats = NDArray[np.float64]

IN_VIEW = 0.4
"""Visible share from which an object must be found."""


@dataclass(frozen=True)
class Seen:
    """An object that must be found.

    Its type, how much of it shows, and by how many radians the one that stands for it is turned, None for nobody.
    """

    type: str
    fraction: float
    turned: float | None


@dataclass(frozen=True)
class Verdict:
    """``seen``: who must be found.

    Of the ``accepted`` objects so many are ``right``, and of so many of the others only the type is.
    """

    seen: tuple[Seen, ...]
    accepted: int
    right: int
    askew: int


def verdict(found: Sequence[Found], truths: Sequence[Truth]) -> Verdict:
    """Of one scene."""
    pairs = matched(found, truths, CAMERA)
    right = {j: errors_of(found[i], truths[j])[0] for i, j in pairs if pose_right(found[i], truths[j])}
    seen = tuple(Seen(t.type, t.fraction, right.get(j)) for j, t in enumerate(truths) if t.fraction >= IN_VIEW)
    return Verdict(seen, len(found), len(right), len(pairs) - len(right))


def deepest(found: Sequence[Found], kb: KnowledgeBase) -> float:
    """Metres by which two of these bodies reach into each other, at most (A4)."""
    return max(
        (
            depth(kb.type(a.type), a.camera_from_object, kb.type(b.type), b.camera_from_object)
            for a, b in combinations(found, 2)
        ),
        default=0.0,
    )


def depth(kind: ObjectType, pose: Floats, other: ObjectType, at: Floats) -> float:
    """Metres by which two bodies reach into each other: the least width of the volume that they share.

    0 where they share none.
    """
    found = reach(body_of(kind), pose, body_of(other), at)
    return 0.0 if found is None else found.depth
