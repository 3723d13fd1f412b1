"""What may stand where, as plain data: all that looking ahead needs, whatever it was perceived by.

* ``Cloud``: how a type is seen, ``Cloud("t2", features=("roof/apex", ...), kinds=("apex", ...), lobes=table, hit=[0.95,
  ...], rays=..., ...)``
* ``Body``: one hypothesis, ``Body("h2", cloud, reference_from_object, opaque=True)``
* ``Prospect``: bodies, worlds over them with their probabilities, and the detector, ``Prospect(bodies, present,
  probability, ...)``

The *reference* frame is any one in which bodies and candidate cameras are both told: the present camera's, or the
world's.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from geometry.frames import transform_points

if TYPE_CHECKING:
    from collections.abc import Mapping

    from geometry.arrays import Floats, Mask
    from geometry.visibility.rays import RayMesh
    from kb.clouds.lobes import LobeTable


@dataclass(frozen=True, eq=False)
class Cloud:
    """How a type is seen: F ``features`` by id, their ``kinds`` (types), L lobes (§2.7), and how often each is reported, ``hit`` (L,).

    ``rays``: its surface, None where it has none. ``middle`` (3,) and ``radius``, m, object frame. ``slack``, m: how
    far before a feature the surface must be met to hide it (§3.4); ``measured``: lobes were measured on the body
    itself, which then hides nothing more of its own.
    """

    name: str
    features: tuple[str, ...]
    kinds: tuple[str, ...]
    lobes: LobeTable
    hit: Floats
    rays: RayMesh | None
    middle: Floats
    radius: float
    slack: float
    measured: bool = False


@dataclass(frozen=True, eq=False)
class Body:
    """One hypothesis at ``reference_from_object`` (4, 4), m."""

    id: str
    cloud: Cloud
    reference_from_object: Floats
    opaque: bool

    @property
    def middle(self) -> Floats:
        """(3,) m, reference frame."""
        return transform_points(self.reference_from_object, self.cloud.middle[None])[0]


@dataclass(frozen=True, eq=False)
class Prospect:
    """B bodies and W worlds: ``present`` (W, B), ``probability`` (W,) that sums to 1 over those that are listed.

    ``rivals``: unordered pairs of ids that never hide each other (§4.1). ``clutter``: expected data of noise an image,
    by appearance type, of any
    other type one. ``tolerance``: pixels (D8). ``f_ref``: pixels (§2.7).
    """

    bodies: tuple[Body, ...]
    present: Mask
    probability: Floats
    rivals: frozenset[frozenset[str]]
    clutter: Mapping[str, float]
    tolerance: float
    f_ref: float

    @property
    def marginals(self) -> Floats:
        """(B,) P(present) of each body over the listed worlds."""
        return np.asarray(self.probability @ self.present)

    @property
    def middle(self) -> Floats | None:
        """(3,) m, reference frame: the middle of what may be there, by its probability; None where nothing is."""
        weights = self.marginals
        if not len(weights) or weights.sum() <= 0.0:
            return None
        return np.asarray(weights @ np.array([body.middle for body in self.bodies]) / weights.sum())

    @property
    def radius(self) -> float:
        """M from the middle within which everything is that may be there; 0 where nothing is."""
        middle = self.middle
        if middle is None:
            return 0.0
        some = [body for body, weight in zip(self.bodies, self.marginals, strict=True) if weight > 0.0]
        return max(float(np.linalg.norm(body.middle - middle)) + body.cloud.radius for body in some)
