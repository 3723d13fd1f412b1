"""Attention: the order in which types are tried (§5.3), from types alone."""

from collections import Counter
from dataclasses import replace

import numpy as np
import pytest
from synthetic import camera_pose, perceiver, scene, towers

from benchmarks.clutter.types import random_types, type_names
from plogic.cycle.perception import attend, chance_types
from plogic.match.hand.hand_models import type_index
from plogic.measures.distinctiveness import rank


def order_of(types):
    return attend(list(perceiver().models.values()), types, towers())


def test_the_type_whose_every_feature_is_there_comes_first():
    features = towers().type("t2").features
    rows = order_of([f.appearances[0].type for f in features])
    assert rows[0].type == "t2"
    assert rows[0].rank > rows[1].rank
    assert rows[0].rank > 0.999


def test_an_empty_gamma_ranks_everything_zero():
    rows = order_of([])
    assert {row.type for row in rows} == {"t1", "t2"}
    for row in rows:
        assert (row.rank, row.within_cell) == (0.0, 0.0)
        assert row.excess <= 0.0


def test_every_number_lies_in_its_range_and_order_follows_rank():
    for seed in range(3):
        rng = np.random.default_rng(seed + 9000)
        shot = scene(rng, {"t1": camera_pose(rng)})
        rows = order_of([a.type for a in shot.gamma.appearances])
        assert [row.type for row in rows] == [row.type for row in sorted(rows, key=lambda r: -round(r.rank, 9))]
        for row in rows:
            assert 0.0 <= row.rank <= 1.0
            assert 0.0 <= row.within_cell <= 1.0
            assert -1.0 <= row.excess <= row.rank


def test_in_saturating_clutter_excess_tells_what_rank_cannot():
    """Hundreds of appearances of every kind: rank is 1 for all, and excess over chance is 0."""
    rows = order_of(list(towers().appearance_types) * 100)
    assert {row.type for row in rows} == {"t1", "t2"}
    assert all(row.rank > 0.999 for row in rows)
    assert all(row.excess < 0.3 for row in rows)


def test_the_order_of_gamma_changes_nothing():
    rng = np.random.default_rng(9010)
    types = [a.type for a in scene(rng, {"t2": camera_pose(rng)}).gamma.appearances]
    assert order_of(types) == order_of(types[::-1])


def test_chance_is_in_proportion_to_clutter():
    rates = towers().rates.clutter
    total = sum(rates.values())
    chance = chance_types(towers(), 100)
    assert {name: chance.count(name) for name in rates} == {
        name: int(100 * rate / total) for name, rate in rates.items()
    }
    assert 90 < len(chance) <= 100


@pytest.mark.parametrize("seed", range(6))
def test_counting_is_the_best_matching_where_features_have_one_appearance_type_each(seed):
    rng = np.random.default_rng(seed)
    kind = random_types(1, 12, 5, rng).types[0]
    index = type_index(kind, dict.fromkeys(type_names(5), 1.0))
    shown = rng.random((20, 12)) < 0.6
    index = replace(index, weights=rng.choice([0.0, 0.2, 0.2, 1.0], 12), cells=replace(index.cells, visible=shown))
    there = rng.choice(type_names(5), 6).tolist()
    looks = [frozenset(a.type for a in feature.appearances) for feature in kind.features]
    best = [
        rank(index.weights[row], [looks[f] for f in np.flatnonzero(row)], Counter(there))
        for row in [np.ones(12, bool), *shown]
    ]
    assert index._counted(Counter(there)) == pytest.approx(best, abs=1e-9)
