"""Prints examples/first_gamma.json.

What two imagined detectors report of the painted box of the KB ``first``, from 1.2 m away.

It stands in for detectors of your own. It knows the box's pose; the Γ that it prints does not: it holds only types and
places, some noise, three appearances that are clutter, and one visible corner that was missed. Run it as ``python
examples/first_gamma.py > examples/first_gamma.json``.
"""
# ruff: noqa: INP001 - a script, no package

from __future__ import annotations

import json
import sys

import numpy as np

from geometry.camera import Camera, camera_to_dict
from geometry.frames import look_at, transform_points
from geometry.visibility.rays import behind
from kb.clouds.lobes import feature_in_lobe
from kb.files.folder import shipped
from kb.files.read import read_kb

VIEWPOINT, TARGET = (0.62, -0.87, 0.62), (0.0, 0.0, 0.08)
CAMERA = Camera(640, 480, np.array([[600.0, 0.0, 320.0], [0.0, 600.0, 240.0], [0.0, 0.0, 1.0]]))
CAMERA_FROM_BOX = look_at(VIEWPOINT, TARGET)
NOISE = 0.4
"""Pixels."""
MISSED = "base_ne"
CLUTTER = [("corner", (101.0, 388.0)), ("corner", (522.0, 66.0)), ("sticker", (77.0, 131.0))]


def gamma() -> dict[str, object]:
    """The ``gamma/1`` document: features in a lobe and not behind the box itself, moved by noise, ordered by place."""
    box = read_kb(shipped("first")).types[0]
    at = transform_points(CAMERA_FROM_BOX, np.array([feature.at for feature in box.features]))
    seen = feature_in_lobe(box.lobes, np.array([VIEWPOINT]))[0] & ~behind(at, box.surface.rays, CAMERA_FROM_BOX, 0.001)
    uv = CAMERA.project(at) + np.random.default_rng(0).normal(0.0, NOISE, (len(at), 2))
    found = [
        (box.features[f].type, tuple(np.round(uv[f], 1).tolist()))
        for f in np.flatnonzero(seen)
        if box.features[f].name != MISSED
    ]
    rows = [
        {"id": f"a{i}", "type": kind, "uv": list(place), "detector": f"{kind}s"}
        for i, (kind, place) in enumerate(sorted(found + CLUTTER, key=lambda row: row[1]), 1)
    ]
    return {"format": "gamma/1", "camera": camera_to_dict(CAMERA), "appearances": rows}


def text() -> str:
    """The file, one appearance a line."""
    document = gamma()
    rows = ",\n  ".join(json.dumps(row) for row in document["appearances"])
    camera = json.dumps(document["camera"])
    return f'{{"format": "gamma/1",\n "camera": {camera},\n "appearances": [\n  {rows}\n ]}}\n'


if __name__ == "__main__":
    sys.stdout.write(text())
