"""What a robot saw on its way, as a folder: ``frame-000/`` with image.png, camera.json and truth.json, and so on, and ``poses.json``.

``poses.json`` is ``poses/1``, as ``plogic perceive FRAME... --poses FILE`` reads it.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from geometry.camera import camera_to_dict
from sensing.errors import SceneError
from sensing.files.whole_files import new_folder
from sensing.simulated.scene_files import json_bytes, png, truth_to_dict

if TYPE_CHECKING:
    from collections.abc import Sequence
    from pathlib import Path

    import numpy as np
    from numpy.typing import NDArray

    from sensing.simulated.robot import Robot


def write_tour(robot: Robot, places: Sequence[NDArray[np.float64]], folder: Path, supersample: int = 3) -> None:
    """Go to each of the places (4, 4) in the world in turn, look, and write the folder, whole or not at all.

    Raises:
        SceneError: The robot cannot be at a place; nothing is written.
        SensingError: The folder holds something already, or cannot be written.
    """
    for i, place in enumerate(places):
        reason = robot.why_not(place)
        if reason is not None:
            raise SceneError(f"move {i + 1}: the camera cannot go there: it {reason}")
    frames: list[dict[str, Any]] = []
    with new_folder(folder) as made:
        for i, place in enumerate(places):
            robot.move_to(place)
            name = f"frame-{i:03d}"
            (made / name).mkdir()
            for file, data in _frame(robot, supersample).items():
                (made / name / file).write_bytes(data)
            frames.append({"frame": f"{name}/image.png", "T_world_camera": robot.world_from_camera.tolist()})
        (made / "poses.json").write_bytes(json_bytes({"format": "poses/1", "frames": frames}))


def _frame(robot: Robot, supersample: int) -> dict[str, bytes]:
    """One look as files."""
    image, scene = robot.look(supersample).image, robot.scene()
    return {
        "image.png": png(image),
        "camera.json": json_bytes(camera_to_dict(scene.camera)),
        "truth.json": json_bytes(truth_to_dict(scene)),
    }
