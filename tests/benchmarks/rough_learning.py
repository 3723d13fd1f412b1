"""A rough stand-in for ``plogic kb learn``: keypoints of a few rendered views, put back on the surface by rays.

Not clustered.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from benchmarks.tabletop.rgbd_sensor import RgbdSensor
from benchmarks.tabletop.table import Table, photographed
from geometry.camera import Camera
from geometry.frames import inverse, look_at, transform_points
from sensing.detectors.keypoints import keypoints
from sensing.simulated.body import Body
from sensing.simulated.surroundings import Light


@dataclass(frozen=True, eq=False)
class RoughCloud:
    """F places, L descriptors of them."""

    at: np.ndarray
    feature: np.ndarray
    descriptor: np.ndarray


def rough_cloud(mesh, views=12, size=200, supersample=2):
    """``size``: pixels that the mesh's diameter takes."""
    low, high = mesh.vertices.min(axis=0), mesh.vertices.max(axis=0)
    lifted = np.eye(4)
    lifted[:3, 3] = -(low + high) / 2 + (0, 0, 5)
    body = Body("it", mesh, lifted)
    diameter, f = float(np.linalg.norm(high - low)), 600.0
    places, descriptors = [], []
    for i in range(views):
        z, around = 1 - (2 * i + 1) / views, np.pi * (1 + 5**0.5) * i
        side = np.array([np.sqrt(1 - z * z) * np.cos(around), np.sqrt(1 - z * z) * np.sin(around), z])
        eye = np.array([0, 0, 5]) + side * diameter * f / size
        width = round(1.3 * size)
        K = [[f, 0, width / 2], [0, f, width / 2], [0, 0, 1]]
        camera = Camera(width, width, np.array(K), np.zeros(0), inverse(look_at(eye, (0, 0, 5), (0.1, 0.2, 1))))
        light = Light(tuple(side + np.array([0.2, 0.1, 0.3])), ambient=0.5, lamp=0.4, sky=0.1)
        table = Table(floor_pattern="plain", wall_distance=50.0, wall_azimuth=float(around))
        view = photographed([body], camera, light, table, RgbdSensor(noise=1.0), supersample)
        seen = keypoints(view.image)
        pixel = np.clip(np.rint(seen.uv).astype(int), 0, width - 1)
        own = view.segmentation[pixel[:, 1], pixel[:, 0]] == 0
        depth = view.depth[pixel[:, 1], pixel[:, 0]][own]
        points = camera.rays(seen.uv[own])
        points = points / points[:, 2:] * depth[:, None]
        places.append(transform_points(inverse(lifted) @ camera.world_from_camera, points))
        descriptors.append(seen.descriptors[own])
    at = np.concatenate(places)
    return RoughCloud(at, np.arange(len(at)), np.concatenate(descriptors))
