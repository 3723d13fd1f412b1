"""The shipped box, its files for a test to spoil, and what a camera sees of it where nothing is spoiled."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING

import numpy as np

from geometry.camera import Camera, camera_to_dict
from geometry.frames import from_rotation_translation
from kb.files.folder import shipped
from kb.files.read import read_kb
from plogic.match.gamma.data import data_of
from plogic.match.judged.expectation import pose_of

if TYPE_CHECKING:
    from pathlib import Path

HOME = shipped("first")
TYPE = "objects/box/object.yaml"
MESH = "objects/box/mesh.obj"
CAMERA = Camera(640, 480, np.array([[600.0, 0, 320.0], [0, 600.0, 240.0], [0, 0, 1]]))


def texts() -> dict[str, str]:
    """The three files of the knowledge base."""
    return {name: (HOME / name).read_text() for name in ("kb.yaml", TYPE, MESH)}


def written(folder: Path, files: dict[str, str | None]) -> Path:
    """The folder with these files; None leaves one out."""
    for name, text in files.items():
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        if text is not None:
            path.write_text(text)
    return folder


def pose(distance: float) -> np.ndarray:
    """Camera from box, seen obliquely from above, its middle at this distance, m."""
    turn, tilt = np.radians(35.0), np.radians(-25.0)
    about_z = np.array([[np.cos(turn), -np.sin(turn), 0], [np.sin(turn), np.cos(turn), 0], [0, 0, 1]])
    upright = np.array([[1.0, 0, 0], [0, 0, -1], [0, 1, 0]])
    nod = np.array([[1, 0, 0], [0, np.cos(tilt), np.sin(tilt)], [0, -np.sin(tilt), np.cos(tilt)]])
    rotation = nod @ upright @ about_z
    return from_rotation_translation(rotation, np.array([0.01, 0.02, distance]) - rotation @ np.array([0, 0, 0.08]))


def sight(distance: float = 1.5, camera: Camera = CAMERA, noise: int = 3, home: Path = HOME) -> dict:
    """Γ as a document: each expected feature of the box half a pixel off, and some noise."""
    kb = read_kb(home)
    (box,) = kb.types
    seen = pose_of(box, pose(distance), data_of((), camera, 128), kb)
    shown = np.flatnonzero(seen.in_image & seen.in_lobe & ~seen.self_hidden)
    rng = np.random.default_rng(0)
    rows = [(box.seen_features[f].type, seen.uv[f] + rng.normal(0.0, 0.5, 2)) for f in shown]
    rows += [("corner", rng.uniform(20, [camera.width - 20, camera.height - 20])) for _ in range(noise)]
    data = [
        {"id": f"a{i}", "type": kind, "uv": [round(float(x), 2) for x in uv], "detector": "mine"}
        for i, (kind, uv) in enumerate(rows, 1)
    ]
    return {"format": "gamma/1", "camera": camera_to_dict(camera), "appearances": data}


def gamma_file(folder: Path, document: dict) -> Path:
    """The document as a file."""
    path = folder / "gamma.json"
    path.write_text(json.dumps(document))
    return path
