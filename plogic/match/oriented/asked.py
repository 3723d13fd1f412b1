"""What a search over all types asks of: their index, Γ, and what the KB says of the detector.

* ``Asked``: these together; ``Chances``: how often what is expected is found, and how often an appearance is there of
  itself
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from plogic.base.clock import unhurried
from plogic.match.gamma.data import centre_of, ideal_camera
from plogic.match.oriented.typed_data import typed_data
from plogic.match.oriented.upright import places_turned, turn_of, turned

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    from geometry.camera import Camera
    from kb.clouds.cloud import Rates
    from plogic.match.gamma.data import Data
    from plogic.match.oriented.angle_refinement import Noise
    from plogic.match.oriented.pair_index import PairIndex
    from plogic.match.oriented.typed_data import TypedData

    Floats = NDArray[np.float64]


class Chances(NamedTuple):
    """``hit`` (K,) rate of an expected feature, by number of its type in the index; ``clutter`` (L,) appearances of an image that are no object's.

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
    """``turn``: by how much all is turned, radians clockwise; ``check`` is called between stages, and may raise to end the search."""

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

    def of(self, left: Data) -> Asked:
        """The same, of what is ``left`` of the data."""
        return replace(self, data=left)

    @cached_property
    def camera(self) -> Camera:
        """That of the ideal image, in which all is compared."""
        return ideal_camera(self.data.camera)

    def upright(self) -> Asked:
        """The same, turned to where its data say."""
        turn = turn_of(self.data, (self.typed.looks >= 0) & np.isfinite(self.data.angle))
        return replace(self, data=turned(self.data, -turn), turn=self.turn - turn)

    def inside(self, uv: Floats) -> NDArray[np.bool_]:
        """(N,) whether ideal pixels (N, 2), turned as the data are, are in the image."""
        back = places_turned(uv, centre_of(self.camera), -self.turn) if self.turn else uv
        return np.asarray(((back >= 0.0) & (back < [self.camera.width, self.camera.height])).all(axis=1))

    @property
    def area(self) -> float:
        """Of the image, square pixels."""
        return float(self.camera.width * self.camera.height)
