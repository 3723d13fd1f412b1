"""What places on the screen say of many poses at once; of one it is ``geometry.refine.information``."""

import numpy as np

from geometry.arrays import Floats
from geometry.camera import Camera
from geometry.reprojection import counting, jacobian_of, onto_lines


def informations(at: Floats, centres: Floats, weights: Floats, camera: Camera, across: Floats) -> Floats:
    """J^T W J (B, 6, 6) of places `at` (B, N, 3) m, before the camera, in its frame, that turn by w rad about `centres` (B, 3) and move by v m.

    `weights` (B, N) are 1/variance of their pixels, undistorted; `across` (B, N, 2) as in `refine_poses`.
    """
    jacobian = counting(jacobian_of(at - centres[:, None], at, 1.0 / at[..., 2], camera.K[:2]), onto_lines(across))
    return np.asarray(np.swapaxes(jacobian * np.repeat(weights, 2, axis=1)[..., None], 1, 2) @ jacobian)
