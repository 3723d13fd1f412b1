"""Angles on the screen: radians, clockwise from +x."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from geometry.arrays import Floats, Indices


def wrapped(angle: Floats) -> Floats:
    """The same angles, radians, between −π and π."""
    return np.asarray(angle - 2.0 * np.pi * np.rint(angle / (2.0 * np.pi)))


def screen_angle(direction: Floats, at: Floats) -> Floats:
    """Angle on the screen, radians clockwise from +x, of a direction (…, 3) in space at a place (…, 3), both in the camera's frame."""
    du = direction[..., 0] * at[..., 2] - at[..., 0] * direction[..., 2]
    dv = direction[..., 1] * at[..., 2] - at[..., 1] * direction[..., 2]
    return np.asarray(np.arctan2(dv, du))


def part_of_circle(angle: Floats, parts: int) -> Indices:
    """In which of so many equal parts of the circle, from 0, each angle lies."""
    return np.asarray(np.floor(np.mod(angle, 2.0 * np.pi) / (2.0 * np.pi) * parts).astype(np.intp) % parts)
