"""Rendered scenes with the troubles of photos, whose plane is known and who stands on what.

Two to six things of the types, a quarter of them on another, 15 % held in the air or leaning; packages of no type; a
table with an edge, or the whole floor. From 10 to 80° above the table, evenly. No camera knows where up is.

* ``SupportScene``: a table-top scene with its stances, typed things first
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from benchmarks.photos.answers import Shown
from benchmarks.photos.scenes import FLOORS, troubled
from benchmarks.photos.score import Posed
from benchmarks.recognition.scenes import HARD
from benchmarks.recognition.score import HALF
from benchmarks.support.arranged import Put, Stance, kinds_of, put_together, stays
from benchmarks.support.solids import Solid
from benchmarks.tabletop.patterns import pattern, random_package
from benchmarks.tabletop.rgbd_sensor import random_sensor
from benchmarks.tabletop.scene import Arrangement, TabletopScene, random_light, random_table, viewed
from geometry.bodies.resting import Plane
from geometry.frames import inverse
from sensing.errors import SceneError
from sensing.simulated.body import Body, TexturedMesh

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from benchmarks.tabletop.table import Table
    from geometry.arrays import Floats
    from geometry.camera import Camera

FIRST = 40_000
"""First seed of the scenes of seed 0: those of ``plogic bench photos --simulated`` begin at 20000, those that odds are
learned from at 5000."""
STEP = 1000
"""How far apart the first seeds of two seeds of the benchmark are."""
THINGS = 2, 6
WANTED = Arrangement(THINGS, (0.35, 1.4), (60.0, 400.0))
TILTS = 10.0, 80.0
"""Degrees between the view and the table."""
GOLDEN = (5**0.5 - 1.0) / 2.0
"""Steps of this share, over 1 from the start again, fill a range evenly however many they are."""
SPREAD = 0.08, 0.2
"""Metres from the middle within which things are put, about."""
EDGED = 0.5
"""Share of the scenes in which the table has an edge."""
BOARD = 0.03, 0.7
"""Metres: how thick a table's top is, and how far above the floor."""
RIM = 0.02, 0.3
"""Metres from what stands on the table to its edge."""
TEXELS = 1536
ATTEMPTS, PATIENCE = 2000, 200
"""Arrangements of one scene; and after how many others are stacked and free: from above, a high stack is never half
visible."""


@dataclass(frozen=True, eq=False)
class SupportScene(TabletopScene):
    """A scene whose first bodies are of types, each with its ``stances``; what they stand on is z = 0."""

    stances: tuple[Stance, ...] = ()

    @property
    def plane(self) -> Plane:
        """What the standing ones stand on, in the camera's frame."""
        camera_from_world = inverse(np.asarray(self.camera.world_from_camera))
        up = camera_from_world[:3, 2]
        return Plane(up, -float(up @ camera_from_world[:3, 3]))


class Stood(NamedTuple):
    """A picture, the plane of what stands there, camera frame, and how each of its truths is held."""

    shown: Shown
    plane: Plane
    stances: tuple[Stance, ...]


def pictures_of(groups: Sequence[Sequence[Solid]], numbers: Sequence[int]) -> Iterator[Stood]:
    """The pictures of these seeds; labels of solids are BOP numbers."""
    for i, number in enumerate(numbers):
        scene = support_scene(groups, number, i)
        poses = scene.camera_from_bodies[: len(scene.stances)]
        truths = tuple(Posed(int(str(b.label)), pose) for b, pose in zip(scene.bodies, poses, strict=False))
        shown = Shown(f"{number}", scene.photograph().image, replace(scene.camera, world_from_camera=None), truths)
        yield Stood(shown, scene.plane, scene.stances)


