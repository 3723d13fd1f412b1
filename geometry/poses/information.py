"""What places on the screen say of a pose: J^T W J, of one pose or of a batch."""

import numpy as np

from geometry.arrays import Floats
from geometry.camera import Camera
from geometry.poses.reprojection import counting, jacobian_of, onto_lines


def information(at: Floats, centre: Floats, weights: Floats, camera: Camera, across: Floats | None = None) -> Floats:
    """J^T W J (..., 6, 6) of places `at` (..., N, 3) m, before the camera, in its frame, that turn by w rad about `centre` (..., 3) and move by v m.

    `weights` (..., N) are 1/variance of their pixels, undistorted; `across` (..., N, 2) as in
    `geometry.poses.refine.refine_poses`.
    """
    batch = at.shape[:-2]
    placed = at.reshape(int(np.prod(batch)), *at.shape[-2:])
    turned = (at - centre[..., None, :]).reshape(placed.shape)
    onto = None if across is None else onto_lines(across).reshape(*placed.shape[:2], 2, 2)
    jacobian = counting(jacobian_of(turned, placed, 1.0 / placed[..., 2], camera.K[:2]), onto)
    weighted = jacobian * np.repeat(weights.reshape(placed.shape[:2]), 2, axis=1)[..., None]
    return np.asarray((np.swapaxes(weighted, 1, 2) @ jacobian).reshape(*batch, 6, 6))
