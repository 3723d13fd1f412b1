"""Bodies at given poses let go by pybullet: first pushed out of each other, then left to gravity.

Poses that were estimated reach a little into each other and into the floor, or hover a little above what they stand on.
A physics engine pays penetration back as speed, and throws apart what hardly touches. So bodies are first moved apart,
without turning and without any speed, until none reaches into another or below the floor; what is pushed how far is
told. Only then is gravity on.

* ``Loose("h1", parts, world_from_object)``: one body, made of convex parts; z is up and the floor is at 0
* ``Fate(pushed, after, still)``: where it was pushed, where it is in the end, and whether it had come to rest there
"""

from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from itertools import combinations
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from scipy.spatial import ConvexHull, QhullError

from geometry.arrays import Floats
from geometry.files.begun import scratch
from geometry.frames import quat_xyzw_from_rotation, transform_points
from sensing.simulated.physics import DENSITY, client

GRAVITY = 9.81
SECONDS = 2.0
STEP = 1 / 480
"""Seconds; a body falls 0.02 mm in the first."""
GRIP = {"lateralFriction": 0.9, "rollingFriction": 0.01, "spinningFriction": 0.01, "restitution": 0.0}
"""Of all bodies and the floor."""
DRAG = {"linearDamping": 0.2, "angularDamping": 0.4}
ROUNDS = 400
"""Times that bodies are moved apart at most."""
APART = 1e-4
"""Share of the smallest body's size by which bodies may reach into each other: less is rounding."""
SPEED, SPIN = 0.02, 0.1
"""Metres and radians a second below which a body has come to rest."""


class Loose(NamedTuple):
    """``parts``: corners (V, 3) m of convex bodies that fill it, object frame; ``pose`` (4, 4): world_from_object.

    ``held``: it stays where it is, and others meet it.
    """

    name: str
    parts: tuple[Floats, ...]
    pose: Floats
    held: bool = False


class Fate(NamedTuple):
    """World_from_object (4, 4) once nothing reaches into another, and after ``SECONDS``; ``still``: at rest then."""

    pushed: Floats
    after: Floats
    still: bool


class Filled(NamedTuple):
    """``middle`` (3,) m of its mass, object frame, and its ``volume``, m³."""

    middle: Floats
    volume: float


def filled(parts: Iterable[Floats]) -> Filled | None:
    """The mass of convex parts that share no volume; None where they have none."""
    found = [one for part in parts if (one := _hull(part)) is not None]
    volume = sum(one.volume for one in found)
    if not found or volume <= 0.0:
        return None
    return Filled(np.sum([one.volume * one.middle for one in found], axis=0) / volume, volume)


def _hull(corners: Floats) -> Filled | None:
    try:
        hull: Any = ConvexHull(corners)
    except QhullError:  # it is flat
        return None
    inside = corners[hull.vertices].mean(axis=0)
    spokes = corners[hull.simplices] - inside
    share = np.abs(np.linalg.det(spokes))
    return Filled(inside + share @ spokes.sum(axis=1) / (4.0 * share.sum()), float(hull.volume))


def let_go(bodies: Sequence[Loose]) -> dict[str, Fate]:
    """What becomes of each, by name, the order of ``bodies`` aside: the same bodies end the same.

    Each must be ``filled``.
    """
    placed = sorted(bodies, key=lambda body: body.name)
    if not placed:
        return {}
    with client() as (bullet, number), _world(bullet, number, placed) as world:
        world.move_apart()
        pushed = world.poses()
        world.fall()
        return {
            body.name: Fate(before, after, still)
            for body, before, after, still in zip(placed, pushed, world.poses(), world.still(), strict=True)
        }


@contextmanager
def _world(bullet: Any, number: int, bodies: Sequence[Loose]) -> Iterator["_World"]:  # noqa: ANN401 - pybullet is untyped
    with scratch() as folder:
        yield _World(bullet, number, bodies, folder)


