"""From the house's camera to the matrices that TinyRenderer wants.

In TinyRenderer a pixel's centre has whole viewport coordinates, and its picture lies one of its own pixels too high:
passing cx and cy + 1 without OpenGL's half pixel mends both (tested against projected points).
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from sensing.errors import SceneError

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from geometry.camera import Camera

_GL_FROM_CV = np.diag([1.0, -1.0, -1.0, 1.0])
TINY_RENDERER_ROWS = 1.0


def view_matrix(camera: Camera) -> list[float]:
    """OpenGL view matrix, column-major, of a camera with a pose in the world; raises SceneError where it has none."""
    if camera.world_from_camera is None:
        raise SceneError("camera: has no pose in the world (T_world_camera)")
    return _columns(_GL_FROM_CV @ np.linalg.inv(camera.world_from_camera))


def projection_matrix(camera: Camera, supersample: int, near: float, far: float) -> list[float]:
    """OpenGL projection matrix, column-major, for an image ``supersample`` times as wide and high; near and far in metres."""
    if np.any(camera.dist):
        raise SceneError(f"camera: the simulated camera has no lens distortion, but dist is {list(camera.dist)}")
    K = supersampled(np.asarray(camera.K, dtype=np.float64), supersample)
    width, height = camera.width * supersample, camera.height * supersample
    P = np.zeros((4, 4))
    P[0, 0], P[0, 2] = 2 * K[0, 0] / width, 1 - 2 * K[0, 2] / width
    P[1, 1], P[1, 2] = 2 * K[1, 1] / height, 2 * (K[1, 2] + TINY_RENDERER_ROWS) / height - 1
    P[2, 2], P[2, 3] = -(far + near) / (far - near), -2 * far * near / (far - near)
    P[3, 2] = -1
    return _columns(P)


def supersampled(K: NDArray[np.float64], factor: int) -> NDArray[np.float64]:
    """K (3, 3) of the image that is ``factor`` times larger; an integer stays a pixel's centre: u' = (u + ½) factor − ½."""
    larger = K.copy()
    larger[:2] *= factor
    larger[:2, 2] += (factor - 1) / 2
    return larger


def _columns(matrix: NDArray[np.float64]) -> list[float]:
    return [float(x) for x in matrix.T.reshape(-1)]
