"""A stereo pair as one notional viewpoint (§3.3): which appearances carry depth, and how exact it is."""

from __future__ import annotations

import json

import numpy as np
import pytest

from geometry.camera import Camera
from geometry.errors import CameraError
from geometry.frames import look_at, transform_points
from sensing.appearance import Appearance, Gamma
from sensing.files.stereo import Pair, fused, read_stereo

CAMERA = Camera(
    640, 480, np.array([[600.0, 0, 320], [0, 600.0, 240], [0, 0, 1]]), np.array([0.1, -0.05, 0.001, 0.002, 0.01])
)
ASIDE = np.eye(4)
ASIDE[0, 3] = -0.2
TOED_IN = look_at([0.25, 0.02, 0.0], [0.0, 0.0, 2.0], up=(0.0, -1.0, 0.0))


def gamma(points, types, noise=0.0, seed=0, **more):
    uv = CAMERA.project(points) + np.random.default_rng(seed).normal(0.0, noise, (len(points), 2)) * (noise > 0)
    rows = zip(types, uv.tolist(), strict=True)
    return Gamma(
        CAMERA, tuple(Appearance(f"a{i}", kind, (u, v), "test", **more) for i, (kind, (u, v)) in enumerate(rows))
    )


def points_of(count, seed=1):
    rng = np.random.default_rng(seed)
    return rng.uniform([-0.6, -0.45, 1.5], [0.6, 0.45, 3.0], (count, 3))


@pytest.mark.parametrize("right_from_left", [ASIDE, TOED_IN], ids=["aside", "toed in"])
def test_exact_places_give_exact_depths(right_from_left):
    points = points_of(30)
    types = [f"t{i}" for i in range(30)]
    left, right = gamma(points, types), gamma(transform_points(right_from_left, points), types)
    depths = [a.depth for a in fused(left, right, Pair(right_from_left)).appearances]
    assert depths == pytest.approx(points[:, 2].tolist(), rel=1e-6)


def test_the_stated_noise_is_the_noise():
    points = points_of(400)
    types = [f"t{i}" for i in range(400)]
    both = fused(
        gamma(points, types, 0.5, 2), gamma(transform_points(ASIDE, points), types, 0.5, 3), Pair(ASIDE), sigma=0.5
    )
    off = np.array(
        [
            (a.depth - z) / a.depth_sigma
            for a, z in zip(both.appearances, points[:, 2], strict=True)
            if a.depth is not None
        ]
    )
    assert len(off) > 380
    assert 0.85 < off.std() < 1.15


def test_what_looks_alike_on_one_line_has_no_depth():
    points = np.array([[-0.1, 0.0, 2.0], [0.1, 0.0, 2.0], [0.0, 0.3, 2.0]])
    left, right = (gamma(transform_points(T, points), ["same", "same", "same"]) for T in (np.eye(4), ASIDE))
    assert [a.depth is not None for a in fused(left, right, Pair(ASIDE)).appearances] == [False, False, True]


def test_descriptors_and_angles_tell_apart_what_types_do_not():
    points = np.array([[-0.1, 0.0, 2.0], [0.1, 0.0, 2.0]])
    looks = [bytes([10] * 128), bytes([200] * 128)]
    turns = [0.3, 2.5]
    sides = []
    for T in (np.eye(4), ASIDE):
        uv = CAMERA.project(transform_points(T, points))
        sides.append((uv, [Appearance(f"d{i}", "w", tuple(uv[i]), "test", descriptor=looks[i]) for i in (0, 1)]))
    left, right = (Gamma(CAMERA, tuple(rows)) for _, rows in sides)
    assert [a.depth for a in fused(left, right, Pair(ASIDE)).appearances] == pytest.approx([2.0, 2.0], rel=1e-6)
    turned = [
        Gamma(CAMERA, tuple(Appearance(f"d{i}", "w", tuple(uv[i]), "test", angle=turns[i]) for i in (0, 1)))
        for uv, _ in sides
    ]
    assert [a.depth for a in fused(*turned, Pair(ASIDE)).appearances] == pytest.approx([2.0, 2.0], rel=1e-6)


def test_nothing_has_depth_of_other_types_behind_the_camera_or_alone():
    points = points_of(5)
    left = gamma(points, ["a"] * 5)
    assert all(a.depth is None for a in fused(left, gamma(points, ["b"] * 5), Pair(ASIDE)).appearances)
    assert fused(left, Gamma(CAMERA, ()), Pair(ASIDE)).appearances == left.appearances
    assert fused(Gamma(CAMERA, ()), left, Pair(ASIDE)).appearances == ()
    other_side = ASIDE.copy()
    other_side[0, 3] = 0.2
    swapped = gamma(transform_points(ASIDE, points), [f"t{i}" for i in range(5)])
    mine = gamma(points, [f"t{i}" for i in range(5)])
    assert all(a.depth is None for a in fused(mine, swapped, Pair(other_side)).appearances)


def test_more_than_can_be_compared_is_refused(monkeypatch):
    monkeypatch.setattr("sensing.files.stereo.MOST", 8)
    some = gamma(points_of(3), ["a", "b", "c"])
    with pytest.raises(CameraError, match="3 and 3 appearances are more"):
        fused(some, some, Pair(ASIDE))


def test_a_pair_must_be_one():
    with pytest.raises(CameraError, match="T_right_left"):
        Pair(np.eye(4))


def written(tmp_path, document):
    path = tmp_path / "stereo.json"
    path.write_text(json.dumps(document))
    return path


def test_a_calibration_is_read(tmp_path):
    camera = {"width": 640, "height": 480, "K": CAMERA.K.tolist(), "dist": []}
    found = read_stereo(written(tmp_path, {"format": "stereo/1", "T_right_left": ASIDE.tolist(), "left": camera}))
    assert np.array_equal(found.pair.right_from_left, ASIDE)
    assert (found.left.width, found.right) == (640, None)


@pytest.mark.parametrize(
    ("document", "words"),
    [
        ({}, "format: is missing: should be 'stereo/1'"),
        ({"format": "stereo/1"}, "T_right_left: is missing: should be a rigid 4x4"),
        ({"format": "stereo/1", "T_right_left": ASIDE.tolist(), "lefft": 3}, "lefft: unknown key"),
        ({"format": "stereo/1", "T_right_left": np.eye(4).tolist()}, "not zero"),
        ({"format": "stereo/1", "T_right_left": [[1]]}, "rigid 4x4"),
        ({"format": "stereo/1", "T_right_left": ASIDE.tolist(), "left": {"width": 3}}, "left.height: is missing"),
    ],
)
def test_a_calibration_that_is_none_is_told(tmp_path, document, words):
    with pytest.raises(CameraError, match="stereo") as caught:
        read_stereo(written(tmp_path, document))
    assert words in str(caught.value)
