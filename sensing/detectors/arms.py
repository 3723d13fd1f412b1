"""Arms that no segment showed: directions from a place along which the brightness differs steadily from one side to the other."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from sensing.detectors.edges import sample
from sensing.detectors.meetings import distinct

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Floats = NDArray[np.float64]

DIRECTIONS = 120
RADII = np.arange(5.0, 15.0)
SIDE = 1.8
"""Pixels to either side of the ray at which brightness is compared."""
FAR_SIDE, SHARPNESS = 4.0, 0.75
"""At an edge most of the difference at 4 px is there at 1.8 px already; on a slope it is not."""
MIN_STEP = 10.0
"""Grey levels by which the sides differ in the mean."""
LEAST = 0.7
"""Share of the step that each third of the ray shows at least."""
APART = np.radians(22.0)
"""An arm is not sought nearer than this to another."""


def steps(grey: NDArray[np.float32], places: Floats) -> tuple[Floats, Floats]:
    """Along each ray from (N, 2) places: how much its sides differ in the mean (N, D), and in the third where they differ least (N, D).

    The latter is 0 where the brightness slopes instead of stepping.
    """
    angle = np.arange(DIRECTIONS) * (2 * np.pi / DIRECTIONS)
    ray = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    across = np.stack([-ray[:, 1], ray[:, 0]], axis=1)
    on = places[:, None, None] + RADII[None, None, :, None] * ray[None, :, None]
    near, far = (_difference(grey, on, reach * across) for reach in (SIDE, FAR_SIDE))
    mean = near.mean(axis=2)
    thirds = np.stack([part.mean(axis=2) for part in np.array_split(near, 3, axis=2)], axis=2)
    least = (thirds * np.sign(mean)[:, :, None]).min(axis=2)
    sharp = np.abs(mean) >= SHARPNESS * np.abs(far.mean(axis=2))
    return np.abs(mean), np.where(sharp, least, 0.0)


def _difference(grey: NDArray[np.float32], on: Floats, across: Floats) -> Floats:
    return (sample(grey, on + across[None, :, None]) - sample(grey, on - across[None, :, None])).astype(np.float64)


def completed(step: Floats, least: Floats, arms: Floats, lengths: Floats) -> tuple[Floats, Floats]:
    """Arms (k,) with those added that the steps (D,) of one place show, the strongest first; an added arm is as long as was looked at."""
    angle = np.arange(DIRECTIONS) * (2 * np.pi / DIRECTIONS)
    peak = (step >= np.roll(step, 1)) & (step > np.roll(step, -1)) & (step >= MIN_STEP) & (least >= LEAST * step)
    wide = round(APART / (2 * np.pi / DIRECTIONS))
    peak &= step > 1.3 * np.maximum(np.roll(step, wide), np.roll(step, -wide))
    for k in np.flatnonzero(peak)[np.argsort(-step[peak], kind="stable")]:
        if np.all(np.abs(np.angle(np.exp(1j * (arms - angle[k])))) > APART):
            arms, lengths = np.append(arms, angle[k]), np.append(lengths, RADII[-1])
    return distinct(arms, lengths)
