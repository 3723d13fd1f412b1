"""Sequences of synthetic views of the two towers.

``views([0, 40, 0])`` turns the camera about the vertical by so many degrees.
"""

from __future__ import annotations

from functools import cache

import numpy as np
from scipy.spatial.transform import Rotation
from synthetic import CAMERA, MIDDLE, perceiver, scene, upright

from geometry.frames import inverse, look_at
from plogic.cycle.delta import Options
from plogic.sequence.constancy.sight_lines import View
from plogic.sequence.views.panorama import Panorama

POSTERIOR = Options(reading="posterior")
BESIDE = {"t1": upright(-0.9, 0.0, 0.3), "t2": upright(0.9, 0.2, 1.1)}
"""world_from_object of two towers of which neither hides the other from the front."""
EYE = np.array([0.0, -6.0, 2.2])


def turned(degrees, eye=EYE, target=MIDDLE):
    """world_from_camera of one that looks at the towers, turned by so much about the vertical."""
    pose = inverse(look_at(eye, target))
    pose[:3, :3] = Rotation.from_rotvec([0.0, 0.0, np.radians(degrees)]).as_matrix() @ pose[:3, :3]
    return pose


def view(number, world_from_camera, there=BESIDE, seed=0, **more):
    """What the camera detects of what is there."""
    rng = np.random.default_rng([seed, number])
    shot = scene(rng, {name: inverse(world_from_camera) @ pose for name, pose in there.items()}, **more)
    return View(f"v{number}", shot.gamma, world_from_camera)


def panorama():
    """An empty Δp."""
    return Panorama(perceiver(), POSTERIOR)


@cache
def away_and_back(seed=0):
    """Δp, and what each look came to: at the towers, past them, away, and back; not quite from the same place."""
    known = panorama()
    poses = [turned(0.0), turned(15.0), turned(80.0), turned(1.0, EYE + np.array([0.1, 0.05, 0.0]))]
    looks = [known.look(view(n, pose, seed=seed)) for n, pose in enumerate(poses, 1)]
    return known, looks


def events(look):
    return [step["event"] for step in look.interpretation["trace"]]


__all__ = ["BESIDE", "CAMERA", "EYE", "POSTERIOR", "away_and_back", "events", "panorama", "turned", "view"]
