"""The likeliest plane that things stand on, in the picture: a faint grid, and the foot of what stands there.

* ``Ground``: its grid lines and feet, metres, camera frame; ``ground_of(document)``, None where none is likely
* ``lines_in_picture(ground, camera)``: the lines as a lens bends them, pixels
"""

from typing import NamedTuple

import numpy as np
import shapely
from numpy.typing import NDArray

from geometry.arrays import Floats
from geometry.bodies.resting import Plane
from geometry.camera import Camera, camera_from_dict
from plogic.face.shown.against import silhouette
from plogic.face.shown.pencil import Colour, Pencil
from plogic.facts.document import Interpretation

LIKELY, STANDS = 0.5, 0.5
"""Probabilities from which a plane is drawn, and from which an object's foot is."""
STEPS = 0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1.0, 2.0
"""Metres between lines, the least with no more than ``MOST`` lines either way."""
MOST = 14
AROUND = 0.5
"""Share of the feet's extent, and metres at the least a tenth of the distance, that the grid goes beyond them."""
FAINT = 0.35
"""Opacity."""
POINTS = 24
"""Places of a line, which a lens bends."""
EXACT = 0.1
"""Pixels by which a line may leave out places on its way."""


class Ground(NamedTuple):
    """``name`` of the plane; ``lines`` (L, ``POINTS``, 3) and ``feet`` by hypothesis (3,), metres, camera frame.

    ``step``: metres between lines.
    """

    name: str
    lines: Floats
    feet: dict[str, Floats]
    step: float


def ground_of(document: Interpretation) -> Ground | None:
    """The ground under what is accepted; None where no plane is likely, or nothing stands on it."""
    rows = [row for row in document.get("support_planes", ()) if row.get("probability", 0.0) >= LIKELY]
    space = document.get("space")
    if not rows or space is None:
        return None
    bodies = {body["id"]: body["middle"] for body in space["bodies"]}
    row = max(rows, key=lambda row: row["probability"])
    plane = Plane(np.array(row["plane"]["normal"], float), -float(row["plane"]["offset"]))
    accepted = {h["id"] for h in document.get("hypotheses", ()) if h["status"] == "accepted"}
    standing = [name for name, p in row.get("standing", {}).items() if p >= STANDS and name in accepted & bodies.keys()]
    if not standing:
        return None
    feet = {}
    for name in standing:
        middle = np.array(bodies[name], float)
        feet[name] = middle - plane.height(middle) * plane.up
    lines, step = _grid(plane, np.array(list(feet.values())))
    return Ground(row["name"], lines, feet, step)


def _grid(plane: Plane, feet: Floats) -> tuple[Floats, float]:
    """(L, ``POINTS``, 3) lines at even steps around feet (N, 3), and the step."""
    axes = plane.along
    at = feet @ axes
    beyond = max(AROUND * float(np.ptp(at, axis=0).max()), 0.1 * float(np.linalg.norm(feet, axis=1).mean()))
    low, high = at.min(axis=0) - beyond, at.max(axis=0) + beyond
    step = next((s for s in STEPS if (high - low).max() / s <= MOST), STEPS[-1])
    low, high = np.floor(low / step) * step, np.ceil(high / step) * step
    origin, lines = -plane.offset * plane.up, []
    for k in range(2):
        for value in np.arange(low[k], high[k] + step / 2, step):
            along = np.linspace(low[1 - k], high[1 - k], POINTS)
            lines.append(origin + value * axes[:, k] + along[:, None] * axes[:, 1 - k])
    return np.array(lines), step


def lines_in_picture(ground: Ground, camera: Camera) -> list[Floats]:
    """Lines (N, 2) of the grid, pixels: those that are before the camera whole, with the places where they bend."""
    drawn = [at for at in camera.project(ground.lines) if np.isfinite(at).all()]
    return [shapely.get_coordinates(shapely.simplify(shapely.linestrings(at), EXACT)) for at in drawn]


def draw_ground(pencil: Pencil, document: Interpretation, colours: dict[str, Colour]) -> Ground | None:
    """Draw the grid where no accepted object is before it, and a cross of its colour at each foot."""
    ground, camera = ground_of(document), camera_from_dict(document["camera"])
    if ground is None:
        return None
    bare = pencil.picture.copy()
    for line in lines_in_picture(ground, camera):
        pencil.stroke(line.tolist(), GRID, 1, dashed=False)
    shown = (FAINT * pencil.picture + (1.0 - FAINT) * bare).astype(np.uint8)
    hidden = _before(document, pencil.picture.shape[:2])
    pencil.picture[:] = np.where(hidden[..., None], bare, shown)
    for name, foot in ground.feet.items():
        at = camera.project(foot)
        if np.isfinite(at).all():
            pencil.foot(at.tolist(), colours[name])
    return ground


GRID: Colour = (235, 235, 235)


def _before(document: Interpretation, shape: tuple[int, ...]) -> NDArray[np.bool_]:
    """(H, W) of the picture: where an accepted object is."""
    import cv2

    size = int(document["camera"]["width"]), int(document["camera"]["height"])
    accepted = [h for h in document.get("hypotheses", ()) if h["status"] == "accepted"]
    there = np.any([np.zeros(size[::-1], bool), *(silhouette(h, size) for h in accepted)], axis=0)
    return cv2.resize(there.astype(np.uint8), (shape[1], shape[0]), interpolation=cv2.INTER_NEAREST) > 0
