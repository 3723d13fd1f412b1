"""A knowledge base to start from by hand: the shipped box, with what each key is for beside it."""

import json

from kb.files.folder import shipped
from kb.intake.new_type import new_kb_files

HOME = shipped("first")
BOX = "objects/box"

KB_YAML = """\
# yaml-language-server: $schema=./kb.schema.json
# Every key: docs/formats.md, or plogic kb schema.
name: {name}
# What detectors report: the types of appearances, which object.yaml may name.
appearance_types: [corner, sticker]
# The focal length, in pixels, that the ranges of lobes hold for.
f_ref: 600
detector:
  # Chance that an expected feature is detected, per feature type (0.8 where nothing stands here).
  hit: {{corner: 0.9, sticker: 0.9}}
  # Appearances of noise in an image, per appearance type.
  clutter: {{corner: 3, sticker: 1}}
  # Location noise, and how far from its predicted place a feature may be found; pixels.
  sigma: 1.0
  match_tolerance: 4.0
# Chance that an object is there, per object type (0.5 where nothing stands here).
priors: {{box: 0.5}}
"""

HEAD = """\
# yaml-language-server: $schema=../../object.schema.json
# A box of 30 x 20 x 16 cm: its eight corners, and five stickers on its sides. Every key: docs/formats.md.
#
# object     the type's name, as in priors
# mesh       its closed surface, from which follows what hides what; the unit must be stated
# opaque     whether it hides what is behind it
# features   each with a name of its own, a type (the rarer, the more distinctive), and its place in the object's frame,
#            in metres or with a unit: [3 cm, 0, 0]
# appearances of a feature: as which appearance type it is seen, and from where, its lobe: a cone about an axis that
#            points towards the viewer, with its half-angle, and the nearest and farthest distance
#
# How many features a type needs: plogic kb check warns where it shows too few at once.
"""


def example_files(name: str) -> dict[str, bytes]:
    """Every file of a new KB that knows the box, by relative path.

    Raises:
        IntakeError: for a name of other signs than a folder's.
    """
    files = new_kb_files(name)
    files["kb.yaml"] = KB_YAML.format(name=json.dumps(name)).encode()
    files[f"{BOX}/object.yaml"] = HEAD.encode() + (HOME / BOX / "object.yaml").read_bytes()
    files[f"{BOX}/mesh.obj"] = (HOME / BOX / "mesh.obj").read_bytes()
    return files
