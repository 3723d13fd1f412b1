"""``plogic worlds --poses``: where each object of each possible world is, as CSV.

A row an object a world. Matrices are 4x4, row by row, 16 numbers with blanks between them, translations in metres.
``T_world_object`` is there where the camera has a pose.
"""

import csv
from collections.abc import Sequence
from io import StringIO

import numpy as np

from plogic.face.session.results import World
from plogic.facts.document import Interpretation

COLUMNS = "world", "world_probability", "object", "type", "probability", "pose_probability", "T_camera_object_m"


def pose_table(document: Interpretation, worlds: Sequence[World]) -> str:
    """The CSV, with its header; a world without objects has no row."""
    known, placed = {h["id"]: h for h in document["hypotheses"]}, document["camera"].get("T_world_camera")
    text = StringIO()
    table = csv.writer(text, lineterminator="\n")
    table.writerow([*COLUMNS, *["T_world_object_m"] * (placed is not None)])
    for rank, world in enumerate(worlds, 1):
        for name in world.present:
            h = known[name]
            poses = [np.array(h["T_camera_object"])]
            if placed is not None:
                poses.append(np.array(placed) @ poses[0])
            sure = h.get("pose_probability", "")
            row = rank, world.probability, name, h["type"], h["probability"], "" if sure is None else sure
            table.writerow([*row, *(" ".join(map(str, pose.ravel().tolist())) for pose in poses)])
    return text.getvalue()
