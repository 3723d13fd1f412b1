"""The composition table between its bounds.

No bodies beyond the models, and bodies for what the models allow (§3.7).
"""

from itertools import permutations

import numpy as np
import pytest

from benchmarks.occlusion.stacks import clamps, codes, grown, one_piece
from benchmarks.occlusion.tables import composition, composition_lines, sign
from benchmarks.occlusion.witness import arrangements, built, checked, triples
from geometry.visibility.composition import possible_triples
from geometry.visibility.roc import ROC20, converse, parts_of


@pytest.fixture(scope="module")
def upper():
    return possible_triples()


@pytest.fixture(scope="module")
def found():
    return arrangements(np.random.default_rng(5), 500)


def test_the_images_alone_compose_as_rcc_8(upper):
    """193 consistent triples; a few entries of the published table."""
    images = {tuple(parts_of(r)[0] for r in triple) for triple in upper}
    table = {}
    for r, s, t in images:
        table.setdefault((r, s), set()).add(t)
    assert len(images) == 193
    assert table["TPP", "NTPP"] == {"NTPP"}
    assert table["NTPP", "EC"] == {"DC"}
    assert table["TPP", "EC"] == {"DC", "EC"}
    assert table["TPPi", "TPP"] == {"PO", "TPP", "TPPi", "EQ"}
    assert len(table["NTPP", "NTPPi"]) == 8
    assert table["EC", "NTPPi"] == {"DC"}


def test_renaming_the_three_changes_nothing(upper):
    for triple in upper:
        named = dict(zip(((0, 1), (1, 2), (0, 2)), triple, strict=True))
        named |= {(j, i): converse(r) for (i, j), r in named.items()}
        assert all((named[a, b], named[b, c], named[a, c]) in upper for a, b, c in permutations(range(3)))
    assert len(upper) == 2421


def test_in_front_of_what_is_in_front_of_all_of_it_is_in_front(upper):
    table = composition(upper)
    assert table["totally_occludes_ntppi", "totally_occludes_ntppi"] == {"totally_occludes_ntppi"}
    assert table["totally_occludes_eq", "totally_occludes_tppi"] == {"totally_occludes_tppi"}
    assert table["non_occludes_dc", "totally_occludes_ntppi"] == {"non_occludes_dc"}
    assert table["totally_occludes_eq", "totally_occluded_by_eq"] == {
        "totally_occludes_eq",
        "totally_occluded_by_eq",
        "mutually_occludes_eq",
    }
    assert all(table.values())


@pytest.mark.parametrize("seed", range(3))
def test_random_bodies_keep_to_the_upper_bound(upper, seed):
    seen = set()
    for grids in grown(np.random.default_rng(seed), 1500):
        relations = np.stack([codes(grids, *pair) for pair in ((1, 2), (2, 3), (1, 3))], axis=1)
        seen |= {
            tuple(ROC20[i] for i in row) for row in np.unique(relations[(relations >= 0).all(axis=1)], axis=0).tolist()
        }
    assert len(seen) > 300
    assert seen <= upper


def test_bodies_are_built_for_what_is_reached(upper, found):
    lower = triples(found)
    assert len(lower) > 1500
    assert lower <= upper
    assert checked(found, lower, np.random.default_rng(1), 20) == [True] * 20


def test_a_built_triple_is_what_was_asked_for(found):
    triple = ("mutually_occludes_eq",) * 3
    one = next(a for a in found if a.terms == ("EQ",) * 3)
    grid = built(one, triple)
    assert [ROC20[int(codes(grid, *pair)[0])] for pair in ((1, 2), (2, 3), (1, 3))] == list(triple)
    assert all(one_piece(grid[0] == body) for body in (1, 2, 3))


def test_clamps_are_one_piece_each_and_mutual():
    grids = clamps(np.random.default_rng(2), 6)
    assert len(grids) == len(codes(grids, 1, 2)) > 0
    assert all(ROC20[i].startswith("mutually") for i in codes(grids, 1, 2))
    assert all(one_piece(grid == body) for grid in grids for body in (1, 2))


def test_a_line_of_the_table_marks_what_is_not_proved(upper):
    table = composition(upper)
    less = {pair: some - {"mutually_occludes_po"} for pair, some in table.items()}
    lines = composition_lines(less, table)
    assert len(lines) == 400
    assert lines[ROC20.index("partially_occludes_po") * 20 + ROC20.index("mutually_occludes_po")].endswith(" ? *po")
    assert lines[0] == f"dc ; dc = {' '.join(sign(r) for r in ROC20)}".replace(" *po", "") + " ? *po"
    assert not any("?" in line for line in composition_lines(table, table))
