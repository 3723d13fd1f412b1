"""Reads a results file of the BOP challenge, whose right form is known."""

import numpy as np

from geometry.frames import from_rotation_translation
from plogic.run.bop.results_file import HEADER, Estimate


def read_results(path):
    """The estimates of a file with a header; R row by row, t in millimetres."""
    header, *lines = path.read_text().splitlines()
    assert header == HEADER
    return [estimate(*line.split(",")) for line in lines]


def estimate(scene_id, im_id, obj_id, score, R, t, time):
    """One line's."""
    pose = from_rotation_translation(np.array(R.split(), float).reshape(3, 3), np.array(t.split(), float) / 1000)
    return Estimate(int(scene_id), int(im_id), int(obj_id), float(score), pose, float(time))
