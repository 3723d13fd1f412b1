"""What a search over all types asks of: their index, Γ, and what the KB says of the detector.

Γ is turned in its plane to where its own data say, so that how the camera was held decides nothing: boxes of votes, and
the directions in which poses are tilted, have axes of their own. What is found in a turned image is what was found,
turned.

* ``Asked``: these together; ``Chances``: how often what is expected is found, and how often an appearance is there of
  itself
* ``TypedData``: the data of each appearance type, one after the other
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from math import atan2, fsum
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from geometry.arrays import Floats, Indices, Mask
from geometry.camera import Camera
from kb.clouds.cloud import Rates
from plogic.base.clock import unhurried
from plogic.match.gamma.data import Data, centre_of, ideal_camera
from plogic.match.oriented.oriented_match import Noise
from plogic.match.oriented.pair_index import PairIndex


@dataclass(frozen=True, eq=False)
class TypedData:
    """``looks`` (A,) number of each datum's type, −1 for one that no sight has.

    Of the D data that some sight looks like and that have an angle: ``places`` (D, 2) ideal pixels, ``angles`` (D,)
    radians, type by type; those of type n are ``count`` (L + 1,) from ``first`` (L + 1,) on; the last type has none:
    that of what is padded, −1.
    """

    looks: Indices
    places: Floats
    angles: Floats
    first: Indices
    count: Indices

    def of(self, looks: NDArray[np.integer[Any]]) -> tuple[Indices, Indices]:
        """All data of types ``looks`` (S,): (N,) whose it is, and (N,) its place in the table."""
        count = self.count[looks]
        row = np.repeat(np.arange(len(looks)), count)
        return row, np.arange(len(row)) + np.repeat(self.first[looks] - (np.cumsum(count) - count), count)


def typed_data(data: Data, names: Sequence[str]) -> TypedData:
    """The data that have an angle; ``names`` of the appearance types, by number."""
    number = {name: i for i, name in enumerate(names)}
    looks = np.array([number.get(name, -1) for name in data.types], np.intp)
    some = np.flatnonzero((looks >= 0) & np.isfinite(data.angle))
    some = some[np.lexsort((data.angle[some], *data.ideal[some].T, looks[some]))]  # ties must not follow the order of Γ
    count = np.bincount(looks[some], minlength=len(names) + 1)
    return TypedData(looks, data.ideal[some], data.angle[some], np.cumsum(count) - count, count)


NOWHERE = 1e-6
"""Share of their mean distance from the image's centre by which the mean of the data is off it, where it says of no
direction."""


def turn_of(data: Data, which: Mask) -> float:
    """Radians, clockwise on the screen from +x, to the mean of the data ``which`` (A,), from the image's centre.

    0 where they have none.

    Their order decides nothing, to the last bit.
    """
    off = data.ideal[which] - centre_of(data.camera)
    x, y, far = (fsum(values.tolist()) for values in (*off.T, np.hypot(*off.T)))
    return atan2(y, x) if np.hypot(x, y) > NOWHERE * far else 0.0


def turned(data: Data, angle: float) -> Data:
    """Places in the ideal image, and angles, clockwise by ``angle``; what Γ itself says, in its own pixels, stays."""
    return replace(data, ideal=places_turned(data.ideal, centre_of(data.camera), angle), angle=data.angle + angle)


def places_turned(uv: Floats, centre: Floats, angle: float) -> Floats:
    """(N, 2) ideal pixels, clockwise about the ``centre`` (2,)."""
    cos, sin = np.cos(angle), np.sin(angle)
    x, y = (uv - centre).T
    return np.column_stack([cos * x - sin * y, sin * x + cos * y]) + centre


def poses_turned(poses: Floats, angle: float) -> Floats:
    """camera_from_object (..., 4, 4) of the camera in whose image all is turned clockwise by ``angle``."""
    cos, sin = np.cos(angle), np.sin(angle)
    x, y = poses[..., 0, :], poses[..., 1, :]
    return np.stack([cos * x - sin * y, sin * x + cos * y, poses[..., 2, :], poses[..., 3, :]], axis=-2)


class Chances(NamedTuple):
    """``hit`` (K,) rate of an expected feature, by number of its type in the index.

    ``clutter`` (L,) appearances of an image that are no object's.

    The latter by number of the appearance type.
    """

    hit: Floats
    clutter: Floats


def chances_of(index: PairIndex, rates: Rates) -> Chances:
    """As the evidence takes them (``plogic.match.judged.evidence``)."""
    hit = [rates.hit.get(name, 0.8) for name in index.feature_types[0]]
    return Chances(np.array(hit), np.array([rates.clutter.get(name, 1.0) for name in index.looks]))


@dataclass(frozen=True, eq=False)
class Asked:
    """``turn``: by how much all is turned, radians clockwise.

    ``check`` is called between stages, and may raise to end the search.
    """

    index: PairIndex
    data: Data
    noise: Noise
    chances: Chances
    turn: float = 0.0
    check: Callable[[], None] = unhurried

    @cached_property
    def typed(self) -> TypedData:
        """Γ by what its data look like."""
        return typed_data(self.data, self.index.looks)

    def of(self, left: Data) -> "Asked":
        """The same, of what is ``left`` of the data."""
        return replace(self, data=left)

    @cached_property
    def camera(self) -> Camera:
        """That of the ideal image, in which all is compared."""
        return ideal_camera(self.data.camera)

    def upright(self) -> "Asked":
        """The same, turned to where its data say."""
        turn = turn_of(self.data, (self.typed.looks >= 0) & np.isfinite(self.data.angle))
        return replace(self, data=turned(self.data, -turn), turn=self.turn - turn)

    def inside(self, uv: Floats) -> Mask:
        """(N,) whether ideal pixels (N, 2), turned as the data are, are in the image."""
        back = places_turned(uv, centre_of(self.camera), -self.turn) if self.turn else uv
        return np.asarray(((back >= 0.0) & (back < [self.camera.width, self.camera.height])).all(axis=1))

    @property
    def area(self) -> float:
        """Of the image, square pixels."""
        return float(self.camera.width * self.camera.height)
