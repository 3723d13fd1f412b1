"""Observations of straight edges that nobody saw, and of keypoints near them, for tests of learning sides of edges."""

from __future__ import annotations

from dataclasses import fields, replace

import numpy as np
from random_cloud import unit

from geometry.cones import even_directions
from kb.learning.again import BYTES, LOOKS
from kb.learning.observations import Observations

COUNT, DIAMETER, F_REF = 600, 0.2, 600.0
PIXEL = DIAMETER / 300.0
COLOURS = (90, 140, 95, 135)
CONTRAST = 150
"""Brightness against what is beyond the edge."""


def towards(axis, within):
    """Numbers of the ``even_directions(COUNT)`` within so many degrees of an axis."""
    return np.flatnonzero(even_directions(COUNT) @ unit(np.asarray(axis, float)) >= np.cos(np.radians(within)))


def an_edge(rng, views, times=1, *, along=0.0, across=0.0, middle=(0.0, 0.0, 0.0), levels=(0,), colours=COLOURS):
    """``times`` points of an edge along x in the plane z = 0 in each picture, whose side is towards +y.

    They lie up to ``along`` metres from the middle, with a standard deviation of ``across`` beside the edge.
    """
    view, level = (np.repeat(some.ravel(), times) for some in np.meshgrid(views, levels))
    count = len(view)
    direction = even_directions(COUNT)[view]
    up = np.array([0.0, 1.0, 0.0])
    off = np.column_stack([rng.uniform(-along, along, count), rng.normal(0.0, across, count), np.zeros(count)])
    descriptor = np.zeros((count, BYTES), np.float32)
    descriptor[:, LOOKS] = [*colours, CONTRAST]
    return Observations(
        at=np.asarray(middle) + off,
        normal=np.tile([0.0, 0.0, 1.0], (count, 1)),
        direction=direction,
        up=unit(up - (direction @ up)[:, None] * direction),
        size=np.zeros(count),
        pixel=np.full(count, PIXEL),
        view=view.astype(np.int64),
        level=level.astype(np.int64),
        hit=np.ones(count),
        descriptor=descriptor,
    )


def keypoints(rng, views, places=4):
    """Some places that are keypoints in every picture."""
    at = rng.uniform(-0.3 * DIAMETER, 0.3 * DIAMETER, (places, 3))
    which = np.tile(np.arange(places), len(views))
    edge = an_edge(rng, views, places)
    descriptor = rng.integers(0, 200, (places, 138)).astype(np.float32)
    return replace(
        edge,
        at=at[which],
        size=np.full(len(which), 5 * PIXEL),
        hit=rng.uniform(0.5, 1.0, len(which)),
        descriptor=descriptor[which],
    )


def some_of(seen, rows):
    """The observations of these rows, in their order."""
    return replace(seen, **{f.name: getattr(seen, f.name)[rows] for f in fields(seen)})
