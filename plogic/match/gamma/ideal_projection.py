"""Projection of thousands of posed clouds at once, into the ideal image."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from plogic.match.gamma.data import centre_of

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from plogic.match.gamma.data import Data

FAR = np.float32(-1e6)
"""Where a point behind the camera is put: outside every image."""


def project_ideal(poses: NDArray[np.float64], points: NDArray[np.float64], data: Data) -> NDArray[np.float32]:
    """(N, F, 2) ideal pixels of object points (F, 3) under poses (N, 4, 4), single precision; far outside the image where behind the camera."""
    rotations = poses[:, :3, :3].astype(np.float32).reshape(-1, 3)
    local = (rotations @ points.T.astype(np.float32)).reshape(len(poses), 3, len(points))
    local += poses[:, :3, 3:].astype(np.float32)
    seen = local[:, 2] > 1e-6
    inverse = np.float32(data.camera.f) / np.where(seen, local[:, 2], np.float32(1.0))
    places = np.empty((*seen.shape, 2), dtype=np.float32)
    centre = centre_of(data.camera)
    places[..., 0] = np.where(seen, local[:, 0] * inverse + np.float32(centre[0]), FAR)
    places[..., 1] = np.where(seen, local[:, 1] * inverse + np.float32(centre[1]), FAR)
    return places


def viewpoints_of(poses: NDArray[np.float64]) -> NDArray[np.float64]:
    """(N, 3) the camera's place in the object's frame under each pose."""
    return -np.einsum("nji,nj->ni", poses[:, :3, :3], poses[:, :3, 3])
