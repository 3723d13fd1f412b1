"""Projection of thousands of posed clouds at once, into the ideal image."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from plogic.search.data import centre_of

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from plogic.search.data import Data


def project_ideal(poses: NDArray[np.float64], points: NDArray[np.float64], data: Data) -> NDArray[np.float64]:
    """(N, F, 2) ideal pixels of object points (F, 3) under poses (N, 4, 4); far outside the image where behind the camera."""
    local = np.einsum("nij,fj->nfi", poses[:, :3, :3], points) + poses[:, None, :3, 3]
    depth = np.where(local[..., 2:] > 1e-6, local[..., 2:], np.nan)
    places = local[..., :2] / depth * data.camera.f + centre_of(data.camera)
    return np.nan_to_num(places, nan=-1e6)


def viewpoints_of(poses: NDArray[np.float64]) -> NDArray[np.float64]:
    """(N, 3) the camera's place in the object's frame under each pose."""
    return -np.einsum("nji,nj->ni", poses[:, :3, :3], poses[:, :3, 3])
