"""Three planks of a ring, each over the next at one end, and what a camera would detect of ten features of each."""

from __future__ import annotations

from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from learned_cube import CUBE

from geometry.camera import Camera
from geometry.frames import inverse, look_at, transform_points
from geometry.visibility.rays import behind
from kb.clouds.lobes import in_lobe
from kb.files.read import read_kb
from sensing.appearance import Appearance, Gamma

CAMERA = Camera(640, 480, np.array([[600.0, 0, 319.5], [0, 600.0, 239.5], [0, 0, 1]]))
LONG, WIDE = 0.3, 0.03
"""Metres, halves."""
LOOKS = ("sticker", "knob", "screw")
MARKS = ((-0.22, 0.01), (-0.13, -0.015), (-0.05, 0.02), (0.04, -0.02), (0.11, 0.015), (0.2, -0.01), (0.26, 0.02))
"""Where the features of the upper and of the lower face are."""
KB = """\
name: planks
appearance_types: [corner, sticker, knob, screw]
f_ref: 600
detector:
  hit: {corner: 0.9, sticker: 0.9, knob: 0.9, screw: 0.9}
  clutter: {corner: 1, sticker: 1, knob: 1, screw: 1}
  sigma: 1.0
  match_tolerance: 4.0
priors: {plank: 0.5}
"""


def _feature(name, look, at, axis, half_angle):
    lobe = f"{{axis: {[float(a) for a in axis]}, half_angle: {half_angle} deg, range: [0.1 m, 9 m]}}"
    place = [float(a) for a in at]
    return f"  - {{feature: {name}, type: {look}, at: {place}, appearances: [{{type: {look}, lobe: {lobe}}}]}}\n"


@cache
def planks(thick):
    """The knowledge base of one type; ``thick``: half of its thickness, m."""
    corners, half = np.sign(CUBE.vertices), np.array([LONG, WIDE, thick])
    rows = [_feature(f"c{i}", "corner", corner * half, corner, 120) for i, corner in enumerate(corners)]
    sides = [(x, y, side) for side in (-1, 1) for x, y in MARKS]
    rows += [
        _feature(f"s{i}", LOOKS[i % 3], (x, y, side * thick), (0, 0, side), 75) for i, (x, y, side) in enumerate(sides)
    ]
    mesh = "".join(f"v {x} {y} {z}\n" for x, y, z in corners * half)
    mesh += "".join(f"f {a + 1} {b + 1} {c + 1}\n" for a, b, c in CUBE.triangles)
    with TemporaryDirectory() as name:
        folder = Path(name) / "objects" / "plank"
        folder.mkdir(parents=True)
        (folder / "mesh.obj").write_text(mesh)
        (folder / "object.yaml").write_text(
            "object: plank\nmesh: {file: mesh.obj, units: m}\nfeatures:\n" + "".join(rows)
        )
        (Path(name) / "kb.yaml").write_text(KB)
        return read_kb(name)


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
    poses, kb = [look_at(eye, (0.0, 0.0, 0.0)) @ pose for pose in world], planks(thick)
    (kind,), data = kb.types, []
    for pose in poses:
        at = transform_points(pose, [f.at for f in kind.features])
        lobes = in_lobe(kind.lobes, inverse(pose)[:3, 3], CAMERA.f / kb.f_ref)[0]
        seen = CAMERA.contains(CAMERA.project(at)) & np.isin(np.arange(len(at)), kind.lobes.feature[lobes])
        for other in poses:
            seen &= ~behind(at, kind.surface.rays, other)
        for f in rng.permutation(np.flatnonzero(seen))[:count]:
            uv = CAMERA.project(at[[f]])[0] + rng.normal(0.0, noise, 2)
            data.append((kind.features[f].type, tuple(uv.tolist())))
    order = rng.permutation(len(data))
    return Gamma(CAMERA, tuple(Appearance(f"a{i}", *data[k], "made") for i, k in enumerate(order))), poses
