"""Pictures of a type standing on each of its faces, from the simulated camera, on a plain ground."""

import base64
from collections.abc import Iterator, Sequence
from contextlib import suppress
from typing import Any

import cv2
import numpy as np

from geometry.bodies.columns import level_axes
from geometry.camera import Camera
from geometry.frames import inverse, look_at
from kb.clouds.cloud import ObjectType
from kb.shown.show import stand_rows
from plogic.facts.carried_rows import TextureRow
from sensing.errors import SensingError
from sensing.simulated.body import GREY, Body, TexturedMesh, read_mesh
from sensing.simulated.camera import extent
from sensing.simulated.stage import stage
from sensing.simulated.surroundings import Light

MOST = 6
"""Ways to stand of which there is a picture: the likeliest."""
WIDTH, HEIGHT, FINER = 240, 200, 2
"""Of a picture, pixels, and how much larger it is drawn at first."""
APART, AWAY = 20.0, 2.0
"""Diameters between bodies, and from a body to its camera, which looks from above, in front and a little from the
right."""
FROM = np.array([0.45, -1.0, 0.75]) / np.linalg.norm([0.45, -1.0, 0.75])
GROUND, QUALITY = 236, 82


def standing_document(kind: ObjectType) -> dict[str, Any]:
    """``{"said": "On 5 faces, ...", "faces": [{"said": "0.5: 0, 0, -1 below", "picture": ...}]}``, likeliest first."""
    rows, mesh = stand_rows(kind), _mesh(kind)
    pictures: list[TextureRow] = []
    if mesh is not None and rows:
        size = extent(mesh.vertices)[1]
        bodies = [_standing(mesh, row, i * APART * size) for i, row in enumerate(rows[:MOST])]
        with suppress(SensingError):  # a mesh that is too large is not drawn
            pictures = list(_pictures(bodies, size))
    faces = [{"said": _below(row), "picture": picture} for row, picture in zip(rows, pictures, strict=False)]
    return {"said": _said(kind, rows, len(pictures)), "faces": faces}


def _below(row: dict[str, Any]) -> str:
    return f"{row['weight']:.3g}: {', '.join(f'{x + 0.0:.2g}' for x in np.round(row['down'], 2))} below"


def _said(kind: ObjectType, rows: Sequence[dict[str, Any]], shown: int) -> str:
    if not rows:
        return "Its file says that it never stands." if kind.stands == () else "It has no mesh with a face to stand on."
    how = "as its mesh can, each different way as often" if kind.stands is None else "as its file says"
    told = f"On {len(rows)} face{'s' * (len(rows) > 1)}, {how}. The number is how often, and what is below is in its own frame."
    rest = rows[shown:]
    return told + (f" Not drawn: {len(rest)}, {sum(row['weight'] for row in rest):.3g} in all." if rest else "")


def _mesh(kind: ObjectType) -> TexturedMesh | None:
    """The mesh as it is painted; the plain surface where that cannot be read, None of a type without one."""
    if kind.surface is None:
        return None
    if kind.mesh_file is not None:
        with suppress(SensingError):
            return read_mesh(kind.mesh_file, kind.mesh_scale)
    return TexturedMesh(kind.surface.vertices, kind.surface.triangles, colour=GREY)


def _standing(mesh: TexturedMesh, row: dict[str, Any], x: float) -> Body:
    """The mesh at ``x`` m along the floor, z = 0, with the face of ``row`` down."""
    pose = np.eye(4)
    pose[:3, :3], pose[:3, 3] = level_axes(-np.array(row["down"])), (x, 0.0, row["reach"])
    return Body(None, mesh, pose)


def _pictures(bodies: Sequence[Body], size: float) -> Iterator[TextureRow]:
    """JPEG of each, ``size`` m across."""
    K = np.array([[1.7 * HEIGHT, 0, (WIDTH - 1) / 2], [0, 1.7 * HEIGHT, (HEIGHT - 1) / 2], [0, 0, 1]])
    with stage(bodies, Light()) as drawn:
        for body in bodies:
            middle = extent(body.vertices_world)[0]
            camera_from_world = look_at(middle + AWAY * size * FROM, middle)
            camera = Camera(WIDTH, HEIGHT, K, world_from_camera=inverse(camera_from_world))
            colour, segmentation, _ = drawn.shoot(camera, FINER)
            image = np.where((segmentation >= 0)[:, :, None], colour, np.uint8(GROUND))
            small = cv2.resize(image, (WIDTH, HEIGHT), interpolation=cv2.INTER_AREA)
            data = cv2.imencode(".jpg", small, [cv2.IMWRITE_JPEG_QUALITY, QUALITY])[1]
            yield {"media_type": "image/jpeg", "base64": base64.b64encode(data.tobytes()).decode()}
