"""Typed correspondences, which the plain generators start from: every feature with every datum that looks like it.

* ``Typed``: those of one type of objects
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from geometry.camera import Camera
    from kb.clouds.cloud import ObjectType
    from plogic.match.gamma.data import Data
    from plogic.match.hand.type_index import TypeIndex

    Floats = NDArray[np.float64]
    Indices = NDArray[np.intp]

FEWEST = 4
"""Matches of different features with different data that a pose needs: any three have one."""


class Typed(NamedTuple):
    """``points`` (F, 3) m: the features' places; P pairs, by feature and then by datum: ``feature`` (P,) and ``datum`` (P,)."""

    kind: ObjectType
    points: Floats
    feature: Indices
    datum: Indices

    @property
    def numbers(self) -> Indices:
        """(F,) how many data look like each feature."""
        return np.bincount(self.feature, minlength=len(self.points))

    def mask(self, data: int) -> NDArray[np.bool_]:
        """(F, A) which of so many data looks like which feature."""
        mask = np.zeros((len(self.points), data), bool)
        mask[self.feature, self.datum] = True
        return mask


def pairs_of(index: TypeIndex, data: Data) -> Typed:
    """All pairs of one type's features and data that look like them."""
    return Typed(index.object_type, index.points, *np.nonzero(index.allowed(data)))


def off(poses: Floats, pairs: Typed, uv: Floats, camera: Camera) -> Floats:
    """(N, P) pixels from where N poses show the pairs' features to their data, ``uv`` (A, 2) undistorted; infinite behind the camera."""
    at = np.einsum("nij,fj->nfi", poses[:, :3, :3], pairs.points) + poses[:, None, :3, 3]
    depth = np.where(at[..., 2] > 0.0, at[..., 2], np.nan)
    shown = camera.to_pixels(at[..., :2] / depth[..., None])
    return np.nan_to_num(np.linalg.norm(shown[:, pairs.feature] - uv[pairs.datum], axis=2), nan=np.inf)
