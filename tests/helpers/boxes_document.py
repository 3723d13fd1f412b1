"""Interpretations made by hand, of boxes on a floor that a camera looks down on from a metre's distance."""

from __future__ import annotations

from itertools import product
from typing import Any

import numpy as np

from geometry.frames import inverse, look_at

CAMERA_FROM_WORLD = look_at(np.array([0.9, -0.9, 0.8]), (0.0, 0.0, 0.05))
SIZES = {"crate": (0.2, 0.15, 0.1), "carton": (0.08, 0.06, 0.12), "slab": (0.3, 0.3, 0.04)}
"""Metres along x, y and z, from each type's origin in the middle of its base."""


def mesh(size: tuple[float, float, float]) -> dict[str, Any]:
    x, y, z = size
    vertices = [[sx * x / 2, sy * y / 2, sz * z] for sx, sy, sz in product((-1, 1), (-1, 1), (0, 1))]
    faces = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
    return {"vertices": vertices, "triangles": [t for a, b, c, d in faces for t in ([a, b, c], [a, c, d])]}


def at(x: float, y: float, z: float, turn: float = 0.0, lean: float = 0.0) -> np.ndarray:
    """world_from_object: turned about z, then leant about the world's x (radians)."""
    c, s, d, e = np.cos(turn), np.sin(turn), np.cos(lean), np.sin(lean)
    pose = np.eye(4)
    pose[:3, :3] = np.array([[1, 0, 0], [0, d, -e], [0, e, d]]) @ np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])
    pose[:3, 3] = x, y, z
    return pose


def hypothesis(name: str, kind: str, world_from_object: np.ndarray) -> dict[str, Any]:
    pose = CAMERA_FROM_WORLD @ world_from_object
    row = {"id": name, "type": kind, "T_camera_object": pose.tolist(), "opaque": True, "parts": []}
    return {**row, "group": name, "features": [], "status": "accepted", "probability": 0.9}


def boxes_document(*boxes: tuple[str, str, np.ndarray], ground: float | None = 0.0) -> dict[str, Any]:
    """Of boxes (name, type, world_from_object), all of them in its one world; ``ground`` m, None for no gravity."""
    camera = {"width": 640, "height": 480, "K": [[700, 0, 320], [0, 700, 240], [0, 0, 1]], "dist": []}
    gravity = {} if ground is None else {"gravity": {"unknown_support": 0.1, "ground": ground}}
    return {
        "format": "interpretation/1",
        "reading": "score",
        "reconsider": "to_B",
        "smoothing": 0.0,
        "camera": {**camera, "T_world_camera": inverse(CAMERA_FROM_WORLD).tolist()},
        "appearances": [],
        "hypotheses": [hypothesis(*box) for box in boxes],
        "worlds": [{"probability": 0.9, "present": [name for name, *_ in boxes]}],
        "facts": [],
        **gravity,
        "measures": {"dv": {}, "rank": {}},
        "priors": dict.fromkeys(SIZES, 0.5),
        "rules": "",
        "assets": {"meshes": {kind: mesh(size) for kind, size in SIZES.items()}},
    }
