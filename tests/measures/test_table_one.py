"""Table 1 (§5.6) from its cells and the towers' own dv.

Nothing here is a constant of the result but the paper's printed figures.
"""

import pytest

from kb.files.folder import shipped
from kb.files.read import read_kb
from plogic.measures.distinctiveness import distinctiveness, instance_counts
from plogic.measures.explanatory import Cells, explanatory_value, reconsidered

ROWS = {  # A, C, B, D: the paper's column order
    "T2 distorted": ({"apex": Cells(1, 0, 0, 0), "corner": Cells(0, 6, 1, 2), "patch": Cells(1, 16, 12, 16)}, -0.51),
    "T2 correct": ({"apex": Cells(1, 0, 0, 0), "corner": Cells(4, 2, 2, 0), "patch": Cells(9, 4, 16, 2)}, 0.58),
    "T1 correct": ({"apex": Cells(0, 0, 0, 0), "corner": Cells(7, 0, 0, 0), "patch": Cells(27, 0, 23, 0)}, 1.0),
    "T2 reconsidered": ({"apex": Cells(1, 0, 0, 0), "corner": Cells(4, 0, 2, 0), "patch": Cells(9, 0, 16, 2)}, 0.94),
}
EXPLAINED = {"corner": 2, "patch": 4}
DISPLACED = {"patch": 2}


@pytest.fixture(scope="module")
def towers():
    return read_kb(shipped("towers"))


@pytest.fixture(scope="module")
def dv(towers):
    return distinctiveness(instance_counts(towers.types))


def test_the_towers_have_the_composition_that_the_table_needs(towers):
    assert instance_counts(towers.types) == {"apex": 1, "corner": 16, "patch": 95}


@pytest.mark.parametrize("name", ROWS)
def test_explanatory_values(name, dv):
    support, printed = ROWS[name]
    assert round(explanatory_value(support, dv), 2) == printed


@pytest.mark.parametrize(("mode", "printed"), [("drop", 0.94), ("to_B", 0.95), ("reassign", 1.0)])
def test_reconsideration_of_the_correct_tower(mode, printed, dv):
    support, _ = ROWS["T2 correct"]
    again = reconsidered(support, EXPLAINED, mode, DISPLACED)
    assert round(explanatory_value(again, dv), 2) == printed


def test_dropping_the_explained_cells_gives_the_printed_row():
    assert reconsidered(ROWS["T2 correct"][0], EXPLAINED, "drop") == ROWS["T2 reconsidered"][0]


def test_more_explained_than_missed_is_refused():
    with pytest.raises(ValueError, match="corner"):
        reconsidered(ROWS["T2 correct"][0], {"corner": 3}, "drop")
