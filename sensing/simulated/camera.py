"""The simulated camera: bodies, a lamp, a floor and a background go in; pixels, depth and segmentation come out.

Bodies are drawn by pybullet's TinyRenderer at ``supersample`` times the size and averaged down (a pixel is the mean
light over its square); floor, background and shadows are drawn behind them; then the lens blurs and the sensor adds
noise.

From the house's camera to the matrices that TinyRenderer wants.

In TinyRenderer a pixel's centre has whole viewport coordinates, and its picture lies one of its own pixels too high:
passing cx and cy + 1 without OpenGL's half pixel mends both (tested against projected points).
"""

from __future__ import annotations

import tempfile
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from sensing.errors import SceneError
from sensing.simulated.client import client
from sensing.simulated.lighting import Light, shading_normals
from sensing.simulated.surroundings import Surroundings, draw_surroundings, floor_depth

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from geometry.camera import Camera
    from sensing.simulated.body import Body

_GL_FROM_CV = np.diag([1.0, -1.0, -1.0, 1.0])
TINY_RENDERER_ROWS = 1.0


NEAR, FAR = 0.05, 100.0
MAX_TRIANGLES = 40_000
"""More triangles than this in one body do not fit pybullet's shared memory."""


@dataclass(frozen=True)
class Sensor:
    """``noise``: standard deviation, grey levels per channel; ``blur``: the lens' standard deviation, pixels; ``seed`` of the noise."""

    noise: float = 3.5
    blur: float = 0.4
    seed: int = 0


@dataclass(frozen=True, eq=False)
class Rendering:
    """One picture with its ground truth.

    Attributes:
        image: (H, W, 3) uint8, blue first.
        depth: (H, W) float32 metres along the optical axis at the pixel's centre; inf where there is nothing.
        segmentation: (H, W) int32 index into the bodies at the pixel's centre; -1 floor or background.
    """

    image: NDArray[np.uint8]
    depth: NDArray[np.float32]
    segmentation: NDArray[np.int32]


