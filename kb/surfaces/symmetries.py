"""Symmetries of a type: the group (S, 4, 4) of rigid motions of the author's list, and the list of a group."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from geometry.frames import (
    from_rotation_translation,
    motion_about,
    quat_xyzw_from_rotation,
    rotation_angle,
    rotation_from_quat_xyzw,
    turn_about,
)
from kb.surfaces.nearness import Nearness, spread

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import ArrayLike, NDArray

    from kb.files.schema import SymmetryModel
    from kb.surfaces.surface import Surface

    Places = NDArray[np.float64]

CONTINUOUS = 72
"""Turns that stand for any turn about an axis: one every 5 deg."""
MOST = 400
"""A group of more motions is a mistake: turns that do not close."""
SAME = 1e-6
"""Motions whose entries differ by less are one, where a group is written."""
CLOSES = 1e-3
"""The same of products of what an author listed, whose six digits do not close any better (rad, m); fold 360 turns by
0.017."""


def motions(symmetries: Sequence[SymmetryModel]) -> NDArray[np.float64]:
    """The group (S, 4, 4) of all products of the motions listed, the identity first.

    Raises:
        ValueError: for a list that makes more than ``MOST`` motions.
    """
    group = [np.eye(4)]
    steps = [_generator(symmetry) for symmetry in symmetries]
    for made in group:  # it grows while we go through it
        for step in steps:
            motion = step @ made
            if np.abs(np.array(group) - motion).max(axis=(1, 2)).min() > CLOSES:
                group.append(motion)
        if len(group) > MOST:
            raise ValueError(f"these make more than {MOST} motions: their turns do not close")
    return np.array(group)


def _generator(symmetry: SymmetryModel) -> NDArray[np.float64]:
    at = np.array(symmetry.at)
    if symmetry.axis is None:
        return np.asarray(from_rotation_translation(rotation_from_quat_xyzw(symmetry.quat_xyzw or (0, 0, 0, 1)), at))
    return motion_about(symmetry.axis, at, 2.0 * math.pi / (symmetry.fold or CONTINUOUS))


def symmetry_entries(group: ArrayLike) -> list[dict[str, Any]]:
    """What an author would list for ``group`` (S, 4, 4).

    Nothing, one axis with its fold, or every motion but the identity.
    """
    moves = [motion for motion in np.asarray(group, dtype=float) if np.abs(motion - np.eye(4)).max() > SAME]
    return _turns(moves) or [_motion(motion) for motion in moves]


def symmetry_words(group: ArrayLike) -> str:
    """``group`` (S, 4, 4) for people: ``no symmetry``, ``2-fold symmetry``; the identity is none."""
    number = len(np.asarray(group))
    if number <= 1:
        return "no symmetry"
    about = [motion[:3, :3] for motion in np.asarray(group, dtype=float)[1:]]
    axes = [np.asarray(quat_xyzw_from_rotation(turn))[:3] for turn in about]
    one_axis = np.linalg.matrix_rank(np.array(axes), tol=CLOSES) == 1
    if one_axis and number == CONTINUOUS:
        return "symmetric in any turn about an axis"
    return f"{number}-fold symmetry" if one_axis else f"{number} symmetric poses"


def _turns(moves: Sequence[NDArray[np.float64]]) -> list[dict[str, Any]]:
    """One axis through the origin, where all motions are turns about it by multiples of one angle."""
    smallest = min(moves, key=lambda motion: float(rotation_angle(motion[:3, :3])), default=None)
    if smallest is None:
        return []
    fold, quat = len(moves) + 1, np.asarray(quat_xyzw_from_rotation(smallest[:3, :3]))
    size = float(np.linalg.norm(quat[:3]))
    if size < SAME or not 2 <= fold <= 360:
        return []
    axis = quat[:3] / size
    axis = axis * (np.sign(axis[np.abs(axis) > SAME][-1]))
    turn = from_rotation_translation(turn_about(axis, 2.0 * math.pi / fold), np.zeros(3))
    wanted = [np.linalg.matrix_power(turn, power) for power in range(1, fold)]
    if all(min(np.abs(motion - power).max() for power in wanted) < SAME for motion in moves):
        return [{"axis": [float(x) for x in axis], "fold": fold}]
    return []


def _motion(motion: NDArray[np.float64]) -> dict[str, Any]:
    quat = np.asarray(quat_xyzw_from_rotation(motion[:3, :3]))
    return {"quat_xyzw": [float(x) for x in quat], "at": [float(x) for x in motion[:3, 3]]}


PROBES = 1500
"""Points of the surface that a turn is tried on."""
NEAR = 0.025
"""What 95 of 100 of them may be off the surface after the turn, as a share of the diameter: real boxes bulge."""
ODD = (math.radians(37), math.radians(101), math.radians(161))
"""Turns by these leave a round body as it is, and hardly any other."""
SMALLER = 0.97
"""A box that has this share of the volume of the box along the frame's axes is the likelier one."""
ALIGNED = math.cos(math.radians(3))
"""Axes of the box that are this near to the frame's are the frame's."""


