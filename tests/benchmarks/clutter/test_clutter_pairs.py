"""Typed correspondences: what the peers of ``plogic bench clutter`` start from."""

from __future__ import annotations

import numpy as np
from test_clutter_peers import gamma_of

from benchmarks.clutter.pairs import by_type, correspondences, different, typed
from benchmarks.clutter.types import EASY, knowledge_base, made, type_names


def kind_of(name, *looks):
    n = len(looks)
    return made(name, None, np.arange(3.0 * n).reshape(n, 3), np.tile(np.eye(3), (n, 1, 1)), looks, np.ones(n))


def test_pairs_are_of_the_same_type_and_all_of_them():
    kind = kind_of("it", "a000", "a001", "a000")
    pairs = correspondences(kind, by_type(gamma_of("a000", "a002", "a001", "a000")))
    assert list(zip(pairs.feature.tolist(), pairs.datum.tolist(), strict=True)) == [
        (0, 0),
        (0, 3),
        (1, 2),
        (2, 0),
        (2, 3),
    ]
    assert np.array_equal(pairs.points, np.arange(9.0).reshape(3, 3))
    nothing = correspondences(kind, by_type(gamma_of("a007")))
    assert (len(nothing.feature), len(nothing.datum)) == (0, 0)


def test_types_that_fewer_than_four_data_could_show_are_left_out_and_most_pairs_come_first():
    few, some, most = kind_of("few", *["a000"] * 3), kind_of("some", *["a000"] * 4), kind_of("most", *["a001"] * 4)
    kb = knowledge_base((few, some, most), type_names(2), EASY)
    assert [pairs.kind.name for pairs in typed(kb, gamma_of("a000", "a001", "a001"))] == ["most", "some"]


def test_features_that_share_a_datum_count_once():
    pairs = correspondences(kind_of("it", "a000", "a000"), by_type(gamma_of("a000", "a000")))
    assert [different(pairs, np.array(rows, int)) for rows in ([], [0], [0, 1], [0, 2], [0, 3], [0, 1, 2, 3])] == [
        0,
        1,
        1,
        1,
        2,
        2,
    ]