def render(
    bodies: Sequence[Body],
    camera: Camera,
    light: Light | None = None,
    surroundings: Surroundings | None = None,
    sensor: Sensor | None = None,
    supersample: int = 3,
) -> Rendering:
    """Take a picture. The same arguments give the same bytes.

    Raises:
        SceneError: The camera has no pose or has lens distortion, or a body has too many triangles.
    """
    light, sensor = light or Light(), sensor or Sensor()
    colour, segmentation, depth = _draw_bodies(bodies, camera, light, supersample)
    picture = _composed(colour, segmentation, draw_surroundings(camera, bodies, light, surroundings or Surroundings()))
    middle = slice(supersample // 2, None, supersample)
    seen, depth = segmentation[middle, middle], depth[middle, middle]
    whole_depth = np.where(seen >= 0, depth, floor_depth(camera)).astype(np.float32)
    return Rendering(_sensed(picture, sensor), whole_depth, np.ascontiguousarray(seen, np.int32))


def visible_fractions(bodies: Sequence[Body], camera: Camera) -> tuple[float, ...]:
    """Per body: the share of its own picture (alone, within the image) that the others leave visible; 0 where it is not in the image."""
    with client() as (bullet, number), tempfile.TemporaryDirectory() as folder:
        numbers = [add_body(bullet, number, body, Light(), Path(folder) / f"{i}.png") for i, body in enumerate(bodies)]
        together = shoot(bullet, number, camera, 1, Light())[1]
        places = [bullet.getBasePositionAndOrientation(n, physicsClientId=number) for n in numbers]
        fractions = []
        for own in numbers:
            for n, (at, quat) in zip(numbers, places, strict=True):
                away = at if n == own else (0.0, 0.0, 1e4)
                bullet.resetBasePositionAndOrientation(n, away, quat, physicsClientId=number)
            alone = int((shoot(bullet, number, camera, 1, Light())[1] == own).sum())
            fractions.append(int((together == own).sum()) / alone if alone else 0.0)
    return tuple(fractions)


def _draw_bodies(
    bodies: Sequence[Body], camera: Camera, light: Light, supersample: int
) -> tuple[NDArray[np.uint8], NDArray[np.int32], NDArray[np.float32]]:
    with client() as (bullet, number), tempfile.TemporaryDirectory() as folder:
        for i, body in enumerate(bodies):
            add_body(bullet, number, body, light, Path(folder) / f"{i}.png")
        return shoot(bullet, number, camera, supersample, light)


def add_body(bullet: Any, number: int, body: Body, light: Light, texture_file: Path) -> int:  # noqa: ANN401 - pybullet is untyped
    """Put one body into the client: every triangle has its own three vertices, so that facets are flat."""
    import cv2

    mesh = body.mesh
    if len(mesh.triangles) > MAX_TRIANGLES:
        raise SceneError(
            f"body {body.label!r}: {len(mesh.triangles)} triangles are more than the {MAX_TRIANGLES} that can be drawn"
        )
    uv = np.zeros((len(mesh.vertices), 2)) if mesh.uv is None else np.asarray(mesh.uv)
    shape = bullet.createVisualShape(
        bullet.GEOM_MESH,
        vertices=mesh.corners.reshape(-1, 3).tolist(),
        indices=list(range(3 * len(mesh.triangles))),
        uvs=uv[mesh.triangles].reshape(-1, 2).tolist(),
        normals=np.repeat(shading_normals(body, light), 3, axis=0).tolist(),
        rgbaColor=[*mesh.colour, 1.0],
        physicsClientId=number,
    )
    at, quat = body.world_from_body[:3, 3].tolist(), _quat_xyzw(body.world_from_body[:3, :3])
    placed: int = bullet.createMultiBody(
        0, baseVisualShapeIndex=shape, basePosition=at, baseOrientation=quat, physicsClientId=number
    )
    if mesh.texture is not None:
        cv2.imwrite(str(texture_file), mesh.texture)
        texture = bullet.loadTexture(str(texture_file), physicsClientId=number)
        bullet.changeVisualShape(placed, -1, textureUniqueId=texture, physicsClientId=number)
    return placed


def shoot(
    bullet: Any,  # noqa: ANN401 - pybullet is untyped
    number: int,
    camera: Camera,
    supersample: int,
    light: Light,
) -> tuple[NDArray[np.uint8], NDArray[np.int32], NDArray[np.float32]]:
    """Colour (h, w, 3) blue first, segmentation (h, w) by pybullet's body number, depth (h, w) metres, at the supersampled size."""
    width, height = camera.width * supersample, camera.height * supersample
    answer = bullet.getCameraImage(
        width,
        height,
        view_matrix(camera),
        projection_matrix(camera, supersample, NEAR, FAR),
        lightDirection=(light.unit * 1e3).tolist(),
        lightColor=[1, 1, 1],
        shadow=0,
        lightAmbientCoeff=0.0,
        lightDiffuseCoeff=1.0,
        lightSpecularCoeff=0.0,
        renderer=bullet.ER_TINY_RENDERER,
        physicsClientId=number,
    )
    colour = np.asarray(answer[2], np.uint8).reshape(height, width, 4)[:, :, 2::-1]
    buffer = np.asarray(answer[3], np.float32).reshape(height, width)
    depth = FAR * NEAR / (FAR - (FAR - NEAR) * buffer)
    return colour, np.asarray(answer[4], np.int32).reshape(height, width), depth.astype(np.float32)


def _composed(
    colour: NDArray[np.uint8], segmentation: NDArray[np.int32], behind: NDArray[np.float32]
) -> NDArray[np.float32]:
    """Average the bodies' light over each pixel's square and let the surroundings through where they leave some."""
    import cv2

    size = (behind.shape[1], behind.shape[0])
    own = (segmentation >= 0).astype(np.uint8)
    share = np.asarray(cv2.resize(own * 255, size, interpolation=cv2.INTER_AREA), np.float32)[:, :, None] / 255
    mean = np.asarray(cv2.resize(colour * own[:, :, None], size, interpolation=cv2.INTER_AREA), np.float32)
    return np.asarray(mean + (1 - share) * behind, np.float32)


def _sensed(picture: NDArray[np.float32], sensor: Sensor) -> NDArray[np.uint8]:
    import cv2

    if sensor.blur > 0:
        picture = np.asarray(cv2.GaussianBlur(picture, (0, 0), sensor.blur), np.float32)
    noise = np.random.default_rng([sensor.seed, 2]).standard_normal(picture.shape, dtype=np.float32)
    return np.clip(np.rint(picture + sensor.noise * noise), 0, 255).astype(np.uint8)


def _quat_xyzw(R: NDArray[np.float64]) -> list[float]:
    from scipy.spatial.transform import Rotation

    return [float(x) for x in Rotation.from_matrix(R).as_quat()]


def view_matrix(camera: Camera) -> list[float]:
    """OpenGL view matrix, column-major, of a camera with a pose in the world; raises SceneError where it has none."""
    if camera.world_from_camera is None:
        raise SceneError("camera: has no pose in the world (T_world_camera)")
    return _columns(_GL_FROM_CV @ np.linalg.inv(camera.world_from_camera))


def projection_matrix(camera: Camera, supersample: int, near: float, far: float) -> list[float]:
    """OpenGL projection matrix, column-major, for an image ``supersample`` times as wide and high; near and far in metres."""
    if np.any(camera.dist):
        raise SceneError(f"camera: the simulated camera has no lens distortion, but dist is {list(camera.dist)}")
    K = supersampled(np.asarray(camera.K, dtype=np.float64), supersample)
    width, height = camera.width * supersample, camera.height * supersample
    P = np.zeros((4, 4))
    P[0, 0], P[0, 2] = 2 * K[0, 0] / width, 1 - 2 * K[0, 2] / width
    P[1, 1], P[1, 2] = 2 * K[1, 1] / height, 2 * (K[1, 2] + TINY_RENDERER_ROWS) / height - 1
    P[2, 2], P[2, 3] = -(far + near) / (far - near), -2 * far * near / (far - near)
    P[3, 2] = -1
    return _columns(P)


def supersampled(K: NDArray[np.float64], factor: int) -> NDArray[np.float64]:
    """K (3, 3) of the image that is ``factor`` times larger; an integer stays a pixel's centre: u' = (u + ½) factor − ½."""
    larger = K.copy()
    larger[:2] *= factor
    larger[:2, 2] += (factor - 1) / 2
    return larger


def _columns(matrix: NDArray[np.float64]) -> list[float]:
    return [float(x) for x in matrix.T.reshape(-1)]
