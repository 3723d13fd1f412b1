"""What the things of one view stand on, and how (§9.9): planes, stable poses and their prior choices, as plain data.

Vocabulary, each with an example value:

* ``SupportPlane("s1", (0.0, -0.8, -0.6), -0.9, covariance, prior=0.7)``: a plane of the camera's frame.
* ``Stance("h1", "s1", 2, chance=0.3, log_ratio=4.1)``: h1 stands on s1 with the third of its type's stable poses.
* ``Support(rests=0.9, none=0.05, planes, stances)``: all of it.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Iterable

FREE, NONE = "free", "none"
"""In facts and queries, the stance of what rests on nothing known, and that nothing says where things stand."""

Row = tuple[float, float, float]
"""Three numbers: a vector, or a row of a 3×3 matrix."""


@dataclass(frozen=True)
class SupportPlane:
    """A plane that things may stand on: ``normal``·x = ``offset`` in the camera's frame, metres.

    ``normal`` is a unit vector that points upwards, against gravity; the camera is ``-offset`` above the plane.
    ``covariance`` is over the tilts about x and y (rad) and the offset (m). ``prior`` is its share of the one choice
    that an image makes among planes.
    """

    name: str
    normal: Row
    offset: float
    covariance: tuple[Row, Row, Row]
    prior: float


@dataclass(frozen=True)
class Stance:
    """One way of standing: ``hypothesis`` stands on a plane, or on another hypothesis, by name.

    ``face`` says which of its type's stable poses. ``chance`` is the prior chance of this way given that what it stands
    on is there. ``log_ratio`` is ln ρ: how much better the pose fits this way than that of a free body.
    """

    hypothesis: str
    on: str
    face: int
    chance: float
    log_ratio: float


@dataclass(frozen=True)
class Support:
    """The choice of one plane for an image, and of one way of standing for each hypothesis.

    ``rests``: the chance that a present object rests on something known or on a plane. ``none``: the chance that
    nothing says where things stand. What is left beside ``none`` and the planes' priors is the chance of a plane that
    is none of those named.
    """

    rests: float
    none: float
    planes: tuple[SupportPlane, ...]
    stances: tuple[Stance, ...]

    def among(self, kept: Iterable[str]) -> Support:
        """What it says of these hypotheses alone."""
        known = frozenset(kept)
        there = known | {plane.name for plane in self.planes}
        stances = tuple(s for s in self.stances if s.hypothesis in known and s.on in there)
        return replace(self, stances=stances)
