"""The picture of a world that was let go: outlines before, dashed, and after, with what became of each object."""

from functools import partial

import numpy as np
from numpy.typing import NDArray

from geometry.camera import Camera, camera_from_dict
from geometry.visibility.outline import outline
from plogic.base.errors import InputError
from plogic.face.shown.overlay import Entry, colour_of, legend, pencil_on, sample, swatch
from plogic.face.shown.pencil import Pencil
from plogic.facts.document import Interpretation
from plogic.run.settling import ObjectRow, SettledWorld


def settled_picture(
    document: Interpretation, world: SettledWorld, image: NDArray[np.uint8] | None
) -> NDArray[np.uint8]:
    """The world's outlines over the image (H, W, 3), blue first, or on a plain ground; (s H + legend, s W, 3).

    Raises InputError where the interpretation has no camera.
    """
    if "camera" not in document:
        raise InputError("the interpretation has no camera: there is nothing to draw in")
    camera, pencil = camera_from_dict(document["camera"]), pencil_on(document["camera"], image)
    before = {row["id"]: row["T_camera_object"] for row in document["hypotheses"]}
    for i, row in enumerate(world["objects"]):
        mesh = document["assets"]["meshes"][row["type"]]
        for pose, dashed in ((before[row["id"]], True), (row["T_camera_object"], False)):
            shape = outline(np.array(mesh["vertices"], float), mesh["triangles"], np.array(pose, float), camera)
            _draw(pencil, shape, i, camera, dashed=dashed)
    told = [(_told(row), swatch(colour_of(i))) for i, row in enumerate(world["objects"])]
    lines: list[Entry] = [("before", partial(sample, dashed=True)), ("after", partial(sample, dashed=False))]
    return np.concatenate([pencil.picture, legend(pencil.picture.shape[1], [*told, *lines])])


def _draw(pencil: Pencil, shape: object, i: int, camera: Camera, *, dashed: bool) -> None:
    reach = 10.0 * max(camera.width, camera.height)
    for part in getattr(shape, "geoms", [shape]):
        if not part.is_empty:
            ring = np.clip(np.array(part.exterior.coords), -reach, reach)
            pencil.stroke(ring.tolist(), colour_of(i), 1 if dashed else 2, dashed=dashed)


def _told(row: ObjectRow) -> str:
    return f"{row['type']} {row['id']} {row['verdict']}"
