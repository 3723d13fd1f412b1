"""The same scene told otherwise.

In another order, by other names, by a camera that is turned in its plane, among other clutter.
"""

from __future__ import annotations

from dataclasses import replace
from random import Random

import numpy as np

from benchmarks.clutter.types import made
from benchmarks.many.types import with_rates
from geometry.camera import Camera
from sensing.appearance import Appearance, Gamma

WHOLE = 2.0 * np.pi


def shuffled(gamma, seed=0):
    """In another order."""
    return Gamma(gamma.camera, tuple(Random(seed).sample(gamma.appearances, len(gamma.appearances))))  # noqa: S311 - no secret


def other_names(names, letter):
    """Name → another one, of another place in the order of names."""
    mixed = Random(7).sample(range(len(names)), len(names))  # noqa: S311 - no secret
    return {name: f"{letter}{i:03d}" for name, i in zip(names, mixed, strict=True)}


def renamed(kb, types, looks):
    """A knowledge base of ``benchmarks.many.types`` by other names of its types, and of its appearance types."""

    def told(kind):
        at, frames = np.array([f.at for f in kind.features]), np.array([f.rotation for f in kind.features])
        half = np.array([f.appearances[0].lobe.half_angle for f in kind.features])
        return made(types[kind.name], kind.surface, at, frames, [looks[f.type] for f in kind.features], half)

    return with_rates([told(kind) for kind in kb.types], tuple(sorted(looks.values())))


def of_other_looks(gamma, looks):
    """The appearances by other names of their types."""
    return Gamma(gamma.camera, tuple(replace(a, type=looks[a.type]) for a in gamma.appearances))


def turned(gamma, angle):
    """All appearances, turned clockwise about the principal point, and camera_from_camera (4, 4) that goes with it."""
    cos, sin = np.cos(angle), np.sin(angle)
    R, middle = np.array([[cos, -sin], [sin, cos]]), gamma.camera.K[:2, 2]
    pose = np.eye(4)
    pose[:2, :2] = R
    return Gamma(
        gamma.camera, tuple(_bent(a, R @ (np.array(a.uv) - middle) + middle, angle) for a in gamma.appearances)
    ), pose


def quarter_turned(gamma):
    """The image turned clockwise by 90 degrees, as wide as it was high, and camera_from_camera (4, 4)."""
    (fx, _, cx), (_, fy, cy), _ = gamma.camera.K
    last = gamma.camera.height - 1
    camera = Camera(
        gamma.camera.height, gamma.camera.width, np.array([[fy, 0.0, last - cy], [0.0, fx, cx], [0.0, 0.0, 1.0]])
    )
    pose = np.eye(4)
    pose[:2, :2] = [[0.0, -1.0], [1.0, 0.0]]
    return Gamma(camera, tuple(_bent(a, (last - a.uv[1], a.uv[0]), 0.5 * np.pi) for a in gamma.appearances)), pose


def _bent(a, uv, angle):
    arms = tuple(sorted((arm + angle) % WHOLE for arm in a.arms))
    return replace(
        a, uv=(float(uv[0]), float(uv[1])), angle=None if a.angle is None else (a.angle + angle) % WHOLE, arms=arms
    )


def in_a_square(gamma, size=901):
    """The same in a larger image, from which no turn about the principal point, its middle, leads an appearance out."""
    K, middle = gamma.camera.K.copy(), 0.5 * (size - 1)
    off = middle - K[:2, 2]
    K[:2, 2] = middle
    return Gamma(
        Camera(size, size, K),
        tuple(replace(a, uv=(float(a.uv[0] + off[0]), float(a.uv[1] + off[1]))) for a in gamma.appearances),
    )


def among(gamma, names, places, rng):
    """With clutter of some types at ``places`` (N, 2), at any angle."""
    more = [
        Appearance(
            f"more{i}",
            str(rng.choice(names)),
            (float(u), float(v)),
            "made",
            angle=float(angle),
            arms=tuple(float(angle) + step for step in (0.0, 1.0, 2.5)),
        )
        for i, ((u, v), angle) in enumerate(zip(places, rng.uniform(0.0, 3.0, len(places)), strict=True))
    ]
    return Gamma(gamma.camera, (*gamma.appearances, *more))
