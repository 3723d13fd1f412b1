"""Turns that leave a shape as it is, sought about the axes of its box; a texture may break them, so they are only proposed.

Vocabulary: ``Turn``, ``Turn(axis=(0, 0, 1), at=(0, 0, 0.1), fold=4)``; fold 0 means any turn, as of a can.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from geometry.frames import rotation_from_quat_xyzw
from kb.surfaces.nearness import Nearness, spread

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from kb.surfaces.surface import Surface

    Places = NDArray[np.float64]

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
        quat = [*(math.sin(angle / 2) * axis), math.cos(angle / 2)]
        turned = (probes - centre) @ rotation_from_quat_xyzw(quat).T + centre
        return bool(np.quantile(there.distance(turned), 0.95) <= near)

    if all(stays(angle) for angle in ODD):
        return 0
    if not stays(math.pi):
        return None
    return 4 if stays(math.pi / 2) else 2


def _boxes(surface: Surface) -> list[tuple[Places, Places]]:
    """The axes (3, 3), a row each, and the centre (3,): of the box along the frame's axes, and of the least one, the likelier first."""
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
