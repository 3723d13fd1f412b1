"""What each pixel of a photo says for the outline, the creases and the colours of a type, against the photo at large.

All are logarithms of likelihood ratios. An edge in one direction is likelier where the object's is; how likely edges
are otherwise is counted in pixels of this photo that have about as many edges around them. A colour is likely that a
colour of the type's becomes in some light; how likely otherwise, the photo says.

* ``PhotoMaps(image)``: what all types share; ``TypeMaps(photo, views).stack(scale, spread, every)``

A stack of a type's maps has ``2 · BINS`` for outlines by the direction inward, ``BINS`` for inner edges by the
direction across, and the type's colours twice, for what is inside and for what is outside.
"""

from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from geometry.arrays import Floats, Ints
from sensing.detectors.keypoints import is_grey
from sensing.pixels.photo import greyed, lab_of, steepest
from sensing.views.loops import BINS, MOST, STEPS, counted, responses, stacked, told
from sensing.views.views import Views

UNIT = 12.0
"""How many steps of a map are a nat."""
ON_OUTLINE, ON_BORDER, ON_INNER, IN_COLOUR, OUT_COLOUR = 0.6, 1.0, 0.4, 0.6, 0.5
"""What a feature counts of the edge there, of the border of the type's own colours, and of its colour."""
STEEP = 6.0
"""Grey levels a pixel of an edge that is half as strong as any."""
WIDTH, WIDTH_OF_BORDER = np.radians(20.0), np.radians(28.0)
"""By which the direction of an edge may be off."""
AROUND = 25
"""Pixels of a square in which edges are counted."""
KINDS = 6
"""Of pixels, by how many edges are around."""
HARD = 0.4
"""Share of features at which the photo shows nothing of the object."""
LAB = (26, 52, 52), 4.0, 104.0
"""Cells of L, a, b, their width, and what is added to a and b."""
OTHER = 0.12
"""Share of places on an object that have none of its colours."""


