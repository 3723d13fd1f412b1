"""Bodies ready to be drawn: by pybullet's TinyRenderer, or by rays where pybullet is not installed.

* ``Stage``: ``with stage(bodies, light) as drawn: colour, segmentation, depth = drawn.shoot(camera, 3)``

In TinyRenderer a pixel's centre has whole viewport coordinates, and its picture lies one of its own pixels too high.
Passing cx and cy + 1 without OpenGL's half pixel mends both (tested against projected points).
"""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from functools import cached_property
from pathlib import Path
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from geometry.camera import Camera
from geometry.files.begun import scratch
from sensing.errors import SceneError
from sensing.simulated.body import Body
from sensing.simulated.physics import client, has_physics
from sensing.simulated.raycast import Cast, Caster
from sensing.simulated.surroundings import Light, brightness, placed_at, shading_normals

Shot = tuple[NDArray[np.uint8], NDArray[np.int32], NDArray[np.float32]]


_GL_FROM_CV = np.diag([1.0, -1.0, -1.0, 1.0])
TINY_RENDERER_ROWS = 1.0


NEAR, FAR = 0.05, 100.0
MAX_TRIANGLES = 40_000
"""More triangles than this in one body do not fit pybullet's shared memory."""
RAYS = 1 << 18
"""Rays that are cast at once; more take memory and no less time."""


class Stage(Protocol):
    """Bodies, lit, before any number of cameras."""

    def shoot(self, camera: Camera, supersample: int) -> Shot:
        """Draw all bodies, at ``supersample`` times the camera's size.

        Returns colour (h, w, 3), blue first; segmentation (h, w), the index of a body or -1; depth (h, w), metres along
        the optical axis, of no account where there is no body. Raises SceneError where the camera has no pose in the
        world, or has lens distortion.
        """

    def alone(self, which: int, camera: Camera) -> NDArray[np.int32]:
        """Return the segmentation (h, w) of a picture that has only the body of this index."""


@contextmanager
def stage(bodies: Sequence[Body], light: Light) -> Iterator[Stage]:
    """Set up the bodies in the world frame; with pybullet where it is installed, else for rays.

    Raises:
        SceneError: A body has too many triangles for TinyRenderer.
    """
    if not has_physics():
        yield _Rays(bodies, light)
        return
    with client() as (bullet, number), scratch() as folder:
        numbers = [_add_body(bullet, number, body, light, folder / f"{i}.png") for i, body in enumerate(bodies)]
        yield _TinyRenderer(bullet, number, numbers, light)


class _Rays:
    """Facets of one brightness each, as TinyRenderer draws them; textures without aliasing."""

    def __init__(self, bodies: Sequence[Body], light: Light) -> None:
        self._bodies, self._light = bodies, light

    @cached_property
    def _caster(self) -> Caster:
        return Caster(self._bodies)

    @cached_property
    def _facets(self) -> NDArray[np.float64]:
        """(T, 3) normals of all triangles, world frame."""
        return np.concatenate([body.mesh.normals @ body.world_from_body[:3, :3].T for body in self._bodies])

    @cached_property
    def _brightness(self) -> NDArray[np.float64]:
        return brightness(self._facets, self._light)

    def shoot(self, camera: Camera, supersample: int) -> Shot:
        """Cast a ray a pixel."""
        sight = _Sight(camera, supersample, self._bodies)
        colour = np.zeros((*sight.shape, 3), np.uint8)
        segmentation = np.full(sight.shape, -1, np.int32)
        depth = np.full(sight.shape, FAR, np.float32)
        for window, rays in sight.windows():
            found = self._caster.cast(sight.eye, rays)
            own = colour[window].shape[:2]
            colour[window] = self._paint(found, rays, sight.pixel).reshape(*own, 3)
            segmentation[window] = found.body.reshape(own)
            depth[window] = np.where(found.body >= 0, found.depth, FAR).reshape(own)
        return colour, segmentation, depth

    def alone(self, which: int, camera: Camera) -> NDArray[np.int32]:
        """Cast at that body alone."""
        body = [self._bodies[which]]
        sight, caster = _Sight(camera, 1, body), Caster(body)
        segmentation = np.full(sight.shape, -1, np.int32)
        for window, rays in sight.windows():
            own = caster.cast(sight.eye, rays).body.reshape(segmentation[window].shape)
            segmentation[window] = np.where(own >= 0, which, -1)
        return segmentation

    def _paint(self, found: Cast, rays: NDArray[np.float64], pixel: float) -> NDArray[np.uint8]:
        """(N, 3) light of what each ray (N, 3) met, blue first.

        ``pixel``: between neighbouring rays, at a depth of 1.
        """
        some = np.maximum(found.triangle, 0)
        steepness = np.abs(np.einsum("nx,nx->n", self._facets[some], rays)) / np.linalg.norm(rays, axis=1)
        light = self._caster.colours(found, found.depth * pixel, steepness) * self._brightness[some, None]
        return np.rint(np.clip(light, 0, 255)).astype(np.uint8)


