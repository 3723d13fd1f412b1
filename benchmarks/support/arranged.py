"""Things put on a table, on each other, and where they do not rest, with the truth of who stands on what.

* ``Stance("stacked", 0)``: it stands on the first of the things; ``Stance("standing")``: on the table
* ``Put``: a solid at its place, world frame (z up, the table at z = 0)

None reach into each other. Two of them are apart seen from above, or in height, or a plane lies between their hulls:
the top of the lower one of a stack, or that at which one leans on the other. Where there is physics, what rests stays
where it is.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Literal, NamedTuple

import numpy as np

from benchmarks.support.solids import Solid, holds, until_touching
from geometry.frames import transform_points
from sensing.simulated.body import Body
from sensing.simulated.physics import has_physics
from sensing.simulated.settling import Loose, let_go

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from shapely import Polygon

    from benchmarks.support.solids import Level
    from geometry.arrays import Floats

Kind = Literal["standing", "stacked", "free"]
STACKED, FREE = 0.25, 0.15
"""Shares of all things."""
LEANING = 0.5
"""Share of the free ones that lean on another; the others are held in the air."""
UPRIGHT = 0.6
"""Share of the standing ones that stand as their mesh's frame does."""
UP = np.array([0.0, 0.0, 1.0])
GAP = 0.004
"""Metres between things that do not touch."""
TRIES = 40
HELD = 0.03, 0.25
"""Metres from the table to the lowest place of what is held."""
LEAN = np.radians([15.0, 50.0])
"""How far what leans is turned from a pose in which it stands."""
ASTRAY = np.radians(10.0)
"""By how much, at least, what leans is turned from all such poses."""
STILL = 0.005
"""Metres that physics may move what rests in two seconds."""
BACK = 0.0002
"""Metres between what leans and what it leans on."""


class Stance(NamedTuple):
    """How a thing is held: by the table, by the thing of a number, or by nothing that is a support."""

    kind: Kind
    on: int | None = None


@dataclass(frozen=True, eq=False)
class Put:
    """A thing at ``world_from_solid`` (4, 4)."""

    solid: Solid
    pose: Floats
    stance: Stance

    @cached_property
    def corners(self) -> Floats:
        """(V, 3) of its hull, metres, world frame."""
        return transform_points(self.pose, self.solid.corners)

    @cached_property
    def outline(self) -> Polygon:
        """Seen from above."""
        return self.solid.outline(self.pose)

    @cached_property
    def top(self) -> Level | None:
        """Where something can stand on it."""
        return self.solid.top(self.pose)

    @property
    def middle(self) -> Floats:
        """(3,) of mass, world frame."""
        return self.solid.middle_at(self.pose)

    @property
    def body(self) -> Body:
        """What is drawn."""
        return Body(self.solid.label, self.solid.mesh, self.pose)

    def apart(self, other: Put) -> bool:
        """Whether they are ``GAP`` apart, seen from above or in height."""
        (low, high), (its_low, its_high) = ((p[:, 2].min(), p[:, 2].max()) for p in (self.corners, other.corners))
        return bool(low > its_high + GAP or its_low > high + GAP or self.outline.distance(other.outline) > GAP)


def kinds_of(number: int, rng: np.random.Generator) -> list[Kind]:
    """How each of so many things is held, those that stand first; of them all there are the shares that are asked for.

    One of them stands at least.
    """
    stacked, free = (share * number / max(number - 1, 1) for share in (STACKED, FREE))
    kinds: list[Kind] = ["standing", "stacked", "free"]
    drawn = rng.choice(3, number - 1, p=[1.0 - stacked - free, stacked, free])
    return ["standing", *(kinds[i] for i in np.sort(drawn))]


def put_together(
    things: Sequence[tuple[Solid, Kind]], packages: Sequence[Solid], rng: np.random.Generator, spread: float
) -> list[Put] | None:
    """The things, in their order, then the packages, which stand, about the origin; None where one finds no place.

    ``spread``: metres from the origin within which they are, about.
    """
    placed: list[Put] = []
    for solid, kind in (*things, *((package, "standing") for package in packages)):
        found = next((put for put in _tried(solid, kind, placed, rng, spread) if put is not None), None)
        if found is None:
            return None
        placed.append(found)
    return placed


def stays(placed: Sequence[Put]) -> bool:
    """Whether physics leaves all that rests where it is, what is free being held; unasked where there is none."""
    if not has_physics():
        return True
    names = [f"{i:02d}" for i in range(len(placed))]
    fates = let_go(
        [
            Loose(name, (put.solid.corners,), put.pose, put.stance.kind == "free")
            for name, put in zip(names, placed, strict=True)
        ]
    )
    return all(
        np.linalg.norm(put.solid.middle_at(fates[name].after) - put.middle) <= STILL
        for name, put in zip(names, placed, strict=True)
    )


