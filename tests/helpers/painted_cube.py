"""A cube with a different picture on each face, as a mesh, as files, as learned observations, and as a knowledge base.

For tests of learning.
"""

from __future__ import annotations

from contextlib import contextmanager
from dataclasses import replace
from functools import cache

import numpy as np
from made_meshes import QUADS, obj_text, split_box

from geometry.camera import Camera
from geometry.cones import even_directions
from geometry.frames import look_at
from kb.clouds.learned import cloud_bytes
from kb.clouds.words import worded, words_bytes
from kb.learning import features, observations
from kb.learning.observations import AWAY, MARGIN
from sensing.detectors.keypoint_detector import described
from sensing.pixels.turntable import turned
from sensing.simulated.body import Body, TexturedMesh
from sensing.simulated.camera import Sensor, render
from sensing.simulated.surroundings import Light, Surroundings

SIDE = 0.1
"""Metres."""
TILE = 160
"""Pixels of a face's picture."""
PIXELS = (160.0, 115.0, 80.0)
"""Sizes of the pictures that tests learn from: few and small."""
COUNT = 50
"""Directions, of which tests look from some."""
F_REF = 600.0


@cache
def paint(seed=5):
    """(2 * TILE, 3 * TILE, 3) uint8: one tile a face, of bright and dark spots of all sizes."""
    rng = np.random.default_rng(seed)
    return np.concatenate([np.concatenate([_tile(rng) for _ in range(3)], axis=1) for _ in range(2)])


def _tile(rng):
    import cv2

    tile = np.full((TILE, TILE, 3), 128, np.uint8)
    for radius in np.repeat([26, 14, 8, 5, 3], [4, 12, 24, 40, 40]):
        place = tuple(int(x) for x in rng.integers(0, TILE, 2))
        colour = tuple(int(x) for x in rng.integers(0, 256, 3))
        if rng.random() < 0.5:
            cv2.circle(tile, place, int(radius), colour, -1)
        else:
            cv2.rectangle(tile, place, (place[0] + 2 * int(radius), place[1] + int(radius)), colour, -1)
    return tile


def cube(side=SIDE, middle=(0.0, 0.0, 0.0)):
    """The cube of ``QUADS``, its middle where asked."""
    vertices, triangles, _ = split_box()
    return TexturedMesh((vertices - 0.5) * side + np.asarray(middle), triangles, _uv(), paint())


def _uv():
    """(24, 2): face i is tile (i // 3, i % 3), half a texel inside of it."""
    inside = np.array([[0.0, 0], [1, 0], [1, 1], [0, 1]]) * (1 - 1 / TILE) + 0.5 / TILE
    return np.concatenate([(inside + np.array([i % 3, i // 3])) / [3, 2] for i in range(len(QUADS))])


def write_cube(folder, units_per_metre=1.0):
    """``cube.obj``, its MTL and its picture."""
    import cv2

    mesh = cube()
    (folder / "cube.obj").write_text(obj_text(mesh.vertices * units_per_metre, mesh.triangles, mesh.uv, "cube.mtl"))
    (folder / "cube.mtl").write_text("newmtl paint\nKd 1 1 1\nmap_Kd cube.png\n")
    cv2.imwrite(str(folder / "cube.png"), mesh.texture)
    return folder / "cube.obj"


@contextmanager
def sizes(pixels=PIXELS):
    """Learning looks at pictures in which the diameter is so large, the largest first."""
    before = observations.PIXELS
    observations.PIXELS = features.PIXELS = pixels
    try:
        yield
    finally:
        observations.PIXELS = features.PIXELS = before


def seen_of(mesh, viewpoints, detector="sift", seed=0):
    """What learning sees of a mesh from these directions, by their numbers among ``even_directions(COUNT)``."""
    numbers = list(viewpoints)
    views = turned(mesh, [even_directions(COUNT)[i] for i in numbers], observations.PIXELS[0], MARGIN, AWAY)

    def detect(image, calm, cell, where, like):
        return described(image, detector, cell=cell, calm=calm, where=where, like=like)

    return observations.joined(
        [observations.observed(view, i, detect, seed) for i, view in zip(numbers, views, strict=True)]
    )


def facing(direction, within):
    """Numbers of the directions that are at most so far (degrees) from this one."""
    near = even_directions(COUNT) @ (np.asarray(direction) / np.linalg.norm(direction)) >= np.cos(np.radians(within))
    return np.flatnonzero(near).tolist()


CORNER = (1.0, 0.8, 0.9)
"""From here three faces are seen; those that tests learn are seen from within 40° of it."""


@cache
def seen(detector="sift"):
    """What is seen of the cube from around ``CORNER``."""
    with sizes():
        return seen_of(cube(), facing(CORNER, 40.0), detector)


def cloud(some, diameter=SIDE * 3**0.5):
    """The cloud of such observations."""
    with sizes():
        return features.cloud_of(some, diameter, F_REF, COUNT)


KB_YAML = """\
name: painted
appearance_types: []
f_ref: 600
words: {file: words.npz}
"""
OBJECT_YAML = """\
object: %s
mesh: {file: cube.obj, units: m}
cloud: {file: cloud.npz}
"""


def write_knowledge(folder, clouds, mesh_of=write_cube):
    """A knowledge base with types of these clouds by name, each with the cube's mesh."""
    words, named = worded(clouds)
    (folder / "kb.yaml").write_text(KB_YAML)
    (folder / "words.npz").write_bytes(words_bytes(words))
    for name, its in named.items():
        place = folder / "objects" / name
        place.mkdir(parents=True)
        mesh_of(place)
        (place / "object.yaml").write_text(OBJECT_YAML % name)
        (place / "cloud.npz").write_bytes(cloud_bytes(its))
    return folder


CAMERA = Camera(400, 300, np.array([[500.0, 0, 199.5], [0, 500.0, 149.5], [0, 0, 1]]))


def picture(poses, seed=0, noise=3.5):
    """(300, 400, 3): painted cubes at camera_from_cube poses before a plain background, not lit as in learning."""
    eye = np.diag([1.0, -1.0, -1.0, 1.0])
    eye[2, 3] = 50.0  # the floor, z = 0, is far behind
    camera = replace(CAMERA, world_from_camera=eye)
    bodies = [Body("cube", cube(), eye @ pose) for pose in poses]
    return render(bodies, camera, Light(), Surroundings(contrast=0, shadow=0), Sensor(noise=noise, seed=seed)).image


def pose_towards(direction, distance, roll=0.0, aside=(0.0, 0.0)):
    """camera_from_cube of a camera in this direction from the cube's middle, turned about its axis, ``aside`` (m)."""
    direction = np.asarray(direction, float) / np.linalg.norm(direction)
    pose = look_at(distance * direction, np.zeros(3))
    c, s = np.cos(roll), np.sin(roll)
    turn = np.array([[c, -s, 0, aside[0]], [s, c, 0, aside[1]], [0, 0, 1, 0], [0, 0, 0, 1]])
    return turn @ pose
