"""Views of points on a body: ``views_of(points, ...)``; a datum's id says nothing, ``causes`` whose it is."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from geometry.camera import Camera
from geometry.frames import inverse, look_at, transform_points
from kb.clouds.cloud import Rates
from plogic.sequence.constancy.sight_lines import View
from sensing.appearance import Appearance, Gamma

CAMERA = Camera(640, 480, np.array([[600.0, 0.0, 320.0], [0.0, 600.0, 240.0], [0.0, 0.0, 1.0]]))
TYPES = ("p", "q", "r", "s")
RATES = Rates(hit=dict.fromkeys(TYPES, 0.8), clutter=dict.fromkeys(TYPES, 4.0), prior={}, sigma=1.0)


def ring(count, step=18.0, radius=1.2, height=0.6):
    """world_from_camera of each view, looking at the middle."""
    turns = np.radians(step) * np.arange(count)
    eyes = np.stack([radius * np.cos(turns), radius * np.sin(turns), np.full(count, height)], axis=1)
    return [inverse(look_at(eye, np.array([0.0, 0.0, 0.1]))) for eye in eyes]


def views_of(points, frames, rng, *, sigma=1.0, hit=1.0, clutter=0):
    """Views, and by view the number of the point that each datum is of. The types of points go round."""
    views, causes = [], {}
    for n, frame in enumerate(frames, 1):
        uv = CAMERA.project(transform_points(inverse(frame), points)) + rng.normal(0.0, sigma, (len(points), 2))
        rows = [(TYPES[i % len(TYPES)], uv[i], i) for i in range(len(points)) if rng.random() < hit]
        rows += [(TYPES[int(rng.integers(len(TYPES)))], rng.uniform(0.0, [639.0, 479.0]), None) for _ in range(clutter)]
        rows = [rows[i] for i in rng.permutation(len(rows)) if CAMERA.contains(rows[i][1])]
        data = tuple(
            Appearance(f"a{i}", kind, (float(at[0]), float(at[1])), "made") for i, (kind, at, _) in enumerate(rows)
        )
        views.append(View(f"v{n}", Gamma(CAMERA, data), frame))
        causes[f"v{n}"] = {f"a{i}": cause for i, (_, _, cause) in enumerate(rows) if cause is not None}
    return views, causes


def all_of(views):
    """Nothing is explained."""
    return {view.id: [a.id for a in view.gamma.appearances] for view in views}


def without(view, gone):
    """The view without some data."""
    return replace(view, gamma=Gamma(CAMERA, tuple(a for a in view.gamma.appearances if a.id not in gone)))


def blob(rng, count=24, middle=(0.0, 0.0, 0.1), size=0.06):
    """(N, 3) points of one body."""
    return np.array(middle) + rng.uniform(-size, size, (count, 3))
