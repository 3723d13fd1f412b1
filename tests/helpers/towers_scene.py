"""Two towers in numbers: shapes, poses, a camera, and ``photograph()``, their image by the painter's algorithm."""

from __future__ import annotations

import cv2
import numpy as np

WIDTH, HEIGHT, FOCAL = 640, 480, 600.0
EYE, TARGET = np.array([-2.1, -2.65, 1.95]), np.array([0.18, 0.02, 0.68])


def camera_from_world() -> np.ndarray:
    """Return the 4x4 transform of a camera at EYE that looks at TARGET (OpenCV axes)."""
    z = (TARGET - EYE) / np.linalg.norm(TARGET - EYE)
    x = np.cross(z, [0, 0, 1])
    x /= np.linalg.norm(x)
    rotation = np.stack([x, np.cross(z, x), z])
    out = np.eye(4)
    out[:3, :3], out[:3, 3] = rotation, -rotation @ EYE
    return out


def shape(kind: str) -> tuple[np.ndarray, list[tuple[int, ...]]]:
    """Return the vertices (V, 3) in metres and the faces of a tower, counter-clockwise from outside."""
    a, b = (0.4, 0.3) if kind == "t1" else (0.35, 0.35)
    base = [(-a, -b, 0), (a, -b, 0), (a, b, 0), (-a, b, 0)]
    tops = (1.1, 1.5, 1.5, 1.1) if kind == "t1" else (1.0,) * 4
    vertices = np.array([*base, *((x, y, z) for (x, y, _), z in zip(base, tops, strict=True)), (0, 0, 1.5)], float)
    walls = [(0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7)]
    roof = [(4, 5, 6, 7)] if kind == "t1" else [(4, 5, 8), (5, 6, 8), (6, 7, 8), (7, 4, 8)]
    return vertices[: 8 if kind == "t1" else 9], [*walls, *roof, (3, 2, 1, 0)]


def triangles(faces: list[tuple[int, ...]]) -> list[list[int]]:
    """Return the fan triangulation of the faces."""
    return [[f[0], f[i], f[i + 1]] for f in faces for i in range(1, len(f) - 1)]


def windows(kind: str, rows: int, columns: int) -> list[tuple[str, np.ndarray, np.ndarray, np.ndarray]]:
    """Return (name, centre, normal, corners (4, 3)) of every painted window of the walls, in the object's frame."""
    vertices, faces = shape(kind)
    out = []
    for side, face in zip(("south", "east", "north", "west"), faces[:4], strict=True):
        p, right = vertices[face[0]], vertices[face[1]] - vertices[face[0]]
        normal = np.cross(right, [0, 0, 1]) / np.linalg.norm(right)
        for i in range(rows):
            for j in range(columns):
                centre = p + right * (j + 1) / (columns + 1) + np.array([0, 0, 0.22 + 0.62 * i / max(1, rows - 1)])
                u, v = right / (4.2 * (columns + 1) / 1.6), np.array([0, 0, 0.075])
                out.append(
                    (
                        f"{side}/p{i}{j}",
                        centre,
                        normal,
                        np.array([centre - u - v, centre + u - v, centre + u + v, centre - u + v]),
                    )
                )
    return out


def project(points: np.ndarray) -> np.ndarray:
    """Project camera points (..., 3) to pixels (..., 2)."""
    return points[..., :2] / points[..., 2:] * FOCAL + np.array([WIDTH / 2, HEIGHT / 2])


def apply(transform: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Transform points (..., 3) by a 4x4."""
    return points @ transform[:3, :3].T + transform[:3, 3]


def placed(x: float, y: float, yaw: float) -> np.ndarray:
    """Return camera_from_object of a tower on the floor."""
    c, s = np.cos(yaw), np.sin(yaw)
    world = np.array([[c, -s, 0, x], [s, c, 0, y], [0, 0, 1, 0], [0, 0, 0, 1]], float)
    return camera_from_world() @ world


POSES = {
    "h1": ("t1", placed(-0.42, -0.22, 0.12)),
    "h2": ("t2", placed(0.80, 0.10, 0.55)),
    "h3": ("t2", placed(0.88, 0.20, 0.95)),
    "h4": ("t1", placed(0.45, -0.45, -0.7)),
}


def meets(point: np.ndarray, mesh: np.ndarray) -> bool:
    """Tell whether the segment from the camera to the point meets one of the triangles (T, 3, 3) strictly before it."""
    a, e1, e2 = mesh[:, 0], mesh[:, 1] - mesh[:, 0], mesh[:, 2] - mesh[:, 0]
    p = np.cross(point, e2)
    det = np.einsum("ij,ij->i", e1, p)
    u = np.einsum("ij,ij->i", -a, p) / det
    q = np.cross(-a, e1)
    v, t = q @ point / det, np.einsum("ij,ij->i", e2, q) / det
    return bool(np.any((u >= 0) & (v >= 0) & (u + v <= 1) & (t > 0) & (t < 0.99)))


def photograph(rows: int = 3, columns: int = 3) -> np.ndarray:
    """Return the image (480, 640, 3), BGR: a wall, a floor, two towers with windows."""
    rng = np.random.default_rng(5)
    v = np.linspace(0, 1, HEIGHT)[:, None, None]
    image = np.repeat(np.where(v < 0.43, [196, 190, 178], [150, 160, 168]) * (1.05 - 0.18 * v), WIDTH, axis=1)
    image += cv2.GaussianBlur(rng.normal(0, 22, (HEIGHT, WIDTH)).astype(np.float32), (0, 0), 5)[..., None] * 2
    image = np.ascontiguousarray(image.clip(0, 255).astype(np.uint8))
    light = camera_from_world()[:3, :3] @ np.array([-0.75, -0.35, 0.6])
    for name, wall in (("h2", (205, 214, 226)), ("h1", (190, 216, 232))):
        _paint(image, name, np.array(wall), light, (rows, columns))
    noisy = cv2.GaussianBlur(image, (0, 0), 0.6).astype(float) + rng.normal(0, 2.5, image.shape)
    return noisy.clip(0, 255).astype(np.uint8)


def _paint(image: np.ndarray, name: str, wall: np.ndarray, light: np.ndarray, grid: tuple[int, int]) -> None:
    kind, pose = POSES[name]
    vertices, faces = shape(kind)
    points = apply(pose, vertices)
    for face in faces:
        corners = points[list(face)]
        normal = np.cross(corners[1] - corners[0], corners[2] - corners[0])
        normal /= np.linalg.norm(normal)
        if normal @ corners[0] < 0:
            _fill(image, project(corners), wall * (0.62 + 0.38 * max(0.0, float(normal @ light))))
    for _, centre, normal, corners in windows(kind, *grid):
        if (pose[:3, :3] @ normal) @ apply(pose, centre) < 0:
            _fill(image, project(apply(pose, corners)), np.array([70, 58, 52]))


def _fill(image: np.ndarray, polygon: np.ndarray, colour: np.ndarray) -> None:
    cv2.fillPoly(image, [np.round(polygon * 16).astype(np.int32)], tuple(float(c) for c in colour), cv2.LINE_AA, 4)
