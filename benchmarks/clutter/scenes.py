"""The trials of ``plogic bench clutter``: Γ of one object among clutter, with its truth.

* ``Case``: what a row of the table is about, ``Case(EASY, types=100, appearance_types=300)``
* ``Trial``: one Γ, what is there, and which datum is whose
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import count
from typing import TYPE_CHECKING

import numpy as np

from benchmarks.clutter.types import APPEARANCES, EASY, HARD, SLACK, Detector
from benchmarks.recognition.score import Truth
from geometry.camera import Camera
from geometry.frames import from_rotation_translation, inverse, rotation_from_quat_xyzw, transform_points
from geometry.visibility.rays import behind
from kb.clouds.lobes import feature_in_lobe
from plogic.match.gamma.grid import screen_angle
from sensing.appearance import Appearance, Gamma

if TYPE_CHECKING:
    from collections.abc import Mapping

    from numpy.typing import NDArray

    from kb.clouds.cloud import KnowledgeBase, ObjectType
    from kb.surfaces.surface import Surface

    Floats = NDArray[np.float64]

CAMERA = Camera(640, 480, np.array([[600.0, 0.0, 320.0], [0.0, 600.0, 240.0], [0.0, 0.0, 1.0]]))
PIXELS = 100.0, 300.0
"""Least and greatest longer side of the box around the object's picture. Smaller ones leave the pose open, as narrower
lobes do (``HALF_ANGLE``)."""
MARGIN = 10.0
"""Pixels between the object's picture and the image's border: noise leads nothing out of it."""
TRIES = 300
"""Places that are tried for one rotation and size."""
ROUNDS = 12
"""Steps in which the distance is found that makes a picture so large."""


@dataclass(frozen=True)
class Case:
    """How well features are seen, of how many types and appearance types, with how many features, in how large a Γ."""

    detector: Detector
    types: int
    appearance_types: int
    features: int = 100
    appearances: int = APPEARANCES

    def __str__(self) -> str:
        """As progress names it."""
        return f"{self.detector.name}, {self.types} types, {self.appearance_types} appearance types"


PLAN = (
    Case(EASY, 100, 300),
    Case(EASY, 100, 100),
    Case(HARD, 100, 300),
    Case(HARD, 100, 100),
    Case(EASY, 1000, 300),
    Case(EASY, 1000, 100),
)


@dataclass(frozen=True, eq=False)
class Trial:
    """``causes``: the index of the feature that each of the object's own data is of, by the datum's id."""

    gamma: Gamma
    truth: Truth
    causes: Mapping[str, int]


def trial(
    kind: ObjectType, kb: KnowledgeBase, detector: Detector, rng: np.random.Generator, appearances: int = APPEARANCES
) -> Trial:
    """One object of a type that has a surface, somewhere in the image, and clutter up to the number of appearances."""
    pose = random_pose(kind, rng)
    at = transform_points(pose, kind.lobes.at)
    seen = np.flatnonzero(visible(kind, pose, kb.f_ref) & (rng.random(len(at)) < detector.hit))
    x_axes = np.array([feature.rotation[:, 0] for feature in kind.features]) @ pose[:3, :3].T
    noise = appearances - len(seen)
    uv = np.concatenate(
        [CAMERA.project(at[seen]) + rng.normal(0.0, detector.sigma, (len(seen), 2)), _anywhere(noise, rng)]
    )
    turned = screen_angle(x_axes[seen], at[seen]) + rng.normal(0.0, detector.turn, len(seen))
    angle = np.concatenate([turned, rng.uniform(0.0, 2.0 * np.pi, noise)]) % (2.0 * np.pi)
    types = [kind.lobes.types[f] for f in seen] + [
        kb.appearance_types[i] for i in rng.integers(len(kb.appearance_types), size=noise)
    ]
    order = rng.permutation(appearances)  # neither the place in Γ nor the id tells whose a datum is
    data = tuple(
        Appearance(f"d{n}", types[i], (float(uv[i, 0]), float(uv[i, 1])), "simulated", angle=float(angle[i]))
        for n, i in enumerate(order)
    )
    causes = {f"d{n}": int(seen[i]) for n, i in enumerate(order) if i < len(seen)}
    return Trial(Gamma(CAMERA, data), _truth(kind, pose), causes)


def random_pose(kind: ObjectType, rng: np.random.Generator) -> Floats:
    """camera_from_object (4, 4): any rotation, any size of ``PIXELS``, wholly in the image."""
    surface = surface_of(kind)
    R, pixels = rotation_from_quat_xyzw(rng.normal(size=4)), rng.uniform(*PIXELS)
    for tried in count(1):
        if tried % TRIES == 0:  # a rod that points at the camera never has so large a picture
            R, pixels = rotation_from_quat_xyzw(rng.normal(size=4)), rng.uniform(*PIXELS)
        pose = _at_size(surface, R, CAMERA.rays(_anywhere(1, rng)[0]), pixels)
        low, high = picture(surface, pose)
        if (low >= MARGIN).all() and (high <= [CAMERA.width - 1 - MARGIN, CAMERA.height - 1 - MARGIN]).all():
            return pose
    raise AssertionError


def _at_size(surface: Surface, R: Floats, ray: Floats, pixels: float) -> Floats:
    """The surface's middle on the ray, so far away that the longer side of its picture's box is ``pixels``."""
    distance = CAMERA.f * surface.diameter / pixels
    for _ in range(ROUNDS):
        pose = from_rotation_translation(R, distance * ray - R @ surface.centre)
        low, high = picture(surface, pose)
        distance *= float((high - low).max()) / pixels
    return pose


def picture(surface: Surface, pose: Floats) -> tuple[Floats, Floats]:
    """Least and greatest pixel (2,) of a posed surface's picture."""
    uv = CAMERA.project(transform_points(pose, surface.vertices))
    return uv.min(axis=0), uv.max(axis=0)


def visible(kind: ObjectType, pose: Floats, f_ref: float) -> NDArray[np.bool_]:
    """(F,) the viewpoint is in the feature's lobe, and the own surface does not hide it."""
    surface = surface_of(kind)
    held = feature_in_lobe(kind.lobes, inverse(pose)[:3, 3], CAMERA.f / f_ref)[0]
    return np.asarray(
        held & ~behind(transform_points(pose, kind.lobes.at), surface.rays, pose, SLACK * surface.diameter)
    )


def _anywhere(count: int, rng: np.random.Generator) -> Floats:
    """Pixels (N, 2), any of the image alike."""
    return rng.uniform(-0.5, [CAMERA.width - 0.5, CAMERA.height - 0.5], (count, 2))


def _truth(kind: ObjectType, pose: Floats) -> Truth:
    surface = surface_of(kind)
    return Truth(kind.name, pose, 1.0, np.stack(picture(surface, pose)), surface.centre, kind.symmetries)


def surface_of(kind: ObjectType) -> Surface:
    """Its surface. Raises ValueError where it has none."""
    if kind.surface is None:
        raise ValueError(f"{kind.name} has no surface")
    return kind.surface
