"""One image of a sequence.

* ``View``: ``View("v1", Gamma(...), world_from_camera)``
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from geometry.arrays import Floats, frozen
from geometry.errors import GeometryError
from geometry.frames import inverse, is_rigid

if TYPE_CHECKING:
    from sensing.appearance import Gamma


@dataclass(frozen=True, eq=False)
class View:
    """One image of a sequence: ``id`` ('v1'), its Γ, and where its camera stood: ``world_from_camera`` (4, 4), metres, world z up."""

    id: str
    gamma: Gamma
    world_from_camera: Floats

    def __post_init__(self) -> None:
        """Keep a read-only pose, and Γ in its order. Raises GeometryError where the pose is not rigid."""
        if not is_rigid(self.world_from_camera):
            raise GeometryError(f"{self.id}: T_world_camera must be a rotation and a translation")
        object.__setattr__(self, "world_from_camera", frozen(self.world_from_camera))
        object.__setattr__(self, "gamma", self.gamma.in_order())

    @property
    def camera_from_world(self) -> Floats:
        """The inverse (4, 4)."""
        return inverse(self.world_from_camera)