class _Sight:
    """The pixels of a picture ``supersample`` times as large, as world rays of length 1 along the optical axis."""

    def __init__(self, camera: Camera, supersample: int, bodies: Sequence[Body]) -> None:
        self._world_from_camera = placed_at(camera)
        self._K = _undistorted(camera, supersample)
        self._bodies = bodies
        self.shape = camera.height * supersample, camera.width * supersample
        self.eye, self.pixel = self._world_from_camera[:3, 3], 1.0 / float(self._K[0, 0])

    def windows(self) -> Iterator[tuple[tuple[slice, slice], NDArray[np.float64]]]:
        """Rows and columns, and their rays (N, 3), row by row; together they hold all pixels that show a body."""
        rows, columns = self._around()
        across, down, ahead = (self._world_from_camera[:3, :3] @ np.linalg.inv(self._K)).T
        step = max(1, RAYS // max(1, columns.stop - columns.start))
        u = np.arange(columns.start, columns.stop, dtype=np.float64)[:, None] * across + ahead
        for top in range(rows.start, rows.stop if len(u) else rows.start, step):
            some = slice(top, min(top + step, rows.stop))
            v = np.arange(some.start, some.stop, dtype=np.float64)[:, None, None] * down
            yield (some, columns), (u + v).reshape(-1, 3)

    def _around(self) -> tuple[slice, slice]:
        """Rows and columns of the bodies' box in the picture.

        All of them where a body is beside or behind the camera.
        """
        height, width = self.shape
        if not self._bodies:
            return slice(0, 0), slice(0, 0)
        camera_from_world = np.linalg.inv(self._world_from_camera)
        places = np.concatenate([body.vertices_world for body in self._bodies])
        x, y, z = (places @ camera_from_world[:3, :3].T + camera_from_world[:3, 3]).T
        if z.min() < NEAR:
            return slice(0, height), slice(0, width)
        u, v = self._K[0, 0] * x / z + self._K[0, 2], self._K[1, 1] * y / z + self._K[1, 2]
        ends = [
            (int(np.clip(np.floor(a.min()), 0, n)), int(np.clip(np.ceil(a.max()) + 1, 0, n)))
            for a, n in ((v, height), (u, width))
        ]
        return slice(*ends[0]), slice(*ends[1])


class _TinyRenderer:
    """The client ``number`` of pybullet, whose ``numbers`` are the bodies'."""

    def __init__(self, bullet: Any, number: int, numbers: Sequence[int], light: Light) -> None:  # noqa: ANN401 - pybullet is untyped
        self._bullet, self._number, self._numbers, self._light = bullet, number, numbers, light

    def shoot(self, camera: Camera, supersample: int) -> Shot:
        """Draw all; in the segmentation stand pybullet's numbers of the bodies."""
        width, height = camera.width * supersample, camera.height * supersample
        answer = self._bullet.getCameraImage(
            width,
            height,
            view_matrix(camera),
            projection_matrix(camera, supersample, NEAR, FAR),
            lightDirection=(self._light.unit * 1e3).tolist(),
            lightColor=[1, 1, 1],
            shadow=0,
            lightAmbientCoeff=0.0,
            lightDiffuseCoeff=1.0,
            lightSpecularCoeff=0.0,
            renderer=self._bullet.ER_TINY_RENDERER,
            physicsClientId=self._number,
        )
        colour = np.asarray(answer[2], np.uint8).reshape(height, width, 4)[:, :, 2::-1]
        buffer = np.asarray(answer[3], np.float32).reshape(height, width)
        depth = FAR * NEAR / (FAR - (FAR - NEAR) * buffer)
        return colour, np.asarray(answer[4], np.int32).reshape(height, width), depth.astype(np.float32)

    def alone(self, which: int, camera: Camera) -> NDArray[np.int32]:
        """Draw all with the others far away."""
        bullet, client_ = self._bullet, {"physicsClientId": self._number}
        places = [bullet.getBasePositionAndOrientation(n, **client_) for n in self._numbers]
        try:
            for n, (at, quat) in zip(self._numbers, places, strict=True):
                away = at if n == self._numbers[which] else (0.0, 0.0, 1e4)
                bullet.resetBasePositionAndOrientation(n, away, quat, **client_)
            return self.shoot(camera, 1)[1]
        finally:
            for n, (at, quat) in zip(self._numbers, places, strict=True):
                bullet.resetBasePositionAndOrientation(n, at, quat, **client_)


def _add_body(bullet: Any, number: int, body: Body, light: Light, texture_file: Path) -> int:  # noqa: ANN401 - pybullet is untyped
    """Put one body into the client: every triangle has its own three vertices, so that facets are flat."""
    import cv2
    from scipy.spatial.transform import Rotation

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
    at, quat = (
        body.world_from_body[:3, 3].tolist(),
        Rotation.from_matrix(body.world_from_body[:3, :3]).as_quat().tolist(),
    )
    placed: int = bullet.createMultiBody(
        0, baseVisualShapeIndex=shape, basePosition=at, baseOrientation=quat, physicsClientId=number
    )
    if mesh.texture is not None:
        texture_file.write_bytes(cv2.imencode(".png", mesh.texture)[1].tobytes())
        texture = bullet.loadTexture(str(texture_file), physicsClientId=number)
        bullet.changeVisualShape(placed, -1, textureUniqueId=texture, physicsClientId=number)
    return placed


def view_matrix(camera: Camera) -> list[float]:
    """OpenGL view matrix, column-major, of a camera with a pose in the world; raises SceneError where it has none."""
    return _columns(_GL_FROM_CV @ np.linalg.inv(placed_at(camera)))


def projection_matrix(camera: Camera, supersample: int, near: float, far: float) -> list[float]:
    """OpenGL projection matrix, column-major, for an image ``supersample`` times as wide and high.

    Near and far in metres.
    """
    K = _undistorted(camera, supersample)
    width, height = camera.width * supersample, camera.height * supersample
    P = np.zeros((4, 4))
    P[0, 0], P[0, 2] = 2 * K[0, 0] / width, 1 - 2 * K[0, 2] / width
    P[1, 1], P[1, 2] = 2 * K[1, 1] / height, 2 * (K[1, 2] + TINY_RENDERER_ROWS) / height - 1
    P[2, 2], P[2, 3] = -(far + near) / (far - near), -2 * far * near / (far - near)
    P[3, 2] = -1
    return _columns(P)


def _undistorted(camera: Camera, supersample: int) -> NDArray[np.float64]:
    """K (3, 3) of the larger picture. Raises SceneError where the lens distorts."""
    if np.any(camera.dist):
        raise SceneError(f"camera: the simulated camera has no lens distortion, but dist is {list(camera.dist)}")
    return supersampled(np.asarray(camera.K, dtype=np.float64), supersample)


def supersampled(K: NDArray[np.float64], factor: int) -> NDArray[np.float64]:
    """K (3, 3) of the image that is ``factor`` times larger.

    An integer stays a pixel's centre: u' = (u + ½) factor − ½.
    """
    larger = K.copy()
    larger[:2] *= factor
    larger[:2, 2] += (factor - 1) / 2
    return larger


def _columns(matrix: NDArray[np.float64]) -> list[float]:
    return [float(x) for x in matrix.T.reshape(-1)]