def support_scene(groups: Sequence[Sequence[Solid]], seed: int, turn: int) -> SupportScene:
    """The scene of a seed, of types that each group has as many of; its tilt and light go by its ``turn``.

    Raises:
        SceneError: No such scene was found.
    """
    rng = np.random.default_rng([seed, 53])
    elevation, hard = TILTS[0] + (TILTS[1] - TILTS[0]) * (turn * GOLDEN % 1.0), HARD[turn % len(HARD)]
    wanted = replace(WANTED, elevation=(elevation, elevation))
    most = min(THINGS[1], sum(len(group) for group in groups))
    number = int(rng.integers(min(THINGS[0], most), most + 1))
    packages = [Solid(None, random_package(rng)) for _ in range(int(rng.choice(3, p=wanted.packages)))]
    for attempt in range(ATTEMPTS):
        if attempt % PATIENCE == 0:
            kinds = kinds_of(number, rng)
        things = list(zip(_chosen(groups, number, rng), kinds, strict=True))
        placed = put_together(things, packages, rng, float(rng.uniform(*SPREAD)))
        found = viewed([put.body for put in placed], rng, wanted, seen=(HALF, 1.0)) if placed else None
        if placed and found and TILTS[0] <= tilt(found[0]) <= TILTS[1] and stays(placed):
            return _scene(placed, number, found, rng, hard)
    raise SceneError(f"seed {seed}: no scene of {number} things was found in {ATTEMPTS} arrangements")


def tilt(camera: Camera) -> float:
    """Degrees between the view and the table."""
    return float(np.degrees(np.arcsin(-np.asarray(camera.world_from_camera)[2, 2])))


def _chosen(groups: Sequence[Sequence[Solid]], number: int, rng: np.random.Generator) -> list[Solid]:
    """Types, none of them twice, each of a group of chance that has one left."""
    left = [list(rng.permutation(len(group))) for group in groups]
    chosen = []
    for _ in range(number):
        some = [i for i, order in enumerate(left) if order]
        group = int(rng.choice(some))
        chosen.append(groups[group][left[group].pop()])
    return chosen


def _scene(
    placed: Sequence[Put], typed: int, found: tuple[Camera, tuple[float, ...]], rng: np.random.Generator, hard: float
) -> SupportScene:
    camera, fractions = found
    bodies, stances = tuple(put.body for put in placed), tuple(put.stance for put in placed[:typed])
    table, light, sensor = random_table(rng, camera, hard), random_light(rng, hard), random_sensor(rng, hard)
    plain = troubled(SupportScene(bodies, camera, light, table, sensor, fractions, stances=stances), rng)
    edged = _on_a_board(plain, placed, rng) if rng.random() < EDGED else plain
    return replace(edged, surroundings=_walled(edged.surroundings, edged.bodies))


def _on_a_board(scene: SupportScene, placed: Sequence[Put], rng: np.random.Generator) -> SupportScene:
    """The scene on a table whose top has the floor's pattern, above a floor with another."""
    table = scene.surroundings
    outlines = np.concatenate([put.corners[:, :2] for put in placed])
    board = Body(None, _board(outlines, table.floor_pattern, rng), np.eye(4))
    below = replace(table, floor_pattern=str(rng.choice(list(FLOORS))), floor_metres=1.2, floor_height=-BOARD[1])
    return replace(scene, bodies=(*scene.bodies, board), fractions=(*scene.fractions, 1.0), surroundings=below)


def _board(places: Floats, name: str, rng: np.random.Generator) -> TexturedMesh:
    """A table's top under ``places`` (N, 2), of any direction; its rim has the colour of a corner of its pattern."""
    angle = rng.uniform(0.0, np.pi)
    turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    own = places @ turn
    low, high = own.min(axis=0) - rng.uniform(*RIM, 2), own.max(axis=0) + rng.uniform(*RIM, 2)
    corners = np.array([low, (high[0], low[1]), high, (low[0], high[1])])
    flat = corners @ turn.T
    top, bottom = np.c_[flat, np.zeros(4)], np.c_[flat, np.full(4, -BOARD[0])]
    uv = np.concatenate([(corners - low) / (high - low).max(), np.full((8, 2), 0.01)])
    sides = [t for i in range(4) for t in ((8 + i, 8 + (i + 1) % 4, 4 + (i + 1) % 4), (8 + i, 4 + (i + 1) % 4, 4 + i))]
    return TexturedMesh(
        np.concatenate([top, top, bottom]), np.array([(0, 1, 2), (0, 2, 3), *sides]), uv, pattern(name, rng, TEXELS)
    )


def _walled(table: Table, bodies: Sequence[Body]) -> Table:
    """The wall behind everything, and not through it."""
    behind = np.array([np.cos(table.wall_azimuth), np.sin(table.wall_azimuth), 0.0])
    reach = max(float((body.vertices_world @ behind).max()) for body in bodies)
    return replace(table, wall_distance=max(table.wall_distance, reach + 0.05))
