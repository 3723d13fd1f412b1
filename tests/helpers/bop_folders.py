"""Small BOP datasets on disk, written by hand: not with the project's own writer."""

from __future__ import annotations

import json

import cv2
import numpy as np

K = [500.0, 0, 320, 0, 500.0, 240, 0, 0, 1]
EYE = [1.0, 0, 0, 0, 1.0, 0, 0, 0, 1]
CUBE = np.array([[x, y, z] for x in (-50, 50) for y in (-50, 50) for z in (-50, 50)], dtype=float)
"""Vertices (8, 3), mm."""
CUBE_MM = 100 * np.sqrt(3)
FACES = "3 0 1 2\n3 1 3 2\n3 4 6 5\n3 5 6 7\n3 0 4 1\n3 1 4 5\n3 2 3 6\n3 3 7 6\n3 0 2 4\n3 2 6 4\n3 1 5 3\n3 3 5 7\n"


def put(path, content):
    """Write text, or a document as JSON."""
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(content if isinstance(content, str) else json.dumps(content))


def picture(path, width=640, height=480):
    """A grey picture."""
    path.parent.mkdir(parents=True, exist_ok=True)
    cv2.imwrite(str(path), np.full((height, width, 3), 90, np.uint8))


def truth(obj_id=1, t_mm=(0, 0, 1000), R=EYE):
    """One entry of scene_gt.json."""
    return {"obj_id": obj_id, "cam_R_m2c": list(R), "cam_t_m2c": list(t_mm)}


def models(folder, ids=(1,), **extra):
    """Cubes of 100 mm, ascii PLY."""
    lines = "".join(f"{x} {y} {z}\n" for x, y, z in CUBE)
    head = "ply\nformat ascii 1.0\nelement vertex 8\nproperty float x\nproperty float y\nproperty float z\n"
    for obj_id in ids:
        put(
            folder / f"obj_{obj_id:06d}.ply",
            head + "element face 12\nproperty list uchar int vertex_indices\nend_header\n" + lines + FACES,
        )
    put(folder / "models_info.json", {str(i): {"diameter": CUBE_MM, **extra} for i in ids})


def scene(folder, truths, visible=None, *, pictures=True):
    """A scene's folder: ``truths`` by image, ``visible`` fractions of the same shape."""
    put(folder / "scene_camera.json", {str(i): {"cam_K": K, "depth_scale": 1.0} for i in truths})
    put(folder / "scene_gt.json", {str(i): rows for i, rows in truths.items()})
    if visible is not None:
        put(folder / "scene_gt_info.json", {str(i): [{"visib_fract": v} for v in row] for i, row in visible.items()})
    for i in truths if pictures else ():
        picture(folder / f"rgb/{i:06d}.png")
    return folder


def dataset(folder, truths, visible=None):
    """A dataset of one scene with cubes 1 and 2."""
    scene(folder / "test/000001", truths, visible)
    models(folder / "models", (1, 2))
    return folder
