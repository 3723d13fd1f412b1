"""The drawn surface against the photo in small squares, each with a gain and an offset of its own.

Light, shadow and white balance change slowly over a surface, print does not: what is left once a square's brightness
and contrast are fitted is print that is there, or is not.

* ``Blocks``: the pixels of squares that are full enough, in the squares' order
"""

from dataclasses import dataclass
from functools import cached_property

import cv2
import numpy as np
from numpy.typing import NDArray

from geometry.arrays import Floats, Ints, Mask
from sensing.pixels.crop import Crop
from sensing.pixels.drawn import Drawn
from sensing.pixels.loops import squared
from sensing.pixels.photo import greyed, lab_of

FULL = 0.35
"""Share of a square that must show the object."""
GAINS = 0.35, 1.3
"""Bounds of the common gain; of a square's own ``OWN`` of it."""
OWN = 0.5, 1.6
FLOOR = np.array([9.0, 4.0, 4.0])
"""Least variance of noise in L, a, b."""
MODEL = 0.15
"""Share of the drawn contrast by which it may be wrong."""
SENSOR = np.array([0.5, 0.75, 0.75]) * 0.39**2
"""Variance in L, a, b for that of one grey level of the sensor's noise."""
ALIKE = 12.0
"""Pixels that tell as much as one independent sample."""
SHARPNESS = 0.7
"""Pixels, standard deviation, by which the drawn is smoothed, as a photo is."""


def smoothed(crop: Crop, drawn: Drawn) -> NDArray[np.float32]:
    """(h, w, 3) Lab of the drawn colours as a photo shows them; their brightness alone where it has no colours."""
    share = cv2.GaussianBlur(drawn.mask.astype(np.float32), (0, 0), SHARPNESS)
    colour = greyed(drawn.colour) if crop.grey else drawn.colour
    return lab_of(cv2.GaussianBlur(colour, (0, 0), SHARPNESS) / np.maximum(share, 0.2)[..., None])


@dataclass(frozen=True, eq=False)
class Blocks:
    """K squares: ``which`` (h, w) of them each pixel is in, -1 for none; ``count`` (K,) of each's pixels.

    ``sums`` (K, 15) over them: of Lab in photo and drawn, their squares and their product, three of each; ``noise``
    (3,) variance of the photo's noise; ``channels``: how many of Lab's there are, 1 of a photo without colours.
    """

    which: Ints
    count: Ints
    sums: Floats
    noise: Floats
    channels: int = 3

    @cached_property
    def moments(self) -> tuple[Floats, Floats, Floats]:
        """(K, 3) each: variance of the photo, of the drawn, and their covariance."""
        mp, mq, pp, qq, pq = (self.sums / self.count[:, None]).reshape(-1, 5, 3).swapaxes(0, 1)
        return np.maximum(pp - mp * mp, 0.0), np.maximum(qq - mq * mq, 0.0), pq - mp * mq

    @cached_property
    def gain(self) -> float:
        """Of contrast, common to all squares and channels."""
        _, variance, together = self.moments
        n = self.count[:, None]
        return float(np.clip((n * together).sum() / max(float((n * variance).sum()), 1e-6), *GAINS))

    @cached_property
    def gains(self) -> Floats:
        """(K, 3) of each square and channel."""
        _, variance, together = self.moments
        return np.clip(together / np.maximum(variance, 1e-6), OWN[0] * self.gain, OWN[1] * self.gain)

    @cached_property
    def left(self) -> Floats:
        """(K, 3) variance of the photo that the drawn does not explain."""
        photo, drawn, together = self.moments
        return np.maximum(photo - 2.0 * self.gains * together + self.gains**2 * drawn, 0.0)

    @property
    def explained(self) -> float:
        """Logarithm of how much likelier the photo is with the drawn than with nothing but its own variance."""
        if not len(self.count):
            return 0.0
        photo, drawn, _ = self.moments
        noise = self.noise + FLOOR + (MODEL * self.gain) ** 2 * drawn
        return float((0.5 * self.count[:, None] / ALIKE * np.log((photo + noise) / (self.left + noise))).sum())

    @property
    def correlation(self) -> float:
        """Between photo and drawn, squares weighed by how much print they show; 0 where there is none."""
        if not len(self.count):
            return 0.0
        photo, drawn, together = self.moments
        noise = self.noise + FLOOR + (MODEL * self.gain) ** 2 * drawn
        each = (np.maximum(together, 0.0) / np.sqrt((photo + noise) * (drawn + noise)))[:, : self.channels].mean(axis=1)
        weight = self.count * self._printed
        return float((weight * each).sum() / max(float(weight.sum()), 0.05 * float(self.count.sum()), 1.0))

    @property
    def shown(self) -> float:
        """How much of what is drawn is print above noise, 0 to 1; 1 where nothing is drawn."""
        if not len(self.count):
            return 1.0
        return float((self.count * self._printed).sum() / self.count.sum())

    @property
    def _printed(self) -> Floats:
        """(K,) share of the drawn's variance in that of the drawn and noise."""
        drawn = self.moments[1]
        noise = self.noise + FLOOR + (MODEL * self.gain) ** 2 * drawn
        return np.asarray((drawn / (drawn + noise))[:, : self.channels].mean(axis=1))


def blocks_of(crop: Crop, shown: NDArray[np.float32], visible: Mask, side: int) -> Blocks:
    """The squares, ``side`` px wide, of what is ``visible`` (h, w) of a drawn surface (h, w, 3) Lab."""
    which, count, sums = squared(visible, crop.lab, shown, side)
    full = count > FULL * side * side
    if not full.any():
        full = count >= max(1, min(int(count.max(initial=0)), 12))
    number = np.full(len(count) + 1, -1)
    number[:-1][full] = np.arange(int(full.sum()))
    return Blocks(number[which], count[full], sums[full], SENSOR * crop.noise**2, 1 if crop.grey else 3)
