"""Prospects of the two towers, made by hand: who stands where, in which worlds."""

from __future__ import annotations

from functools import cache

import numpy as np

from geometry.camera import Camera
from geometry.frames import inverse, look_at
from kb.files.folder import shipped
from kb.files.read import read_kb
from plogic.sequence.next_view.expected import Body, Cloud, Prospect

CAMERA = Camera(640, 480, np.array([[600.0, 0, 320], [0, 600.0, 240], [0, 0, 1]]))
MIDDLE = np.array([0.0, 0.0, 1.0])


@cache
def towers():
    return read_kb(shipped("towers"))


def cloud_of(kind):
    """How a type of the towers is seen, straight from the knowledge base."""
    hit = np.array([towers().rates.hit[f.type] for f in kind.features])[kind.lobes.feature]
    rays = kind.surface.rays
    names, kinds = tuple(f.name for f in kind.features), tuple(f.type for f in kind.features)
    radius = float(np.linalg.norm(rays.vertices - kind.surface.centre, axis=1).max())
    return Cloud(
        kind.name, names, kinds, kind.lobes, hit, rays, kind.surface.centre, radius, 0.004 * kind.surface.diameter
    )


def body(name, kind, x, y, yaw=0.0, *, opaque=True):
    pose = np.eye(4)
    pose[:2, :2] = [[np.cos(yaw), -np.sin(yaw)], [np.sin(yaw), np.cos(yaw)]]
    pose[:2, 3] = x, y
    return Body(name, cloud_of(towers().type(kind)), pose, opaque)


def prospect(bodies, present, probability, rivals=()):
    rates = towers().rates
    pairs = frozenset(frozenset(pair) for pair in rivals)
    return Prospect(
        tuple(bodies),
        np.array(present, bool),
        np.array(probability),
        pairs,
        rates.clutter,
        rates.match_tolerance,
        towers().f_ref,
    )


def camera_at(x, y, z=2.0, target=MIDDLE):
    """world_from_camera."""
    return inverse(look_at((x, y, z), target))
