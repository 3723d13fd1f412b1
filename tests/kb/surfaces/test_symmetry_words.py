"""A group of symmetries in words: the identity counts for none."""

from __future__ import annotations

import numpy as np
import pytest

from geometry.frames import motion_about
from kb.files.schema import SymmetryModel
from kb.surfaces.symmetries import motions, symmetry_words


@pytest.mark.parametrize(
    ("listed", "words"),
    [
        ([], "no symmetry"),
        ([{"axis": [0, 0, 1], "fold": 2}], "2-fold symmetry"),
        ([{"axis": [1, 2, 0], "fold": 4, "at": [0.1, 0, 0]}], "4-fold symmetry"),
        ([{"axis": [0, 0, 1], "continuous": True}], "symmetric in any turn about an axis"),
        ([{"axis": [0, 0, 1], "fold": 2}, {"axis": [1, 0, 0], "fold": 2}], "4 symmetric poses"),
    ],
)
def test_in_words(listed, words):
    group = motions([SymmetryModel.model_validate(row) for row in listed])
    assert symmetry_words(group) == words


def test_a_group_read_as_an_array_alone():
    half = motion_about((0, 1, 0), np.zeros(3), np.pi)
    assert symmetry_words(np.array([np.eye(4), half])) == "2-fold symmetry"
