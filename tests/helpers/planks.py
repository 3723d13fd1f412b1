"""Three planks of a ring, each over the next at one end, and what a camera would detect of ten features of each."""

from __future__ import annotations

from functools import cache

import numpy as np
from box_kb import CAMERA, box_kb, corner_rows, feature_row, seen

from geometry.frames import look_at
from sensing.appearance import Appearance, Gamma

LONG, WIDE = 0.3, 0.03
"""Metres, halves."""
LOOKS = ("sticker", "knob", "screw")
MARKS = ((-0.22, 0.01), (-0.13, -0.015), (-0.05, 0.02), (0.04, -0.02), (0.11, 0.015), (0.2, -0.01), (0.26, 0.02))
"""Where the features of the upper and of the lower face are."""


@cache
def planks(thick):
    """The knowledge base of one type; ``thick``: half of its thickness, m."""
    half = np.array([LONG, WIDE, thick])
    sides = [(x, y, side) for side in (-1, 1) for x, y in MARKS]
    marks = [
        feature_row(f"s{i}", LOOKS[i % 3], (x, y, side * thick), (0, 0, side), 75)
        for i, (x, y, side) in enumerate(sides)
    ]
    return box_kb("plank", half, [*corner_rows(half), *marks])


def _along(origin, x, up=(0.0, 0.0, 1.0)):
    """world_from_object of a plank along ``x``, its upper face towards ``up`` as far as that goes."""
    x = np.array(x) / np.linalg.norm(x)
    z = np.array(up) - (np.array(up) @ x) * x
    z /= np.linalg.norm(z)
    pose = np.eye(4)
    pose[:3, :3], pose[:3, 3] = np.stack([x, np.cross(z, x), z], axis=1), origin
    return pose


def interleaved(seed, thick, slope, noise, count=10):
    """Γ without clutter, and the three poses camera_from_object; ``noise`` in pixels.

    ``slope`` of each: with it neighbours pass each other where they cross.
    """
    rng, world = np.random.default_rng(seed), []
    for turn in 2.0 * np.pi * np.arange(3) / 3.0 + rng.normal(0.0, 0.05, 3):
        side = np.array([-np.sin(turn), np.cos(turn), 0.0])
        world.append(_along(0.11 * side + rng.normal(0.0, (0.004, 0.004, 0.0004)), (np.cos(turn), np.sin(turn), slope)))
    azimuth, up = rng.uniform(0.0, 2.0 * np.pi), np.radians(rng.uniform(50.0, 75.0))
    eye = rng.uniform(1.1, 1.5) * np.array([np.cos(azimuth) * np.cos(up), np.sin(azimuth) * np.cos(up), np.sin(up)])
    poses, data = [look_at(eye, (0.0, 0.0, 0.0)) @ pose for pose in world], []
    for pose in poses:
        rows = seen(planks(thick), pose, poses)
        for k in rng.permutation(len(rows))[:count]:
            feature, uv = rows[k]
            data.append((feature.type, tuple((uv + rng.normal(0.0, noise, 2)).tolist())))
    order = rng.permutation(len(data))
    return Gamma(CAMERA, tuple(Appearance(f"a{i}", *data[k], "made") for i, k in enumerate(order))), poses
