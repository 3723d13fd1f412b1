"""Rendered pictures with the troubles of photos: tables with things on them, as a plain colour camera sees them.

Objects of 40 to 400 pixels among packages with print of no type, on floors with text as small as print's; noise, then
sharpening and JPEG; white balance off by up to a third; highlights; the lamp's shadows. Every sixth picture shows none
of the types.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, TypeVar

import numpy as np

from benchmarks.photos.answers import Shown
from benchmarks.photos.score import Posed
from benchmarks.recognition.scenes import EMPTY_EVERY, HARD, half_turns
from benchmarks.recognition.score import HALF
from benchmarks.tabletop.rgbd_sensor import RgbdSensor
from benchmarks.tabletop.scene import Arrangement, TabletopScene, recognition_scene

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping, Sequence
    from pathlib import Path

    from plogic.run.bop.models import Model
    from sensing.simulated.body import TexturedMesh

Photographed = TypeVar("Photographed", bound=TabletopScene)
FIRST = 20_000
"""First seed of the pictures of seed 0: from 5000 on odds of pixels are learned (``benchmarks/pixel_odds.py``)."""
STEP = 1000
"""How far apart the first seeds of two seeds of the benchmark are."""
PRINTED = 1, 2, 3, 4, 5, 6, 7, 8, 9, 12
"""Types of ``ycb`` with print, by their BOP numbers."""
PLAIN = 10, 11, 13, 14, 15, 21
"""Types without: banana, pitcher, bowl, mug, power drill, foam brick."""
BOXES = (21,)
"""Types whose half turns leave them as they are, though ``models_info.json`` has none: foam brick."""
MM = 0.001
BANDS = (
    Arrangement((1, 2), (0.22, 0.45), (40.0, 400.0), 0.0, (0.2, 0.4, 0.4)),
    Arrangement((2, 4), (0.45, 0.8), (40.0, 400.0), 0.5, (0.2, 0.4, 0.4)),
    Arrangement((3, 5), (0.7, 1.7), (40.0, 400.0), 0.5, (0.2, 0.4, 0.4)),
)
"""Near, middle and far, in turn: one range of distances alone would show hardly any large ones, which fit in by one or
two."""
FLOORS = {"newsprint": 0.35, "label": 0.25, "wood": 0.15, "noise": 0.15, "checks": 0.1}
OFF = 1 / 3
"""Largest share by which blue and red are off."""


def shapes_of(models: Path, numbers: Sequence[int]) -> dict[int, TexturedMesh]:
    """The painted meshes of a BOP models folder, metres. Raises SceneError, ImageError."""
    from sensing.simulated.body import read_mesh

    return {number: read_mesh(models / f"obj_{number:06d}.ply", MM) for number in numbers}


def as_symmetric(models: Mapping[int, Model]) -> dict[int, Model]:
    """The models, ``BOXES`` with the half turns that their shape allows."""
    turns = {number: half_turns(models[number].points) for number in BOXES if number in models}
    return dict(models) | {
        number: replace(models[number], symmetries=np.concatenate([np.eye(4)[None], own]))
        for number, own in turns.items()
    }


def photos(shapes: Mapping[int, TexturedMesh], count: int, seed: int) -> Iterator[Shown]:
    """So many pictures; of what is less than half visible nobody asks."""
    named = [(str(number), mesh) for number, mesh in shapes.items()]
    for i in range(count):
        number = FIRST + STEP * seed + i
        scene = photo_scene(named, number, i)
        truths: tuple[list[Posed], list[Posed]] = [], []
        for body, pose, fraction in zip(scene.bodies, scene.camera_from_bodies, scene.fractions, strict=True):
            if body.label is not None:
                truths[fraction < HALF].append(Posed(int(body.label), pose))
        camera = replace(scene.camera, world_from_camera=None)
        yield Shown(f"{number}", scene.photograph().image, camera, tuple(truths[0]), tuple(truths[1]))


def photo_scene(named: Sequence[tuple[str, TexturedMesh]], seed: int, turn: int) -> TabletopScene:
    """The scene of a seed; what it is like goes by its ``turn``: empty, near or far, how hard its light is."""
    rng = np.random.default_rng([seed, 41])
    empty, hard = turn % EMPTY_EVERY == EMPTY_EVERY - 1, HARD[(turn + turn // EMPTY_EVERY) % len(HARD)]
    scene = recognition_scene(
        named, seed, arranged=_fitting(BANDS[turn % len(BANDS)], len(named)), empty=empty, hard=hard
    )
    return troubled(scene, rng)


def troubled(scene: Photographed, rng: np.random.Generator) -> Photographed:
    """The scene with a photo's troubles: print on the floor, highlights, white balance, what the camera does."""
    blue, red = rng.uniform(1 - OFF, 1 + OFF, 2)
    table = scene.surroundings
    worse = replace(
        table,
        floor_pattern=str(rng.choice(list(FLOORS), p=list(FLOORS.values()))),
        floor_metres=float(rng.uniform(0.3, 0.9)),
        gloss=float(rng.uniform(0.05, 0.4)),
        lamp_colour=_times(table.lamp_colour, blue, red),
        sky_colour=_times(table.sky_colour, blue, red),
    )
    return replace(scene, surroundings=worse, sensor=_sensor(rng))


def _fitting(band: Arrangement, types: int) -> Arrangement:
    """No more bodies than there are types."""
    few, many = band.bodies
    return replace(band, bodies=(min(few, types), min(many, types)))


def _times(colour: tuple[float, float, float], blue: float, red: float) -> tuple[float, float, float]:
    return (float(colour[0] * blue), colour[1], float(colour[2] * red))


def _sensor(rng: np.random.Generator) -> RgbdSensor:
    """A camera of chance: noise, a little blur, what exposure misses, sharpening, JPEG."""
    return RgbdSensor(
        noise=float(rng.uniform(1.5, 6.0)),
        blur=float(rng.uniform(0.4, 1.0)),
        seed=int(rng.integers(2**31)),
        gain=float(rng.uniform(0.8, 1.25)),
        gamma=float(rng.uniform(0.8, 1.2)),
        vignette=float(rng.uniform(0.0, 0.3)),
        jpeg=int(rng.integers(60, 96)),
        sharpening=float(rng.uniform(0.0, 1.5)),
    )
