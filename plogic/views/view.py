"""One image of a sequence, and where its camera stood.

Vocabulary: ``View``, ``View("v1", gamma, world_from_camera)``.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from sensing.appearance import Gamma


@dataclass(frozen=True, eq=False)
class View:
    """One image of a sequence: ``id`` ('v1'), its Γ, and where its camera stood: ``world_from_camera`` (4, 4), metres, world z up."""

    id: str
    gamma: Gamma
    world_from_camera: NDArray[np.float64]
