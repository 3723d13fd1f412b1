"""A simulated scene as a folder: ``image.png``, ``camera.json`` (the contract's camera), ``truth.json``; whole or not at all."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Any

from geometry.camera import camera_to_dict
from sensing.errors import SceneError
from sensing.files.whole_files import write_folder

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from sensing.simulated.scene import Scene


def truth_to_dict(scene: Scene) -> dict[str, Any]:
    """Ground truth: per body its label (null for an untyped decoy), ``T_camera_object`` and the visible fraction of its picture."""
    rows = zip(scene.bodies, scene.camera_from_bodies, scene.fractions, strict=True)
    objects = [{"label": b.label, "T_camera_object": T.tolist(), "visible_fraction": f} for b, T, f in rows]
    return {"format": "truth/1", "objects": objects}


def write_scene(scene: Scene, folder: str | Path, supersample: int = 3) -> None:
    """Photograph the scene and write its folder; the same scene gives the same bytes.

    Raises:
        SceneError: The picture cannot be made.
        SensingError: The folder holds something already, or cannot be written.
    """
    image = scene.photograph(supersample).image
    documents = {"camera.json": camera_to_dict(scene.camera), "truth.json": truth_to_dict(scene)}
    write_folder(
        Path(folder), {"image.png": png(image), **{name: json_bytes(document) for name, document in documents.items()}}
    )


def json_bytes(document: object) -> bytes:
    """The document as the bytes of a JSON file."""
    return (json.dumps(document, indent=1) + "\n").encode()


def png(image: NDArray[np.uint8]) -> bytes:
    """The (H, W, 3) uint8 picture, blue first, as the bytes of a PNG file."""
    import cv2

    done, data = cv2.imencode(".png", image)
    if not done:
        raise SceneError(f"image: shape {image.shape} cannot be written as PNG")
    return bytes(data.tobytes())
