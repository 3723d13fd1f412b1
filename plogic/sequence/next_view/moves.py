"""Candidate camera moves: a ring around the scene's middle within a distance, or a list of one's own.

A list is read by ``geometry.files.pose_files``.

* ``Candidate``: a camera's pose by name, ``Candidate("ring 90°", reference_from_camera)``
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal, NotRequired, TypedDict

import numpy as np
from numpy.typing import NDArray

from geometry.arrays import Floats
from geometry.frames import inverse, look_at, transform_points
from plogic.sequence.next_view.expected import Prospect

RING = 12
"""Places of a ring, the present one among them."""
STEPS = 3
"""Grid steps from the present place to the farthest that is within the distance."""
CLEAR = 1.5
"""Radii of the scene that a camera keeps from its middle, at least."""
STEEP = 0.999
"""Cosine to the vertical from which a camera has no upward direction."""


class MovesRow(TypedDict):
    """How the candidates were made, m; ``left_out``: those that are too near or too low."""

    moves: Literal["ring", "within", "list"]
    places: NotRequired[int]
    radius: NotRequired[float]
    height_over_middle: NotRequired[float]
    distance: NotRequired[float]
    step: NotRequired[float]
    left_out: NotRequired[int]
    middle: NotRequired[list[float]]


@dataclass(frozen=True, eq=False)
class Candidate:
    """One place for the camera, ``reference_from_camera`` (4, 4), m."""

    name: str
    reference_from_camera: Floats


@dataclass(frozen=True, eq=False)
class Stand:
    """Where the camera is and which way is up: ``reference_from_camera`` (4, 4), m.

    ``up`` (3,) unit, reference frame; ``upright``: up is known.
    """

    reference_from_camera: Floats
    up: Floats
    upright: bool


def standing(world_from_camera: Floats | None) -> Stand:
    """The present camera in its own frame. Up is the world's z where its pose is known, else the image's."""
    up = np.array([0.0, -1.0, 0.0]) if world_from_camera is None else world_from_camera[2, :3]
    return Stand(np.eye(4), np.asarray(up), world_from_camera is not None)


def turned_to(eye: Floats, middle: Floats, up: Floats) -> Floats:
    """reference_from_camera (4, 4) of a camera at ``eye`` that looks at ``middle``.

    Straight up or down, the image's top is any direction.
    """
    line = (middle - eye) / np.linalg.norm(middle - eye)
    if abs(float(line @ up)) > STEEP:
        up = np.eye(3)[int(np.argmin(np.abs(line)))]
    return inverse(look_at(eye, middle, up))


def ring(
    prospect: Prospect, stand: Stand, radius: float | None = None, places: int = RING
) -> tuple[list[Candidate], MovesRow]:
    """Places around the scene's middle at the present height, the present one aside, evenly apart, turned inward.

    ``radius``: m from the axis through the middle, by default the present one. None where nothing may be there, or the
    camera is on the axis.
    """
    middle = prospect.middle
    if middle is None:
        return [], {"moves": "ring", "places": places}
    eye = stand.reference_from_camera[:3, 3]
    height = float((eye - middle) @ stand.up)
    level = eye - middle - height * stand.up
    present = float(np.linalg.norm(level))
    if present < 1e-9:
        level, present = np.cross(stand.up, np.eye(3)[int(np.argmin(np.abs(stand.up)))]), 1.0
    out = level / np.linalg.norm(level)
    across = np.cross(stand.up, out)
    size = present if radius is None else radius
    angles = [2.0 * np.pi * k / places for k in range(1, places)]
    eyes = [middle + height * stand.up + size * (np.cos(a) * out + np.sin(a) * across) for a in angles]
    made = [
        Candidate(f"ring {np.degrees(a):.0f}°", turned_to(e, middle, stand.up))
        for a, e in zip(angles, eyes, strict=True)
    ]
    return made, {
        "moves": "ring",
        "places": places,
        "radius": size,
        "height_over_middle": height,
        "middle": middle.tolist(),
    }


def within(prospect: Prospect, stand: Stand, distance: float) -> tuple[list[Candidate], MovesRow]:
    """Every place of a grid within ``distance`` m of the camera, turned to the scene's middle, the nearest first.

    ``STEPS`` steps to the farthest.

    Left out are the present place, what is nearer the middle than ``CLEAR`` radii of the scene (and the camera is not),
    and, where up is known, what is lower than all that may be there.
    """
    middle, step = prospect.middle, distance / STEPS
    stated: MovesRow = {"moves": "within", "distance": distance, "step": step}
    if middle is None:
        return [], stated
    eye = stand.reference_from_camera[:3, 3]
    axes = stand.reference_from_camera[:3, :3].T
    grid = np.stack(np.meshgrid(*[np.arange(-STEPS, STEPS + 1)] * 3, indexing="ij"), axis=-1).reshape(-1, 3)
    grid = grid[(np.linalg.norm(grid, axis=1) <= STEPS + 1e-9) & (grid != 0).any(axis=1)]
    grid = grid[np.argsort((grid**2).sum(axis=1), kind="stable")]
    eyes = eye + step * grid @ axes
    near = min(CLEAR * prospect.radius, float(np.linalg.norm(eye - middle)))
    kept = np.linalg.norm(eyes - middle, axis=1) >= near - 1e-9
    if stand.upright:
        kept &= (eyes - middle) @ stand.up >= lowest(prospect, stand.up) - float(middle @ stand.up)
    made = [
        Candidate(_named(g, step), turned_to(e, middle, stand.up)) for g, e in zip(grid[kept], eyes[kept], strict=True)
    ]
    return made, {**stated, "places": len(made), "left_out": int((~kept).sum()), "middle": middle.tolist()}


def _named(grid: NDArray[np.int64], step: float) -> str:
    """Right, up and ahead of the present camera, in metres: its frame's x, −y and z."""
    words = zip(grid.tolist(), (("right", "left"), ("down", "up"), ("ahead", "back")), strict=True)
    return ", ".join(f"{abs(k) * step:.2f} {plus if k > 0 else minus}" for k, (plus, minus) in words if k)


def lowest(prospect: Prospect, up: Floats) -> float:
    """How far along ``up`` the lowest point of all that may be there lies, m."""
    some = [body for body, p in zip(prospect.bodies, prospect.marginals, strict=True) if p > 0.0]
    points = [body.cloud.lobes.at if body.cloud.rays is None else body.cloud.rays.vertices for body in some]
    return min(
        float((transform_points(body.reference_from_object, its) @ up).min())
        for body, its in zip(some, points, strict=True)
    )


def checked(candidates: Sequence[Candidate]) -> list[Candidate]:
    """Candidates of different names: of equal ones all but the first are numbered."""
    seen: dict[str, int] = {}
    named = []
    for one in candidates:
        seen[one.name] = seen.get(one.name, 0) + 1
        named.append(
            one if seen[one.name] == 1 else Candidate(f"{one.name} ({seen[one.name]})", one.reference_from_camera)
        )
    return named
