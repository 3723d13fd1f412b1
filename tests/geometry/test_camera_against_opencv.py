"""Oracle: OpenCV's projectPoints and undistortPoints."""

import numpy as np
import pytest

from geometry.camera import Camera

cv2 = pytest.importorskip("cv2")
K = np.array([[610.0, 0, 330], [0, 590, 235], [0, 0, 1]])
LENSES = {
    0: [],
    4: [-0.2, 0.05, 1e-3, -2e-3],
    5: [-0.2, 0.05, 1e-3, -2e-3, 0.01],
    8: [0.3, -0.1, 1e-3, 5e-4, 0.02, 0.4, -0.05, 0.01],
    12: [0.1, -0.05, 1e-3, 5e-4, 0.02, 0.1, -0.05, 0.01, 1e-3, -1e-3, 2e-3, 5e-4],
    14: [0.1, -0.05, 1e-3, 5e-4, 0.02, 0.1, -0.05, 0.01, 1e-3, -1e-3, 2e-3, 5e-4, 0.02, -0.03],
}


@pytest.mark.parametrize("count", LENSES)
def test_projection_equals_project_points(count):
    rng = np.random.default_rng(count)
    points = np.c_[rng.uniform(-1.5, 1.5, (300, 2)), rng.uniform(3, 9, 300)]
    camera = Camera(640, 480, K, np.array(LENSES[count], dtype=float))
    expected, _ = cv2.projectPoints(points, np.zeros(3), np.zeros(3), K, np.array(LENSES[count], dtype=float))
    assert np.allclose(camera.project(points), expected.reshape(-1, 2), atol=1e-8)


@pytest.mark.parametrize("count", LENSES)
def test_normalised_equals_undistort_points(count):
    rng = np.random.default_rng(count)
    uv = rng.uniform([0, 0], [640, 480], (300, 2))
    camera = Camera(640, 480, K, np.array(LENSES[count], dtype=float))
    criteria = (cv2.TERM_CRITERIA_COUNT + cv2.TERM_CRITERIA_EPS, 200, 1e-12)
    lens = np.array(LENSES[count], dtype=float)
    undistort = getattr(cv2, "undistortPointsIter", cv2.undistortPoints)  # OpenCV 4, OpenCV 5
    expected = undistort(uv[:, None], K, lens, R=None, P=None, criteria=criteria).reshape(-1, 2)
    assert np.allclose(camera.normalised(uv), expected, atol=1e-6)
