"""Propose poses on the plane under accepted objects, where gravity holds (``plogic.facts.spatial``).

What two accepted objects or more stand on is one plane. What else stands there is then looked for on it alone, with far
fewer ways to stand than a free body has poses; what leans, hangs or lies on something else is found as before, by the
search that knows of no plane.

* ``Support``: the plane, and which hypotheses stand on it, ``Support(Plane(...), (0, 2))``
"""

from collections.abc import Sequence
from contextlib import closing
from typing import NamedTuple, Protocol

import numpy as np

from geometry.arrays import Floats
from geometry.bodies.resting import Plane, RestingFaces
from plogic.facts.hypothesis import Hypothesis
from plogic.match.gamma.data import Data
from plogic.match.judged.type_models import Given, Request
from plogic.match.kinds import Models

TILT, GAP = 0.087, 0.02
"""Two objects stand on one plane whose normals differ by less (radians, 5 degrees), and whose heights do by less than
this share of the distance."""
FEWEST = 2
"""Objects that must agree on a plane: one alone could stand on any of its faces."""


class Support(NamedTuple):
    """``plane``, camera frame.

    ``by``: places in the list of those that stand on it, increasing, one resting face each.
    """

    plane: Plane
    by: tuple[int, ...]


class Standing(Protocol):
    """What can stand: a ``TypeModel``, or a body without one."""

    @property
    def centre(self) -> Floats:
        """(3,) m, its middle, object frame."""
        ...

    @property
    def resting(self) -> RestingFaces:
        """The faces that it stands on."""
        ...


class _Stand(NamedTuple):
    """One way in which an object may stand.

    Whose it is, the plane's normal (3,), its middle (3,), and the middle's height above the plane.
    """

    owner: int
    up: Floats
    middle: Floats
    height: float


def support_of(posed: Sequence[tuple[Standing, Floats]]) -> Support | None:
    """The plane below the camera on which most of these objects, of known poses (4, 4), can stand.

    Of equals the one they agree on best.

    None where no two agree. Its normal and its height are the means of theirs.
    """
    stands = [stand for owner, (index, pose) in enumerate(posed) for stand in _stands(owner, index, pose)]
    agreed = [_agreeing(stand, stands) for stand in stands]
    best = max(agreed, key=lambda some: (len(some), -_spread(some)), default=[])
    if len(best) < FEWEST:
        return None
    up = np.mean([stand.up for stand in best], axis=0)
    up /= np.linalg.norm(up)
    offset = float(np.mean([stand.height - up @ stand.middle for stand in best]))
    return Support(Plane(up, offset), tuple(sorted(stand.owner for stand in best)))


def _stands(owner: int, index: Standing, pose: Floats) -> list[_Stand]:
    middle = pose[:3, :3] @ index.centre + pose[:3, 3]
    ups, offsets = index.resting.planes(pose)
    return [
        _Stand(owner, up, middle, float(up @ middle + offset))
        for up, offset in zip(ups, offsets, strict=True)
        if offset > 0.0
    ]


def _agreeing(mine: _Stand, stands: Sequence[_Stand]) -> list[_Stand]:
    """Of each object, this one's own aside, the way to stand that is nearest to this one's plane, if any is near."""
    best: dict[int, _Stand] = {mine.owner: mine}
    for other in stands:
        between = (mine.middle + other.middle) / 2.0  # an error of tilt does least where it is measured between the two
        gap = (
            (mine.up - other.up) @ between
            + mine.height
            - mine.up @ mine.middle
            - other.height
            + other.up @ other.middle
        )
        near = mine.up @ other.up > np.cos(TILT) and abs(gap) < GAP * np.linalg.norm(between)
        if (
            other.owner != mine.owner
            and near
            and (other.owner not in best or mine.up @ other.up > mine.up @ best[other.owner].up)
        ):
            best[other.owner] = other
    return list(best.values())


def _spread(some: Sequence[_Stand]) -> float:
    """How far normals are from their mean."""
    ups = np.array([stand.up for stand in some])
    return float(((ups - ups.mean(axis=0)) ** 2).sum())


def supported(
    accepted: Sequence[Hypothesis], models: Models, left: Data, given: Given, request: Request
) -> tuple[list[Hypothesis], str | None]:
    """The hypotheses that the free data suggest on the plane that accepted objects stand on, and that in words.

    Nothing, and None, without a plane.

    Only types are looked for of which none is accepted.
    """
    support = support_of([(models[belief.type], belief.camera_from_object) for belief in accepted])
    if support is None:
        return [], None
    found: list[Hypothesis] = []
    for kind in models.kinds.values():
        with closing(kind.resting(support.plane, left, given, request)) as searches:
            request.check()
            for some in searches:
                found += [posed for _, posed in some]
                request.check()
    who = ", ".join(accepted[i].object_type.name for i in support.by)
    return (
        found,
        f"{who} stand on one plane, {support.plane.offset:.2f} m below the camera: {len(found)} poses that stand there are tried",
    )
