"""A small good KB as text, for tests to spoil."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from pathlib import Path

KB = """\
name: small
appearance_types: [apex, corner]
f_ref: 600
detector:
  hit: {apex: 0.9}
  clutter: {corner: 3}
  sigma: 1.5
  match_tolerance: 5
priors: {tent: 0.25}
"""

OBJECT = """\
object: tent
mesh: {file: mesh.obj, units: cm}
symmetries: [{axis: [0, 0, 1], fold: 3}]
parts:
  - part: roof
    at: [0, 0, 0.5 m]
    rotation: {euler_xyz: [0, 0, 90 deg]}
    features:
      - feature: apex
        type: apex
        at: [10 cm, 0, 50 cm]
        arms: [[2, 0, 0], [0, 1, 0]]
        appearances:
          - {type: apex, lobe: {axis: [0, 0, 2], half_angle: 100 deg, range: [0.2 m, 30 m]}}
      - feature: pair
        type: corner
        at: [0, 0, 0]
        features:
          - feature: left
            type: corner
            at: [1, 0, 0]
            appearances:
              - type: corner
                lobe: {axis: [1, 0, 0], half_angle: 60 deg, range: [0.2, 3]}
  - part: body
    features: []
"""

MESH = """\
v 100 0 0
v -50 86.602540378 0
v -50 -86.602540378 0
v 0 0 100
f 1 3 2
f 1 2 4
f 2 3 4
f 3 1 4
"""


def write_small(folder: Path, **changed: str | bytes | None) -> Path:
    """The KB's folder; ``kb``, ``object``, ``mesh``, ``rules`` take the place of the texts above.

    None leaves the file out.
    """
    files = {
        "kb": "kb.yaml",
        "object": "objects/tent/object.yaml",
        "mesh": "objects/tent/mesh.obj",
        "rules": "rules.pl",
    }
    texts = {"kb": KB, "object": OBJECT, "mesh": MESH, "rules": None} | changed
    for key, text in texts.items():
        path = folder / files[key]
        path.parent.mkdir(parents=True, exist_ok=True)
        if text is not None:
            path.write_bytes(text if isinstance(text, bytes) else text.encode())
    return folder
