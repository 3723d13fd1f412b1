"""Scoring of recognised objects against the truth, pure: who was found, whose pose is right, what was accepted falsely.

* ``Found``: an accepted object, ``Found("cracker_box", camera_from_object, 0.97)``
* ``Truth``: an object that is there, with its visible fraction and the box of its picture
* ``Tally``: counts of one or many images; they add up

A found object stands for a true one of its type whose picture's box holds the projected centre of the found; each true
one is stood for once, by the nearest pose. A true object less than half visible need not be found: neither is it
counted, nor who stands for it.
"""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import TYPE_CHECKING

import numpy as np

from geometry.frames import inverse, pose_error

if TYPE_CHECKING:
    from collections.abc import Collection, Sequence

    from numpy.typing import NDArray

    from geometry.camera import Camera

ROTATION, TRANSLATION = np.radians(5.0), 0.05
"""A pose is right within so many radians and this share of the distance, up to the type's symmetries."""
HALF = 0.5
"""Visible fraction from which an object counts."""


@dataclass(frozen=True, eq=False)
class Found:
    """An object that was accepted: its type, ``camera_from_object`` (4, 4), and how sure it is."""

    type: str
    camera_from_object: NDArray[np.float64]
    probability: float = 1.0


@dataclass(frozen=True, eq=False)
class Truth:
    """An object that is there.

    Attributes:
        type: Its name.
        camera_from_object: (4, 4).
        fraction: Visible share of its picture.
        box: (2, 2) least and greatest pixel (u, v) of its picture, hidden parts included.
        centre: (3,) m, object frame: the middle of it, from which translations are measured.
        symmetries: (S, 4, 4) its own motions that change nothing, object frame; none for none but the identity.
    """

    type: str
    camera_from_object: NDArray[np.float64]
    fraction: float
    box: NDArray[np.float64]
    centre: NDArray[np.float64]
    symmetries: NDArray[np.float64] | None = None


@dataclass(frozen=True)
class Tally:
    """Counts: true objects that count, those found, those with the right pose, false acceptances, other found ones."""

    there: int = 0
    found: int = 0
    posed: int = 0
    false: int = 0
    extra: int = 0

    def __add__(self, other: Tally) -> Tally:
        """Of both together."""
        return Tally(*(getattr(self, f.name) + getattr(other, f.name) for f in fields(self)))

    @property
    def recall(self) -> float:
        """Share of those that are there that were found; 1 of none."""
        return _share(self.found, self.there)

    @property
    def precision(self) -> float:
        """Share of the found that are there; 1 of none."""
        return _share(self.found, self.found + self.false)

    @property
    def poses(self) -> float:
        """Share of the found whose pose is right; 1 of none."""
        return _share(self.posed, self.found)

    @property
    def f1(self) -> float:
        """Of the identities: twice the found over those there and those reported; 0 where nothing was found."""
        return 2 * self.found / max(self.there + self.found + self.false, 1)

    @property
    def pose_f1(self) -> float:
        """The same of identities with the right pose."""
        return 2 * self.posed / max(self.there + self.found + self.false, 1)


def tally(found: Sequence[Found], truths: Sequence[Truth], camera: Camera, types: Collection[str]) -> Tally:
    """One image's counts of the objects of these types; ``camera`` projects."""
    mine = [f for f in found if f.type in types]
    there = [t for t in truths if t.type in types]
    pairs = matched(mine, there, camera)
    counted = [(mine[i], there[j]) for i, j in pairs if there[j].fraction >= HALF]
    return Tally(
        there=sum(t.fraction >= HALF for t in there),
        found=len(counted),
        posed=sum(pose_right(f, t) for f, t in counted),
        false=len(mine) - len(pairs),
        extra=len(pairs) - len(counted),
    )


def matched(found: Sequence[Found], truths: Sequence[Truth], camera: Camera) -> list[tuple[int, int]]:
    """(index of the found, index of the true one it stands for); the nearest poses first, each used once."""
    errors = []
    for i, f in enumerate(found):
        for j, t in enumerate(truths):
            if f.type == t.type and _inside(f, t, camera):
                turned, moved = errors_of(f, t)
                errors.append((turned / ROTATION + moved / TRANSLATION, i, j))
    pairs: list[tuple[int, int]] = []
    for _, i, j in sorted(errors):
        if all(i != a and j != b for a, b in pairs):
            pairs.append((i, j))
    return pairs


def errors_of(found: Found, truth: Truth) -> tuple[float, float]:
    """Rotation in radians, and translation of the centre as a share of its distance, up to the true symmetries."""
    object_from_centred = np.eye(4)
    object_from_centred[:3, 3] = truth.centre
    symmetries = None
    if truth.symmetries is not None:
        symmetries = inverse(object_from_centred) @ truth.symmetries @ object_from_centred
    true = truth.camera_from_object @ object_from_centred
    turned, moved = pose_error(found.camera_from_object @ object_from_centred, true, symmetries)
    return float(turned), float(moved) / float(np.linalg.norm(true[:3, 3]))


def pose_right(found: Found, truth: Truth) -> bool:
    """Within 5 degrees and 5 % of the distance."""
    turned, moved = errors_of(found, truth)
    return bool(turned <= ROTATION and moved <= TRANSLATION)


def _inside(found: Found, truth: Truth, camera: Camera) -> bool:
    """Whether the found object's centre lies before the camera and within the box of the true one's picture."""
    centre = found.camera_from_object[:3, :3] @ truth.centre + found.camera_from_object[:3, 3]
    if not (np.isfinite(centre).all() and centre[2] > 0):
        return False
    uv = camera.project(centre)
    return bool((uv >= truth.box[0]).all() and (uv <= truth.box[1]).all())


def _share(some: int, of: int) -> float:
    return some / of if of else 1.0