class _World:
    """Bodies in a client of pybullet, in its units: the smallest is one across."""

    def __init__(self, bullet: Any, number: int, bodies: Sequence[Loose], folder: Path) -> None:  # noqa: ANN401 - pybullet is untyped
        self.bullet, self.at = bullet, {"physicsClientId": number}
        self.bodies = bodies
        corners = [np.concatenate(body.parts) for body in bodies]
        self.scale = 1.0 / min(float(np.linalg.norm(np.ptp(some, axis=0))) for some in corners)
        masses = [filled(body.parts) for body in bodies]
        self.middles = [np.zeros(3) if mass is None else mass.middle for mass in masses]
        self.corners = [some - middle for some, middle in zip(corners, self.middles, strict=True)]
        bullet.setPhysicsEngineParameter(
            fixedTimeStep=STEP, numSolverIterations=100, useSplitImpulse=1, deterministicOverlappingPairs=1, **self.at
        )
        floor = bullet.createCollisionShape(bullet.GEOM_PLANE, **self.at)
        self._grip(bullet.createMultiBody(0, floor, **self.at))
        volumes = [0.0 if mass is None else mass.volume for mass in masses]
        self.numbers = [
            self._load(folder / f"{i}.obj", body, self.middles[i], volumes[i]) for i, body in enumerate(bodies)
        ]

    def _load(self, file: Path, body: Loose, middle: Floats, volume: float) -> int:
        file.write_text(_obj((part - middle) * self.scale for part in body.parts), encoding="ascii")
        shape = self.bullet.createCollisionShape(self.bullet.GEOM_MESH, fileName=str(file), **self.at)
        mass = 0.0 if body.held else DENSITY * volume * self.scale**3
        loaded = int(self.bullet.createMultiBody(mass, shape, **self.at))
        self._grip(loaded)
        turn, at = body.pose[:3, :3], transform_points(body.pose, middle[None])[0]
        self._put(loaded, at * self.scale, quat_xyzw_from_rotation(turn))
        return loaded

    def _grip(self, loaded: int) -> None:
        self.bullet.changeDynamics(loaded, -1, **GRIP, **DRAG, **self.at)

    def _put(self, loaded: int, at: Floats, quat_xyzw: Floats) -> None:
        self.bullet.resetBasePositionAndOrientation(
            loaded, list(map(float, at)), list(map(float, quat_xyzw)), **self.at
        )

    def _where(self, loaded: int) -> tuple[Floats, Floats]:
        at, quat_xyzw = self.bullet.getBasePositionAndOrientation(loaded, **self.at)
        return np.array(at), np.array(quat_xyzw)

    def _turn(self, quat_xyzw: Floats) -> Floats:
        return np.array(self.bullet.getMatrixFromQuaternion(quat_xyzw.tolist())).reshape(3, 3)

    def poses(self) -> list[Floats]:
        """World_from_object (4, 4) of each body."""
        result = []
        for loaded, middle in zip(self.numbers, self.middles, strict=True):
            at, quat_xyzw = self._where(loaded)
            pose = np.eye(4)
            pose[:3, :3] = self._turn(quat_xyzw)
            pose[:3, 3] = at / self.scale - pose[:3, :3] @ middle
            result.append(pose)
        return result

    def move_apart(self) -> None:
        """Move bodies without turning them until none reaches into another, or below the floor."""
        for _ in range(ROUNDS):
            moves = self._out_of_each_other()
            for i in range(len(self.bodies)):
                self._shift(i, moves[i])
            raised = [self._above_the_floor(i) for i in range(len(self.bodies))]
            if max(float(np.abs(moves).max(initial=0.0)), *raised) <= APART:
                return

    def _out_of_each_other(self) -> Floats:
        """(N, 3) of each body half of the way out of those that it reaches into; the whole of what is held."""
        moves = np.zeros((len(self.bodies), 3))
        for i, j in combinations(range(len(self.bodies)), 2):
            loose = np.array([not self.bodies[i].held, not self.bodies[j].held], float)
            if not loose.any():
                continue
            touches = self.bullet.getClosestPoints(self.numbers[i], self.numbers[j], 0.0, **self.at)
            depth, way = min(((row[8], row[7]) for row in touches), default=(0.0, (0.0, 0.0, 0.0)))
            share = loose / loose.sum()
            moves[i] -= share[0] * depth * np.array(way)
            moves[j] += share[1] * depth * np.array(way)
        return moves

    def _above_the_floor(self, i: int) -> float:
        """Raise a body that reaches below the floor; how far."""
        at, quat_xyzw = self._where(self.numbers[i])
        low = at[2] + float((self.corners[i] @ self._turn(quat_xyzw)[2]).min()) * self.scale
        if low >= 0.0 or self.bodies[i].held:
            return 0.0
        self._shift(i, np.array([0.0, 0.0, -low]))
        return -low

    def _shift(self, i: int, move: Floats) -> None:
        at, quat_xyzw = self._where(self.numbers[i])
        self._put(self.numbers[i], at + move, quat_xyzw)

    def fall(self) -> None:
        """Leave the bodies to gravity."""
        self.bullet.setGravity(0, 0, -GRAVITY * self.scale, **self.at)
        for _ in range(round(SECONDS / STEP)):
            self.bullet.stepSimulation(**self.at)

    def still(self) -> list[bool]:
        """Whether each has come to rest."""
        speeds = [self.bullet.getBaseVelocity(loaded, **self.at) for loaded in self.numbers]
        return [
            bool(np.linalg.norm(linear) < SPEED * self.scale and np.linalg.norm(angular) < SPIN)
            for linear, angular in speeds
        ]


def _obj(parts: Iterable[Floats]) -> str:
    """Convex parts (V, 3) as Wavefront OBJ, an object each: pybullet makes one body of their hulls."""
    lines, first = [], 1
    for i, corners in enumerate(parts):
        lines += [f"o part{i}", *(f"v {x:.9g} {y:.9g} {z:.9g}" for x, y, z in corners.tolist())]
        hull: Any = ConvexHull(corners)
        lines += [f"f {a} {b} {c}" for a, b, c in (hull.simplices + first).tolist()]
        first += len(corners)
    return "\n".join(lines) + "\n"