@dataclass(eq=False)
class PhotoMaps:
    """Of ``image`` (H, W, 3) uint8, blue first, in the scales that are asked for."""

    image: NDArray[np.uint8]
    _edges: dict[tuple[float, int, int], NDArray[np.int8]] = field(default_factory=dict)
    _cells: dict[float, Ints] = field(default_factory=dict)

    def scaled(self, scale: float) -> NDArray[np.float32]:
        """The photo (h, w, 3) in a scale of at most 1."""
        whole = self.image.astype(np.float32)
        if scale >= 1.0:
            return whole
        high, wide = (int(np.ceil(side * scale)) for side in whole.shape[:2])
        to = np.array([[scale, 0.0, 0.5 * scale - 0.5], [0.0, scale, 0.5 * scale - 0.5]])
        smooth = cv2.GaussianBlur(whole, (0, 0), 0.45 / scale)
        small = cv2.warpAffine(smooth, to, (wide, high), flags=cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
        return np.asarray(small, np.float32)

    def edges(self, scale: float, spread: int, every: int) -> NDArray[np.int8]:
        """(``BINS``, h, w) what is told of edges: the best within ``spread`` pixels, of every so many pixels one."""
        key = scale, spread, every
        if key not in self._edges:
            smooth = cv2.GaussianBlur(self.scaled(scale), (0, 0), 0.8)
            x, y = np.moveaxis(steepest(np.asarray(smooth, np.float32)), 2, 0)
            steep = np.hypot(x, y)
            self._edges[key] = surprise(steep / (steep + STEEP), np.arctan2(y, x), BINS, np.pi, WIDTH, spread, every)
        return self._edges[key]

    def cells(self, scale: float) -> Ints:
        """(h, w) in which cell of Lab each pixel is."""
        if scale not in self._cells:
            self._cells[scale] = cell_of(lab_of(cv2.GaussianBlur(self.scaled(scale), (0, 0), 0.8)))
        return self._cells[scale]

    @cached_property
    def grey(self) -> bool:
        """Whether the photo has no colours to tell."""
        return is_grey(self.image)

    @cached_property
    def usual(self) -> Floats:
        """(cells of Lab,) how the photo's pixels are spread."""
        return spread_of(cell_of(lab_of(self.image[::2, ::2].astype(np.float32))), (1.5, 1.2, 1.2))


class TypeMaps:
    """A photo's maps for one type."""

    def __init__(self, photo: PhotoMaps, views: Views) -> None:
        """Tell what each colour is worth."""
        self._photo = photo
        own = np.stack([lit(colour, grey=photo.grey) for colour in views.palette])
        self._tables = np.log((1.0 - OTHER) * own / photo.usual + OTHER).astype(np.float32)
        mixed = np.log((1.0 - OTHER) * (views.share @ own) / photo.usual + OTHER)
        self._near = (1.0 / (1.0 + np.exp(-1.5 * mixed))).astype(np.float32)
        self._stacks: dict[tuple[float, int, int, int], NDArray[np.int8]] = {}

    def stack(self, scale: float, spread: int, every: int, pad: int = 0) -> NDArray[np.int8]:
        """(C, h, w) in a scale: of every so many pixels one, of edges the best within ``spread`` pixels about it.

        ``pad``: so many cells of nothing around it. It is kept.
        """
        key = scale, spread, every, pad
        if key not in self._stacks:
            made = self._made(scale, spread, every)
            self._stacks[key] = np.pad(made, ((0, 0), (pad, pad), (pad, pad))) if pad else made
        return self._stacks[key]

    def _made(self, scale: float, spread: int, every: int) -> NDArray[np.int8]:
        edges, cells = self._photo.edges(scale, spread, every), self._photo.cells(scale)
        near = cv2.GaussianBlur(self._near[cells], (0, 0), 1.0)
        x, y = (cv2.Sobel(near, cv2.CV_32F, *way) / 4.0 for way in ((1, 0), (0, 1)))
        strong = np.minimum(1.0, 2.0 * np.hypot(x, y))
        border = surprise(strong, np.arctan2(y, x), 2 * BINS, 2.0 * np.pi, WIDTH_OF_BORDER, spread, every)
        weights = np.array([ON_BORDER, ON_OUTLINE, ON_INNER])
        colours = np.stack([_thinned(cv2.blur(table[cells], (every, every)), every) for table in self._tables])
        inside, outside = (_steps(share * colours) for share in (IN_COLOUR, -OUT_COLOUR))
        return np.asarray(stacked(border, edges, inside, outside, weights))


def _steps(nats: Floats) -> NDArray[np.int8]:
    return np.clip(np.rint(nats * UNIT), -MOST, MOST).astype(np.int8)


def _thinned(some: NDArray[Any], every: int) -> NDArray[Any]:
    """Of every so many pixels of (..., h, w) one."""
    return np.ascontiguousarray(some[..., every // 2 :: every, every // 2 :: every])


def surprise(
    weight: Floats, angle: Floats, bins: int, period: float, width: float, spread: int, every: int
) -> NDArray[np.int8]:
    """(bins, h, w) what edges of a ``weight`` (0 to 1) and a direction tell, in ``UNIT``."""
    grade = responses(weight.astype(np.float32), angle.astype(np.float32), bins, period, width)
    if spread:
        kernel = np.ones((2 * spread + 1, 2 * spread + 1), np.uint8)
        grade = np.stack([cv2.dilate(one, kernel) for one in grade])
    around = cv2.blur(grade.mean(axis=0, dtype=np.float32), (AROUND, AROUND))
    grade, around = _thinned(grade, every), _thinned(around, every)
    bounds = np.quantile(around, np.linspace(0.0, 1.0, KINDS + 1)[1:-1])
    kind = np.searchsorted(bounds, around.ravel()).reshape(around.shape)
    number = counted(grade, kind, KINDS)
    number = cv2.GaussianBlur(number, (0, 0), sigmaX=1.0, sigmaY=0.01) + number.sum(axis=1, keepdims=True) * 1e-3 + 1.0
    usual = number / number.sum(axis=1, keepdims=True)
    right = np.arange(STEPS) + 0.5
    log = np.log((1.0 - HARD) * right / right.sum() / usual + HARD)
    return np.asarray(told(grade, kind, _steps(log)))


def cell_of(lab: NDArray[np.float32]) -> Ints:
    """In which cell of Lab colours (..., 3) are."""
    shape, wide, add = LAB
    which = [np.clip((lab[..., k] + (add if k else 0.0)) / wide, 0, shape[k] - 1).astype(np.int64) for k in range(3)]
    return np.ravel_multi_index((which[0], which[1], which[2]), shape)


def spread_of(cells: Ints, smooth: tuple[float, float, float]) -> Floats:
    """(cells of Lab,) shares of the cells of some pixels, smoothed."""
    from scipy.ndimage import gaussian_filter

    number = np.bincount(cells.ravel(), minlength=int(np.prod(LAB[0]))).reshape(LAB[0]).astype(float)
    share = gaussian_filter(number, smooth).ravel()
    share = share / share.sum() + 1e-7
    return share / share.sum()


DARKER, SHADED, TINTED, NOISE = 0.72, 0.3, 0.1, 0.03
"""How much light a painted surface has, of that in which it was painted: the median, its logarithm's standard deviation
and that of each channel; and what is added to each channel, of 1."""


def lit(lab: NDArray[np.float32], *, grey: bool = False) -> Floats:
    """(cells of Lab,) what a colour becomes in some light; ``grey``: before a camera without colours."""
    rng = np.random.default_rng(0)
    bgr = np.asarray(cv2.cvtColor(np.asarray(lab, np.float32)[None, None], cv2.COLOR_LAB2BGR))[0, 0]
    light = np.exp(rng.normal(np.log(DARKER), SHADED, (4000, 1)) + rng.normal(0.0, TINTED, (4000, 3)))
    shine = np.abs(rng.normal(0.0, NOISE, (4000, 1)))
    seen = np.asarray(np.clip(bgr * light + rng.normal(0.0, NOISE, (4000, 3)) + shine, 0.0, 1.0) * 255.0, np.float32)[
        None
    ]
    return spread_of(cell_of(lab_of(greyed(seen) if grey else seen)), (1.2, 1.2, 1.2))