@dataclass(frozen=True)
class Turn:
    """A symmetry about the line through ``at`` (m) along unit ``axis``: a full turn has ``fold`` of it; 0, any turn."""

    axis: tuple[float, ...]
    at: tuple[float, ...]
    fold: int

    def __str__(self) -> str:
        kind = f"fold: {self.fold}" if self.fold else "continuous: true"
        return f"{{axis: {_row(self.axis)}, {kind}, at: {_row(self.at)}}}"


def _row(values: tuple[float, ...]) -> str:
    return "[" + ", ".join(f"{round(value, 6) + 0.0:g}" for value in values) + "]"


def turns_of(surface: Surface) -> list[Turn]:
    """The turns found about the three axes of the shape's box, of 180 deg, of 90 deg, or any."""
    there = Nearness(surface.vertices, surface.triangles)
    probes = spread(surface.vertices, surface.triangles, PROBES)[0]
    probes = probes[:: max(1, len(probes) // PROBES)]
    for axes, centre in _boxes(surface):
        folds = [_fold(there, probes, centre, axis, NEAR * surface.diameter) for axis in axes]
        found = [
            Turn(tuple(axis.tolist()), tuple(centre.tolist()), fold)
            for axis, fold in zip(axes, folds, strict=True)
            if fold is not None
        ]
        if found:
            return found
    return []


def _fold(there: Nearness, probes: Places, centre: Places, axis: Places, near: float) -> int | None:
    def stays(angle: float) -> bool:
        turned = (probes - centre) @ turn_about(axis, angle).T + centre
        return bool(np.quantile(there.distance(turned), 0.95) <= near)

    if all(stays(angle) for angle in ODD):
        return 0
    if not stays(math.pi):
        return None
    return 4 if stays(math.pi / 2) else 2


def _boxes(surface: Surface) -> list[tuple[Places, Places]]:
    """The axes (3, 3), a row each, and the centre (3,).

    Of the box along the frame's axes, and of the least one, the likelier first.
    """
    from trimesh import bounds

    obb: Any = bounds.oriented_bounds
    plain = np.eye(3), surface.centre
    try:
        box_from_object, sides = obb(surface.vertices)
    except Exception:  # noqa: BLE001 - Qhull's and trimesh's own, for flat shapes
        return [plain]
    axes = np.array(box_from_object[:3, :3])
    axes *= np.sign(axes[np.arange(3), np.abs(axes).argmax(axis=1)])[:, None]
    if (np.abs(axes).max(axis=1) > ALIGNED).all():
        return [plain]
    least = axes, np.asarray(np.linalg.inv(box_from_object)[:3, 3])
    return [plain, least] if np.prod(sides) > SMALLER * np.prod(np.ptp(surface.vertices, axis=0)) else [least, plain]
