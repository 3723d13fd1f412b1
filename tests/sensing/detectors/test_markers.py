"""Markers drawn by OpenCV and warped by a known homography: who they are, and where, to half a pixel."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from geometry.camera import Camera
from sensing.detectors.detector import detect
from sensing.detectors.markers import DICTIONARIES, LEAST_SIDE, MarkerDetector
from sensing.errors import DetectorError

FINE, DRAWN, RIM = 4, 400, 100
SQUARE = np.array([[0, 0], [1, 0], [1, 1], [0, 1]], float)


def picture(name, number, H, size=(320, 240), noise=3.0):
    """A marker on a grey wall; ``H`` maps its unit square (v down) to pixels.

    Drawn four times finer, averaged down, blurred, noised.
    """
    dictionary = cv2.aruco.getPredefinedDictionary(getattr(cv2.aruco, DICTIONARIES[name][0]))
    print_ = np.full((DRAWN + 2 * RIM,) * 2, 255, np.uint8)
    print_[RIM:-RIM, RIM:-RIM] = cv2.aruco.generateImageMarker(dictionary, number, DRAWN)
    unit_from_print = np.array([[1, 0, 0.5 - RIM], [0, 1, 0.5 - RIM], [0, 0, DRAWN]]) / DRAWN
    fine_from_pixel = np.array([[FINE, 0, (FINE - 1) / 2], [0, FINE, (FINE - 1) / 2], [0, 0, 1]])
    fine = np.full((size[1] * FINE, size[0] * FINE), 150, np.uint8)
    to_fine = fine_from_pixel @ H @ unit_from_print
    cv2.warpPerspective(
        print_, to_fine, fine.shape[::-1], dst=fine, flags=cv2.INTER_LINEAR, borderMode=cv2.BORDER_TRANSPARENT
    )
    soft = cv2.GaussianBlur(cv2.resize(fine.astype(np.float32), size, interpolation=cv2.INTER_AREA), (0, 0), 0.5)
    grain = np.random.default_rng(0).normal(0, noise, (*soft.shape, 3))
    return np.clip(np.rint(soft[:, :, None] * 0.7 + 30 + grain), 0, 255).astype(np.uint8)


def warp(side, turn, squeeze=1.0, tilt=(0.0, 0.0), at=(150.0, 110.0)):
    H = np.eye(3)
    H[:2, :2] = np.array([[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]]) @ np.diag(
        [side, side * squeeze]
    )
    H[:2, 2] = np.array(at) - H[:2, :2] @ (0.5, 0.5)
    H[2, :2] = tilt
    return H


def projected(H, points):
    moved = np.c_[points, np.ones(len(points))] @ H.T
    return moved[:, :2] / moved[:, 2:]


@pytest.mark.parametrize("name", list(DICTIONARIES))
@pytest.mark.parametrize(
    "H", [warp(100, 0.0), warp(60, 0.7, 0.8, (0.1, -0.1)), warp(80, 3.6, 0.9, (-0.1, 0.15)), warp(45, 5.1)]
)
def test_a_warped_marker_is_found_with_its_corners(name, H):
    found = {a.type: a for a in MarkerDetector(name).detect(picture(name, 7, H))}
    assert set(found) == {f"{name}_7{end}" for end in ("", "_c0", "_c1", "_c2", "_c3")}
    corners = projected(H, SQUARE)
    assert np.array([found[f"{name}_7_c{k}"].uv for k in range(4)]) == pytest.approx(corners, abs=0.5)
    middle = found[f"{name}_7"]
    assert middle.uv == pytest.approx(projected(H, np.array([[0.5, 0.5]]))[0], abs=0.5)
    upper = corners[1] - corners[0]
    assert np.cos(middle.angle - np.arctan2(upper[1], upper[0])) > np.cos(0.03)
    assert middle.scale == pytest.approx(
        np.linalg.norm(np.roll(corners, -1, axis=0) - corners, axis=1).mean(), rel=0.02
    )


@pytest.mark.parametrize(("name", "number"), [("aruco_4x4", 0), ("aruco_4x4", 49), ("apriltag_36h11", 586)])
def test_the_first_and_the_last_id_are_among_the_types(name, number):
    found = MarkerDetector(name).detect(picture(name, number, warp(90, 0.3)))
    assert [a.type for a in found] == [f"{name}_{number}{end}" for end in ("", "_c0", "_c1", "_c2", "_c3")]
    assert {a.type for a in found} <= set(MarkerDetector(name).types)


def test_every_dictionary_has_the_ids_that_are_said():
    assert DICTIONARIES
    for constant, count in DICTIONARIES.values():
        assert len(cv2.aruco.getPredefinedDictionary(getattr(cv2.aruco, constant)).bytesList) == count


def test_two_markers_are_reported_by_id():
    both = np.hstack(
        [picture("aruco_4x4", 9, warp(80, 0.2), (300, 240)), picture("aruco_4x4", 2, warp(80, 1.2), (300, 240))]
    )
    assert [a.type for a in MarkerDetector("aruco_4x4").detect(both)][::5] == ["aruco_4x4_2", "aruco_4x4_9"]


def test_detect_reports_the_markers_of_the_vocabulary_alone():
    image = picture("apriltag_36h11", 3, warp(100, 0.1))
    camera = Camera(320, 240, np.array([[300.0, 0, 160], [0, 300, 120], [0, 0, 1]]), np.zeros(0))
    found = detect(image, camera, {"apriltag_36h11_3", "apriltag_36h11_3_c2", "aruco_4x4_3"}).appearances
    assert {a.type for a in found} == {"apriltag_36h11_3", "apriltag_36h11_3_c2"}
    assert detect(image, camera, {"apriltag_36h11_4"}).appearances == ()


@pytest.mark.parametrize("name", list(DICTIONARIES))
def test_nothing_in_constant_tiny_or_noisy_images(name):
    rng = np.random.default_rng(0)
    finder = MarkerDetector(name)
    assert finder.detect(np.full((120, 160, 3), 90, np.uint8)) == []
    for shape in ((1, 1), (8, 8), (LEAST_SIDE, LEAST_SIDE), (1, 300), (200, 300)):
        assert finder.detect(rng.integers(0, 256, (*shape, 3)).astype(np.uint8)) == []


def test_a_dictionary_that_is_none_is_one_line():
    with pytest.raises(DetectorError, match="'aruco_9x9' is no dictionary"):
        MarkerDetector("aruco_9x9")
