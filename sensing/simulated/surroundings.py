"""Light, floor and background of the simulated picture, and the shadows on the floor.

Floor and background are procedural, seeded, of moderate contrast. The light is one lamp far away, the sky, and a little
from everywhere. TinyRenderer knows one lamp, so two facets turned away from it look alike. The brightness is therefore
computed here, per facet, and given to TinyRenderer as a normal whose cosine with its lamp is that brightness.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from geometry.camera import Camera
from sensing.errors import SceneError
from sensing.simulated.body import Body


@dataclass(frozen=True)
class Light:
    """A lamp's direction (world frame, towards it, any length) and the shares of the whole brightness, each in [0, 1].

    ``lamp`` · max(0, n·l) + ``sky`` · (1 + n_z)/2 + ``back`` · max(0, −n·l′) + ``ambient``, where l′ is l's horizontal
    part turned by 60°: what a wall in the shade gets back from its surroundings, so that two such walls differ.
    """

    direction: tuple[float, float, float] = (0.4, -0.5, 0.8)
    ambient: float = 0.30
    lamp: float = 0.45
    sky: float = 0.15
    back: float = 0.10

    @property
    def unit(self) -> NDArray[np.float64]:
        """(3,) unit vector towards the lamp, world frame."""
        d = np.asarray(self.direction, dtype=np.float64)
        return d / np.linalg.norm(d)


def brightness(normals_world: NDArray[np.float64], light: Light) -> NDArray[np.float64]:
    """(T,) brightness in [0, 1] of facets with (T, 3) unit outward normals in the world frame."""
    lamp = light.unit
    cos, sin = 0.5, np.sqrt(0.75)
    turned = np.array([cos * lamp[0] - sin * lamp[1], sin * lamp[0] + cos * lamp[1], 0.0])
    direct = light.lamp * np.maximum(normals_world @ lamp, 0)
    sky = light.sky * (1 + normals_world[:, 2]) / 2
    back = light.back * np.maximum(-normals_world @ turned, 0)
    return np.clip(light.ambient + direct + sky + back, 0, 1)


def shading_normals(body: Body, light: Light) -> NDArray[np.float64]:
    """(T, 3) unit vectors in the body frame whose cosine with the lamp is the facet's brightness."""
    R = body.world_from_body[:3, :3]
    shade = brightness(body.mesh.normals @ R.T, light)[:, None]
    lamp = light.unit
    across = np.cross(lamp, [1.0, 0, 0] if abs(lamp[0]) < 0.9 else [0, 1.0, 0])
    across /= np.linalg.norm(across)
    normals: NDArray[np.float64] = (shade * lamp + np.sqrt(1 - shade**2) * across) @ R
    return normals


TEXELS = 1024
FLOOR_METRES = 8.0
"""Side of the square of floor that the texture covers; beyond it the texture is mirrored."""
HAZE_METRES = 25.0


@dataclass(frozen=True)
class Surroundings:
    """What the floor (z = 0 of the world) and the background look like.

    ``contrast`` is the texture's standard deviation in grey levels.
    """

    seed: int = 0
    floor: tuple[float, float, float] = (118.0, 122.0, 126.0)
    background: tuple[float, float, float] = (150.0, 145.0, 140.0)
    contrast: float = 9.0
    shadow: float = 0.35


def draw_surroundings(camera: Camera, bodies: Sequence[Body], light: Light, look: Surroundings) -> NDArray[np.float32]:
    """(H, W, 3) float32 picture of floor and background without the bodies; colours blue first, 0 to 255."""
    rng = np.random.default_rng([look.seed, 1])
    picture = _background(camera, look, rng)
    far = floor_depth(camera)
    if not np.isfinite(far).any():
        return picture
    ground = _floor(camera, look, rng) * (1 - look.shadow * _shadow(camera, bodies, light)[:, :, None])
    clear = np.exp(-far / HAZE_METRES)[:, :, None]
    return np.where(clear > 0, clear * np.nan_to_num(ground) + (1 - clear) * picture, picture).astype(np.float32)


def floor_depth(camera: Camera) -> NDArray[np.float32]:
    """(H, W) depth along the optical axis at which each pixel's ray meets the floor, metres; inf where it does not."""
    world_from_camera = placed_at(camera)
    rays = _pixel_rays(camera)
    falling = rays @ world_from_camera[2, :3]
    with np.errstate(divide="ignore", invalid="ignore"):
        depth = -world_from_camera[2, 3] / falling
    return np.where((falling < -1e-9) & (depth > 1e-6), depth, np.inf).astype(np.float32)


