"""A photo's part about a pose, in the scale in which poses there are compared.

* ``Crop``: the part, its colours, edges and palette, and how far away what stands before it is
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import cv2
import numpy as np
from numpy.typing import NDArray

from geometry.arrays import Floats, Ints
from geometry.visibility.rays import RayMesh, depth_of
from sensing.pixels.drawn import Drawn, Paint
from sensing.pixels.photo import DULLED, Photo, lab_of, nearest, steepest

BLUR = 0.4
"""Pixels, standard deviation, by which the photo is smoothed before it is made smaller."""


@dataclass(frozen=True, eq=False)
class Crop:
    """``lab`` (h, w, 3) float32; ``K`` (3, 3) of this part, without lens; ``size``: the object's larger side, pixels.

    ``before`` (h, w) m: how far away the nearest is of what stands before; inf for nothing. ``noise``: of the photo.
    ``grey``: it has no colours.
    """

    lab: NDArray[np.float32]
    K: Floats
    size: float
    before: Floats
    noise: float
    palette: NDArray[np.float32]
    grey: bool = False

    @property
    def shape(self) -> tuple[int, int]:
        """Width and height, pixels."""
        return self.lab.shape[1], self.lab.shape[0]

    @cached_property
    def near(self) -> Floats:
        """(h, w) m as ``before``, the nearest within two pixels."""
        return np.asarray(cv2.erode(self.before, np.ones((5, 5), np.uint8)))

    @cached_property
    def colour(self) -> Ints:
        """(h, w) which of the palette each pixel is."""
        return nearest((self.lab * DULLED).reshape(-1, 3), self.palette).reshape(self.lab.shape[:2])

    @cached_property
    def gradient(self) -> NDArray[np.float32]:
        """(h, w, 2) of the channel in which it is steepest, units of Lab a pixel."""
        return steepest(self.lab)


MARGIN = 0.18, 8.0
"""What is left around an object: a share of its size, and pixels of the photo."""


def crop_of(
    photo: Photo, paint: Paint, pose: Floats, size: float, before: Sequence[tuple[RayMesh, Floats]] = ()
) -> Crop | None:
    """The part about a pose, made smaller until the object's larger side is ``size`` px at most.

    ``before``: the surfaces of what stands there for sure, and its poses. None where the photo has nothing of the
    object.
    """
    K, (height, width) = photo.camera.K, photo.image.shape[:2]
    box = paint.box(pose, K)
    if box is None:
        return None
    whole = float((box[1] - box[0]).max())
    room = MARGIN[0] * whole + MARGIN[1]
    low = np.maximum(np.floor(box[0] - room), 0).astype(int)
    high = np.minimum(np.ceil(box[1] + room) + 1, [width, height]).astype(int)
    if (high - low < 8).any():
        return None
    part = cv2.GaussianBlur(_ideal(photo, low, high), (0, 0), BLUR)
    share = min(1.0, size / whole)
    small = np.maximum(np.rint((high - low) * share), 8).astype(int)
    factor = small / (high - low)
    here = K.copy()
    here[:2, 2] = (K[:2, 2] - low + 0.5) * factor - 0.5
    here[0, 0], here[1, 1], here[0, 1] = K[0, 0] * factor[0], K[1, 1] * factor[1], 0.0
    if share < 1.0:
        part = cv2.resize(part, (int(small[0]), int(small[1])), interpolation=cv2.INTER_AREA)
    far = np.full(part.shape[:2], np.inf)
    for other, there in before:
        far = np.minimum(far, depth_of(other, there, here, (part.shape[1], part.shape[0])))
    return Crop(lab_of(part), here, whole * share, far, photo.noise, photo.palette, photo.grey)


def _ideal(photo: Photo, low: NDArray[np.intp], high: NDArray[np.intp]) -> NDArray[np.float32]:
    """The photo's pixels from ``low`` to ``high`` as a camera without a lens sees them."""
    camera = photo.camera
    if not camera.dist.any():
        return photo.image[low[1] : high[1], low[0] : high[0]].astype(np.float32)
    u, v = np.meshgrid(np.arange(low[0], high[0], dtype=float), np.arange(low[1], high[1], dtype=float))
    ideal = np.stack(
        [(u - camera.K[0, 2]) / camera.K[0, 0], (v - camera.K[1, 2]) / camera.K[1, 1], np.ones(u.shape)], -1
    )
    at = np.nan_to_num(camera.project(ideal), nan=-1.0).astype(np.float32)
    return cv2.remap(photo.image, at[..., 0], at[..., 1], cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE).astype(
        np.float32
    )


def clear(crop: Crop, drawn: Drawn, slack: float) -> NDArray[np.bool_]:
    """(h, w) where the drawn is and nothing that stands for sure is before it by more than ``slack`` m."""
    return np.asarray(drawn.mask & (crop.near > drawn.depth - slack))
