"""A table-top under a lamp before a wall, drawn by rays.

Floor and wall are painted with patterns, and everything casts shadows.

* ``Table(floor_pattern="newsprint", wall_pattern="plain", wall_distance=0.6)``
* ``photographed(bodies, camera, Light(), Table(), RgbdSensor())``: the picture with its depth and segmentation
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np

from benchmarks.tabletop.patterns import pattern
from benchmarks.tabletop.rgbd_sensor import sensed
from geometry.arrays import lengths, summed
from sensing.errors import SceneError
from sensing.simulated.camera import Rendering
from sensing.simulated.raycast import Caster, TexturePyramid
from sensing.simulated.surroundings import Surroundings

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from benchmarks.tabletop.rgbd_sensor import RgbdSensor
    from geometry.camera import Camera
    from sensing.simulated.body import Body
    from sensing.simulated.surroundings import Light

Colour = tuple[float, float, float]
TEXELS = 1536
BAND = 120
"""Rows of the image that are drawn at a time, to save memory."""
SOFT = 0.05
"""Radians between the middle of the lamp and where the samples of one pixel look for it: the softness of shadows."""
SHINE = 30.0
"""Exponent of the highlights."""


@dataclass(frozen=True)
class Table(Surroundings):
    """The floor (z = 0, or lower under a table), the wall behind it, and the lamp's colours.

    Colours are blue first; 1 is white of full strength.

    Attributes:
        floor_pattern: One of ``PATTERNS``; so is ``wall_pattern``.
        floor_metres: Side of the square that the floor's pattern covers; beyond it is repeated. ``wall_metres``
            likewise.
        floor_height: World z of the floor, metres.
        wall_distance: Metres from the world's origin to the wall.
        wall_azimuth: Radians from the world's x; the direction from the origin to the wall.
        lamp_colour: Of the direct light; ``sky_colour`` of the rest.
        gloss: Share of the lamp that bodies reflect as from a mirror.
    """

    floor_pattern: str = "wood"
    wall_pattern: str = "plain"
    floor_metres: float = 1.2
    wall_metres: float = 1.5
    floor_height: float = 0.0
    wall_distance: float = 0.8
    wall_azimuth: float = 0.0
    lamp_colour: Colour = (1.0, 1.0, 1.0)
    sky_colour: Colour = (1.0, 1.0, 1.0)
    gloss: float = 0.05


def photographed(
    bodies: Sequence[Body], camera: Camera, light: Light, table: Table, sensor: RgbdSensor, supersample: int = 2
) -> Rendering:
    """Take the picture, ``supersample``² rays a pixel. The same arguments give the same bytes.

    Raises:
        SceneError: The camera has no pose or has lens distortion, or there is no body.
    """
    if camera.world_from_camera is None or np.any(camera.dist) or not bodies:
        raise SceneError("table: the camera needs a pose in the world and no lens distortion, and there must be a body")
    stage = _Stage(Caster(bodies), camera, light, table)
    bands = [(top, min(top + BAND, camera.height)) for top in range(0, camera.height, BAND)]
    picture = np.concatenate([stage.light(band, supersample) for band in bands])
    truth = [stage.truth(band) for band in bands]
    depth, seen = (np.concatenate(parts) for parts in zip(*truth, strict=True))
    return Rendering(sensed(picture, sensor), depth.astype(np.float32), seen.astype(np.int32))


@lru_cache(maxsize=4)
def _painted(name: str, seed: int, stream: int) -> TexturePyramid:
    """The pattern of floor or wall: pictures of one table-top share it."""
    return TexturePyramid(pattern(name, np.random.default_rng([seed, stream]), TEXELS))


class _Stage:
    """Everything that stands still while one picture is taken."""

    def __init__(self, caster: Caster, camera: Camera, light: Light, table: Table) -> None:
        self.caster, self.camera, self.shares, self.table = caster, camera, light, table
        pose = np.asarray(camera.world_from_camera)
        self.eye, self.turn = pose[:3, 3], pose[:3, :3]
        self.lamp = light.unit
        self.paint = _painted(table.floor_pattern, table.seed, 6), _painted(table.wall_pattern, table.seed, 7)
        self.behind = np.array([np.cos(table.wall_azimuth), np.sin(table.wall_azimuth), 0.0])

    def rays(self, band: tuple[int, int], supersample: int) -> NDArray[np.float64]:
        """(rows, columns, 3) directions with z = 1 in the camera frame, turned into the world frame."""
        places = [
            (np.arange(n0 * supersample, n1 * supersample) + 0.5) / supersample - 0.5
            for n0, n1 in (band, (0, self.camera.width))
        ]
        v, u = np.meshgrid(*places, indexing="ij")
        return np.asarray(np.stack([u, v, np.ones_like(u)], axis=-1) @ (self.turn @ np.linalg.inv(self.camera.K)).T)

    def truth(self, band: tuple[int, int]) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
        """Depth and body at the pixels' centres."""
        rays = self.rays(band, 1)
        found = self.caster.cast(self.eye, rays.reshape(-1, 3))
        floor, wall = self._planes(rays.reshape(-1, 3))
        return np.minimum(found.depth, np.minimum(floor, wall)).reshape(rays.shape[:2]), found.body.reshape(
            rays.shape[:2]
        )

    def light(self, band: tuple[int, int], supersample: int) -> NDArray[np.float32]:
        """(rows, W, 3) mean light over each pixel's square."""
        import cv2

        grid = self.rays(band, supersample)
        rays = grid.reshape(-1, 3)
        found = self.caster.cast(self.eye, rays)
        floor, wall = self._planes(rays)
        depth = np.where(found.body >= 0, found.depth, np.minimum(floor, wall))
        back = np.where((floor <= wall)[:, None], (0.0, 0.0, 1.0), -self.behind)
        normal = np.where((found.body >= 0)[:, None], found.normal, back)
        point = self.eye + np.where(np.isfinite(depth), depth, 10.0)[:, None] * rays
        view = -rays / lengths(rays)[:, None]
        facing = np.abs(summed(normal * view))
        spread = np.where(np.isfinite(depth), depth, 10.0) / (float(self.camera.K[0, 0]) * supersample)
        colour = self.caster.colours(found, spread, facing)
        for k, (paint, own) in enumerate(zip(self.paint, (floor <= wall, floor > wall), strict=True)):
            chosen = own & (found.body < 0)
            colour[chosen] = self._colours(
                k, paint, point[chosen], spread[chosen] / np.sqrt(np.maximum(facing[chosen], 0.1))
            )
        shaded = self._shaded(colour, normal, view, self._lit(point, grid.shape[:2], supersample), found.body >= 0)
        picture = shaded.reshape(*grid.shape[:2], 3)
        return np.asarray(
            cv2.resize(picture, (self.camera.width, band[1] - band[0]), interpolation=cv2.INTER_AREA), np.float32
        )

    def _planes(self, rays: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Depths (N,) at which rays meet the floor and the wall; inf where they do not."""
        with np.errstate(divide="ignore", invalid="ignore"):
            floor = (self.table.floor_height - self.eye[2]) / rays[:, 2]
            wall = (self.table.wall_distance - self.eye @ self.behind) / (rays @ self.behind)
        return np.where(floor > 0, floor, np.inf), np.where(wall > 0, wall, np.inf)

    def _colours(
        self, which: int, paint: TexturePyramid, point: NDArray[np.float64], spread: NDArray[np.float64]
    ) -> NDArray[np.float32]:
        metres = (self.table.floor_metres, self.table.wall_metres)[which]
        rightwards = np.array([self.behind[1], -self.behind[0], 0.0])
        uv = point[:, :2] if which == 0 else np.c_[point @ rightwards, point[:, 2]]
        return paint.at(np.mod(uv / metres + 0.5, 1.0), spread * TEXELS / metres)

    def _lit(self, point: NDArray[np.float64], shape: tuple[int, int], supersample: int) -> NDArray[np.bool_]:
        """(N,) whether the lamp reaches the samples; those of one pixel look for different spots of it."""
        across = np.cross(self.lamp, (0.0, 0.0, 1.0) if abs(self.lamp[2]) < 0.9 else (1.0, 0.0, 0.0))
        across /= np.linalg.norm(across)
        row, column = (np.indices(shape).reshape(2, -1) % supersample + 0.5) / supersample - 0.5
        spot = self.lamp + 2 * SOFT * (row[:, None] * across + column[:, None] * np.cross(self.lamp, across))
        return self.caster.lit(point, spot)

    def _shaded(
        self,
        colour: NDArray[np.float32],
        normal: NDArray[np.float64],
        view: NDArray[np.float64],
        lit: NDArray[np.bool_],
        body: NDArray[np.bool_],
    ) -> NDArray[np.float32]:
        """(N, 3) light that leaves the surfaces: diffuse from lamp and sky, and on bodies the lamp's reflection."""
        shares = self.shares
        direct = lit * np.maximum(normal @ self.lamp, 0)
        sky = shares.ambient + shares.sky * (1 + normal[:, 2]) / 2
        light = shares.lamp * direct[:, None] * np.array(self.table.lamp_colour) + sky[:, None] * np.array(
            self.table.sky_colour
        )
        half = view + self.lamp
        half /= np.maximum(lengths(half)[:, None], 1e-12)
        glint = 255 * self.table.gloss * (lit & body) * np.maximum(summed(normal * half), 0) ** SHINE
        return np.asarray(colour * light + glint[:, None] * np.array(self.table.lamp_colour), np.float32)
