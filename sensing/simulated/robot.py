"""A camera that moves in the simulated world: it looks, goes elsewhere where it can be, and looks again.

* ``Robot``: ``robot = Robot(scene); robot.look(); robot.move_to(world_from_camera); robot.look()``

The bodies stay where they settled. Each look has noise of its own; the same looks at the same places give the same
bytes.

What a robot saw on its way, as a folder: ``frame-000/`` with image.png, camera.json and truth.json, and so on, and
``poses.json``.

``poses.json`` is ``poses/1``, as ``plogic perceive FRAME... --poses FILE`` reads it.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from geometry.camera import camera_to_dict
from geometry.frames import inverse, is_rigid, look_at
from sensing.errors import SceneError
from sensing.files.whole_files import new_folder
from sensing.simulated.body import Body
from sensing.simulated.camera import Rendering
from sensing.simulated.scene import Scene, json_bytes, png, truth_to_dict
from sensing.simulated.surroundings import placed_at

LOW = 0.1
"""Units of the scene above the floor that a camera stays."""
CLEARANCE = 0.1
"""Units that a camera stays from the convex hull of a body."""
ROOM = 20.0
"""Units from the middle of the bodies, on the level, that the walls are; as high is the ceiling."""


class Robot:
    """A settled scene, and where its camera is now. ``looks``: how often it looked."""

    def __init__(self, scene: Scene) -> None:
        """Begin where the scene's own camera is. Raises SceneError where that is nowhere."""
        placed_at(scene.camera)
        self._scene, self.looks = scene, 0

    @property
    def world_from_camera(self) -> NDArray[np.float64]:
        """(4, 4) m."""
        return placed_at(self._scene.camera)

    @property
    def middle(self) -> NDArray[np.float64]:
        """(3,) m: the middle of the box around all bodies; the origin where there is none."""
        if not self._scene.bodies:
            return np.zeros(3)
        points = np.concatenate([body.vertices_world for body in self._scene.bodies])
        return np.asarray((points.min(axis=0) + points.max(axis=0)) / 2.0)

    def why_not(self, world_from_camera: NDArray[np.float64]) -> str | None:
        """Why the camera cannot be there; None where it can. Only the place is looked at, not the way to it."""
        if np.shape(world_from_camera) != (4, 4) or not is_rigid(world_from_camera):
            return "is no rigid 4x4 matrix"
        eye = np.asarray(world_from_camera)[:3, 3]
        low, clearance, room = (self._scene.unit * length for length in (LOW, CLEARANCE, ROOM))
        if eye[2] < low:
            return f"is {eye[2]:.2f} m above the floor; {low:g} m are the least"
        if np.linalg.norm(eye[:2] - self.middle[:2]) > room or eye[2] > room:
            return f"is outside the room, which reaches {room:g} m from the middle of the scene"
        near = next((body for body in self._scene.bodies if _outside(body, eye) < clearance), None)
        return (
            None
            if near is None
            else f"is inside or nearer than {clearance:g} m to {'a decoy' if near.label is None else repr(near.label)}"
        )

    def move_to(self, world_from_camera: NDArray[np.float64]) -> None:
        """Go there. Raises SceneError that says why it cannot, and stays where it is."""
        reason = self.why_not(world_from_camera)
        if reason is not None:
            raise SceneError(f"camera: cannot go there: it {reason}")
        self._scene = replace(
            self._scene, camera=replace(self._scene.camera, world_from_camera=np.asarray(world_from_camera))
        )

    def look(self, supersample: int = 3) -> Rendering:
        """What is seen from here, with noise that no other look has."""
        self.looks += 1
        sensor = self._scene.sensor
        return replace(self._scene, sensor=replace(sensor, seed=sensor.seed + self.looks - 1)).photograph(supersample)

    def scene(self) -> Scene:
        """The scene from here, with the visible shares of the bodies: ground truth."""
        return replace(self._scene, fractions=self._scene.visible_shares())

    def ring(self, views: int) -> list[NDArray[np.float64]]:
        """So many places (4, 4) evenly around the middle, at the present height and distance, turned to the middle.

        The first is on this side.
        """
        eye = self.world_from_camera[:3, 3]
        out = eye - self.middle
        height, level = out[2], np.array([out[0], out[1], 0.0])
        places = []
        for angle in 2.0 * np.pi * np.arange(views) / views:
            c, s = np.cos(angle), np.sin(angle)
            side = np.array([c * level[0] - s * level[1], s * level[0] + c * level[1], height])
            places.append(inverse(look_at(self.middle + side, self.middle)))
        return places


def _outside(body: Body, eye: NDArray[np.float64]) -> float:
    """M from a body's convex hull to a place outside of it, or less; negative inside."""
    from scipy.spatial import ConvexHull, QhullError

    try:
        hull = ConvexHull(body.vertices_world)
    except QhullError:  # flat: nothing is inside
        return float(np.linalg.norm(body.vertices_world - eye, axis=1).min())
    return float((hull.equations[:, :3] @ eye + hull.equations[:, 3]).max())


def write_tour(
    robot: Robot,
    places: Sequence[NDArray[np.float64]],
    folder: Path,
    supersample: int = 3,
    files: Callable[[Scene], Mapping[str, bytes]] | None = None,
) -> None:
    """Go to each of the places (4, 4) in the world in turn, look, and write the folder, whole or not at all.

    ``files``: what is written of the scene from each place, the frame's own file first, instead of a picture with
    camera and truth.

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
            written = _frame(robot, supersample) if files is None else files(robot.scene())
            for file, data in written.items():
                (made / name / file).write_bytes(data)
            frames.append(
                {"frame": f"{name}/{next(iter(written))}", "T_world_camera": robot.world_from_camera.tolist()}
            )
        (made / "poses.json").write_bytes(json_bytes({"format": "poses/1", "frames": frames}))


def _frame(robot: Robot, supersample: int) -> dict[str, bytes]:
    """One look as files."""
    image, scene = robot.look(supersample).image, robot.scene()
    return {
        "image.png": png(image),
        "camera.json": json_bytes(camera_to_dict(scene.camera)),
        "truth.json": json_bytes(truth_to_dict(scene)),
    }
