"""Compounds written by hand (A1): detected by their parts, whose data they claim all; counted once."""

from __future__ import annotations

from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import pytest
from learned_cube import CUBE

from geometry.camera import Camera
from geometry.frames import inverse, look_at, transform_points
from geometry.visibility.rays import behind
from kb.clouds.lobes import in_lobe
from kb.files.read import read_kb
from plogic.cycle.delta import Options
from plogic.run.perceive import Perceiver
from sensing.appearance import Appearance, Gamma

CAMERA = Camera(640, 480, np.array([[600.0, 0, 319.5], [0, 600.0, 239.5], [0, 0, 1]]))
POSE = look_at((0.55, 0.4, 0.5), (0.0, 0.0, 0.0))
KB = """\
name: boxes
appearance_types: [corner, dot]
f_ref: 600
detector: {hit: {corner: 0.9, dot: 0.9}, clutter: {corner: 1, dot: 1}, sigma: 1.0, match_tolerance: 4.0}
priors: {box: 0.5}
"""
LOBE = "lobe: {axis: [0, 0, 1], half_angle: 80 deg, range: [0.1 m, 9 m]}"
DOTS = {"d0": (0.05, 0.02), "d1": (-0.06, 0.05), "d2": (0.02, -0.06)}
"""Places on the upper face, m."""
PARTS = {"left": (-0.012, 0.0), "right": (0.012, 0.004), "low": (0.0, -0.013)}
"""... of the parts of a compound in the place of d0, from there."""


def dot(name, at, indent="  "):
    place = f"[{at[0]}, {at[1]}, {at[2]}]"
    return f"{indent}- {{feature: {name}, type: dot, at: {place}, appearances: [{{type: dot, {LOBE}}}]}}\n"


@cache
def kb_with(*parts):
    """A box with corners and three dots, d0 a compound of these parts, each by name and place; without any, an atom."""
    corners = np.sign(CUBE.vertices)
    rows = "".join(
        f"  - {{feature: c{i}, type: corner, at: {(0.1 * c).tolist()}, appearances: [{{type: corner, "
        f"lobe: {{axis: {c.tolist()}, half_angle: 120 deg, range: [0.1 m, 9 m]}}}}]}}\n"
        for i, c in enumerate(corners)
    )
    for name, (x, y) in DOTS.items():
        if parts and name == "d0":
            rows += f"  - feature: d0\n    type: dot\n    at: [{x}, {y}, 0.1]\n    features:\n"
            rows += "".join(dot(part, (dx, dy, 0.0), "      ") for part, (dx, dy) in parts)
        else:
            rows += dot(name, (x, y, 0.1))
    mesh = "".join(f"v {x} {y} {z}\n" for x, y, z in CUBE.vertices)
    mesh += "".join(f"f {a + 1} {b + 1} {c + 1}\n" for a, b, c in CUBE.triangles)
    with TemporaryDirectory() as name:
        folder = Path(name) / "objects" / "box"
        folder.mkdir(parents=True)
        (folder / "mesh.obj").write_text(mesh)
        (folder / "object.yaml").write_text(f"object: box\nmesh: {{file: mesh.obj, units: m}}\nfeatures:\n{rows}")
        (Path(name) / "kb.yaml").write_text(KB)
        return read_kb(name)


@cache
def perceiver(*parts):
    return Perceiver(kb_with(*parts))


def seen(kb, without=()):
    """Γ of all that is to be seen of the box, but for some features."""
    (kind,) = kb.types
    at = transform_points(POSE, [f.at for f in kind.seen_features])
    lobes = in_lobe(kind.lobes, inverse(POSE)[:3, 3], CAMERA.f / kb.f_ref)[0]
    shown = np.isin(np.arange(len(at)), kind.lobes.feature[lobes]) & ~behind(at, kind.surface.rays, POSE)
    rows = [(f, uv) for f, uv, there in zip(kind.seen_features, CAMERA.project(at), shown, strict=True) if there]
    kept = [(f.type, tuple(uv.tolist())) for f, uv in rows if f.name not in without]
    return Gamma(CAMERA, tuple(Appearance(f"a{i}", name, uv, "made") for i, (name, uv) in enumerate(kept)))


def found(parts, without=(), reading="score"):
    """The one accepted hypothesis, and the data that the most probable world calls noise."""
    document = perceiver(*parts)(seen(kb_with(*parts), without), Options(reading=reading))
    (row,) = [h for h in document["hypotheses"] if h["status"] == "accepted"]
    assert np.allclose(row["T_camera_object"], POSE, atol=0.01)
    return row, sum(cause == "noise" for cause in document["worlds"][0]["causes"].values())


ONE, THREE = (("left", (0.0, 0.0)),), tuple(PARTS.items())


@pytest.mark.parametrize("reading", ["score", "posterior"])
def test_a_compound_of_one_member_is_that_member(reading):
    plain, of_one = found((), reading=reading)[0], found(ONE, reading=reading)[0]
    assert of_one["support"] == plain["support"]
    for key in ("ev", "ev_reconsidered", "p_ev", "probability", "log_likelihood_ratio"):
        assert of_one[key] == pytest.approx(plain[key], abs=1e-9), key
    plain, of_one = found((), ("d1",), reading)[0], found(ONE, ("d1",), reading)[0]
    assert of_one["support"] == plain["support"]  # ev differs by dv alone: each Feature node counts in S (§5.1)


def test_splitting_a_feature_into_parts_that_are_all_detected_changes_no_cell():
    plain, split = found(())[0], found(THREE)[0]
    assert split["support"] == plain["support"]
    assert split["ev"] == pytest.approx(1.0)


@pytest.mark.parametrize("lost", [("d0/left",), ("d0/right", "d0/low")])
def test_one_part_is_enough_and_no_datum_of_another_is_noise(lost):
    row, noise = found(THREE, lost)
    assert row["ev"] == pytest.approx(1.0)
    assert row["support"]["dot"]["expected_detected"] == 3
    assert noise == 0


def test_without_any_of_its_parts_it_is_missed_once():
    row, _ = found(THREE, tuple(f"d0/{part}" for part in PARTS))
    assert row["support"]["dot"] == {
        "expected_detected": 2,
        "expected_missed": 1,
        "hidden_missed": 0,
        "hidden_detected": 0,
    }
    assert row["support"] == found((), ("d0",))[0]["support"]
