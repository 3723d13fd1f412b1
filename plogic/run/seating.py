"""Objects that a world says stand, put flush on what they stand on, as far as estimated poses may be off.

A pose that is a degree or two tilted, or a few millimetres above what its object stands on, is one of many that fit the
picture, and the world says which of these it means: the one that stands. What stands is turned about its middle of mass
so that its nearest stable face is level, and moved to touch what it stands on, along the line of sight mostly, for so
poses are off (``plogic.cycle.planes``). Nothing is turned or moved by more than it may: what is farther off stays as it
is, for physics to say.
"""

from collections.abc import Mapping
from typing import Protocol

import numpy as np

from geometry.arrays import Floats
from geometry.bodies.resting import RestingFaces
from geometry.frames import transform_points
from plogic.cycle.planes import ASIDE, DEPTH


class Body(Protocol):
    """What is put somewhere: its corners (V, 3) m and its ``middle`` (3,) of mass, object frame, and its faces."""

    @property
    def corners(self) -> Floats:
        """(V, 3) m, object frame."""
        ...

    @property
    def middle(self) -> Floats:
        """(3,) m, of mass, object frame."""
        ...

    @property
    def resting(self) -> RestingFaces:
        """The faces that it can stand on."""
        ...


def seated(
    bodies: Mapping[str, Body],
    poses: Mapping[str, Floats],
    on: Mapping[str, str],
    eye: Floats,
    *,
    tilt: float,
    far: Mapping[str, float],
) -> dict[str, Floats]:
    """The poses (4, 4) of bodies, in a frame in which z is up and the floor is at 0, those that stand seated.

    ``on``: of each that stands what it stands on, another body or a plane, which is the floor. ``eye`` (3,): the
    camera's place. Nothing is turned by more than ``tilt`` rad, or moved up or down by more than ``far`` m of it.
    """
    found = dict(poses)
    heights = {name: float(transform_points(poses[name], body.middle[None])[0, 2]) for name, body in bodies.items()}
    for name in sorted(on, key=lambda name: (heights[name], name)):
        body, lower = bodies[name], bodies.get(on[name])
        top = 0.0 if lower is None else float(transform_points(found[on[name]], lower.corners)[:, 2].max())
        level = _level(body, poses[name], tilt)
        if level is not None:
            gap = float(transform_points(level, body.corners)[:, 2].min()) - top
            if abs(gap) <= far[name]:
                level[:3, 3] -= gap * _way(level[:3, :3] @ body.middle + level[:3, 3] - eye)
                found[name] = level
    return found


def _level(body: Body, pose: Floats, tilt: float) -> Floats | None:
    """The pose turned about the body's middle so that its nearest face is level; None where that is too far."""
    from scipy.spatial.transform import Rotation

    down = body.resting.down @ pose[:3, :3].T
    if not len(down):
        return None
    nearest = down[int(np.argmin(down[:, 2]))]
    angle = float(np.arccos(np.clip(-nearest[2], -1.0, 1.0)))
    if angle > tilt:
        return None
    axis = np.array([-nearest[1], nearest[0], 0.0])
    length = float(np.linalg.norm(axis))
    turned = pose.copy()
    if length > 0.0:
        turned[:3, :3] = Rotation.from_rotvec(angle * axis / length).as_matrix() @ pose[:3, :3]
    turned[:3, 3] = transform_points(pose, body.middle[None])[0] - turned[:3, :3] @ body.middle
    return turned


def _way(sight: Floats) -> Floats:
    """(3,) of height 1: the likeliest way in which a body is off that is 1 too high; ``sight`` (3,): to it."""
    along = sight / np.linalg.norm(sight)
    spread = ASIDE**2 * np.eye(3) + (DEPTH**2 - ASIDE**2) * np.outer(along, along)
    return np.asarray(spread[2] / spread[2, 2])