def noise_texture(rng: np.random.Generator, shape: tuple[int, int], cells: Sequence[int]) -> NDArray[np.float32]:
    """(H, W, 3) float32 noise of several grains (cells across the width), mean 0 and deviation 1, mostly grey."""
    total = np.zeros((*shape, 3), np.float32)
    for n in cells:
        rows = max(2, round(n * shape[0] / shape[1]))
        grain = rng.normal(0, 1, (rows, n, 1)) + 0.35 * rng.normal(0, 1, (rows, n, 3))
        total += cv2.resize(grain.astype(np.float32), (shape[1], shape[0]), interpolation=cv2.INTER_CUBIC)
    return (total - total.mean()) / max(float(total.std()), 1e-6)


def placed_at(camera: Camera) -> NDArray[np.float64]:
    """world_from_camera (4, 4). Raises SceneError where the camera has no pose in the world."""
    if camera.world_from_camera is None:
        raise SceneError("camera: has no pose in the world (T_world_camera)")
    return np.asarray(camera.world_from_camera, dtype=np.float64)


def _pixel_rays(camera: Camera) -> NDArray[np.float64]:
    """(H, W, 3) directions with z = 1, camera frame."""
    v, u = np.mgrid[: camera.height, : camera.width].astype(np.float64)
    return np.stack([u, v, np.ones_like(u)], axis=-1) @ np.linalg.inv(camera.K).T


def _floor(camera: Camera, look: Surroundings, rng: np.random.Generator) -> NDArray[np.float32]:
    """(H, W, 3) floor without shadows; above the horizon of no account."""
    texture = look.floor + look.contrast * noise_texture(rng, (TEXELS, TEXELS), (12, 40, 130, 400))
    depth = np.minimum(floor_depth(camera), 10 * HAZE_METRES)[:, :, None]
    at = (_pixel_rays(camera) * depth) @ placed_at(camera)[:3, :3].T + placed_at(camera)[:3, 3]
    texel = _mirrored(at[:, :, :2] * (TEXELS / FLOOR_METRES)).astype(np.float32)
    return np.asarray(
        cv2.remap(texture.astype(np.float32), texel[:, :, 0], texel[:, :, 1], cv2.INTER_LINEAR), np.float32
    )


def _mirrored(texels: NDArray[np.float64]) -> NDArray[np.float64]:
    """Any coordinates folded into the texture, mirrored at its rims."""
    return (TEXELS - 1) - np.abs(np.mod(texels, 2 * (TEXELS - 1)) - (TEXELS - 1))


def _background(camera: Camera, look: Surroundings, rng: np.random.Generator) -> NDArray[np.float32]:
    shape = (camera.height, camera.width)
    slope = np.linspace(12, -12, camera.height, dtype=np.float32)[:, None, None]
    return np.asarray(look.background + slope + look.contrast * noise_texture(rng, shape, (6, 20, 60)), np.float32)


def _shadow(camera: Camera, bodies: Sequence[Body], light: Light) -> NDArray[np.float32]:
    """(H, W) share of the lamp that the bodies take from the floor, soft at the rim."""
    mask = np.zeros((camera.height, camera.width), np.uint8)
    lamp = light.unit
    if lamp[2] > 0.1:
        camera_from_world = np.linalg.inv(placed_at(camera))
        pixel_from_floor = np.linalg.inv(np.linalg.inv(np.asarray(camera.K) @ camera_from_world[:3, [0, 1, 3]]))
        for body in bodies:
            points = body.vertices_world
            ground = points[:, :2] - points[:, 2:] * lamp[:2] / lamp[2]
            homogeneous = np.c_[ground, np.ones(len(ground))] @ pixel_from_floor.T
            inside = homogeneous[body.mesh.triangles][:, :, 2].min(axis=1) > 0.05
            uv = homogeneous[:, :2] / np.where(np.abs(homogeneous[:, 2:]) < 1e-9, np.nan, homogeneous[:, 2:])
            triangles = np.clip(uv[body.mesh.triangles[inside]] * 16, -(2**20), 2**20).round().astype(np.int32)
            for triangle in triangles:
                cv2.fillConvexPoly(mask, triangle, 255, shift=4)
    return np.asarray(cv2.GaussianBlur(mask, (0, 0), 1.5), np.float32) / np.float32(255)