def _tried(
    solid: Solid, kind: Kind | str, placed: Sequence[Put], rng: np.random.Generator, spread: float
) -> Iterator[Put | None]:
    """Places of chance that are tried; None of those that do not hold it, or that others have."""
    lean = rng.random() < LEANING
    for i in range(TRIES):
        if kind == "stacked":
            yield _stacked(solid, placed, rng)
        elif kind == "free" and lean:
            yield _leaning(solid, placed, rng)
        else:
            at = np.array([*rng.uniform(-1.0, 1.0, 2), 0.0]) * spread * (0.5 + i / TRIES)
            yield _clear(_held(solid, rng, at) if kind == "free" else _standing(solid, rng, at), placed)


def _clear(put: Put, placed: Sequence[Put], touched: int | None = None) -> Put | None:
    """The thing, where it is apart from all others but that which it touches."""
    return put if all(put.apart(other) for i, other in enumerate(placed) if i != touched) else None


def _turned(solid: Solid, rng: np.random.Generator, up: Floats) -> Floats:
    """On one of its faces, as its frame has it or any, turned by chance."""
    upright = solid.upright()
    face = int(rng.integers(len(solid.down)))
    if upright is not None and rng.random() < UPRIGHT:
        face = upright
    return solid.stood(face, up, float(rng.uniform(0.0, 2.0 * np.pi)))


def _standing(solid: Solid, rng: np.random.Generator, at: Floats) -> Put:
    return Put(solid, solid.footed(_turned(solid, rng, UP), UP, at), Stance("standing"))


def _held(solid: Solid, rng: np.random.Generator, at: Floats) -> Put:
    """In the air, turned by chance."""
    from scipy.spatial.transform import Rotation

    pose = np.eye(4)
    pose[:3, :3] = Rotation.random(random_state=rng).as_matrix()
    return Put(solid, solid.footed(pose, UP, at + rng.uniform(*HELD) * UP), Stance("free"))


def _stacked(solid: Solid, placed: Sequence[Put], rng: np.random.Generator) -> Put | None:
    """On the top of one that has one, so that neither falls."""
    tops = [(i, put.top) for i, put in enumerate(placed) if put.top is not None and put.stance.kind != "free"]
    if not tops:
        return None
    lower, level = tops[int(rng.integers(len(tops)))]
    west, south, east, north = level.area.bounds
    at = rng.uniform((west, south), (east, north))
    height = (level.height - level.up[:2] @ at) / level.up[2]
    pose = solid.footed(_turned(solid, rng, level.up), level.up, np.array([*at, height]))
    put = Put(solid, pose, Stance("stacked", lower))
    firm = holds(level.area.intersection(solid.area(pose, level.up)), put.middle)
    return _clear(put, placed, lower) if firm and _carried(put, placed) else None


def _carried(put: Put, placed: Sequence[Put]) -> bool:
    """Whether its middle of mass is over what all below it stand on: then the stack does not tip."""
    below = put.stance.on
    while below is not None:
        lower = placed[below]
        if not holds(lower.solid.area(lower.pose, _under(lower, placed)), put.middle):
            return False
        below = lower.stance.on
    return True


def _under(put: Put, placed: Sequence[Put]) -> Floats:
    """(3,) the normal of what it stands on."""
    level = None if put.stance.on is None else placed[put.stance.on].top
    return UP if level is None else level.up


def _leaning(solid: Solid, placed: Sequence[Put], rng: np.random.Generator) -> Put | None:
    """With its foot on the table and tilted against one that stands there; it would fall but for that one."""
    from scipy.spatial.transform import Rotation

    other = int(rng.integers(len(placed)))
    if placed[other].stance.kind != "standing":
        return None
    azimuth = rng.uniform(0.0, 2.0 * np.pi)
    along, aside = np.array([np.cos(azimuth), np.sin(azimuth), 0.0]), np.array([-np.sin(azimuth), np.cos(azimuth), 0.0])
    pose = _turned(solid, rng, UP)
    pose[:3, :3] = Rotation.from_rotvec(rng.uniform(*LEAN) * aside).as_matrix() @ pose[:3, :3]
    if (solid.down @ pose[:3, :3].T)[:, 2].min() < -np.cos(ASTRAY):
        return None
    start = placed[other].middle * (1.0, 1.0, 0.0) - along + rng.uniform(-0.02, 0.02) * aside
    apart = Put(solid, solid.footed(pose, UP, start), Stance("free"))
    met = until_touching(apart.corners, placed[other].corners, along)
    if met is None:
        return None
    pose = apart.pose.copy()
    pose[:3, 3] += (met[0] - BACK) * along
    put = Put(solid, pose, Stance("free"))
    foot = put.corners[put.corners[:, 2].argmin()]
    leans = foot @ along < put.middle @ along < met[1] @ along and met[1][2] > put.middle[2] / 2.0
    return _clear(put, placed, other) if leans else None
