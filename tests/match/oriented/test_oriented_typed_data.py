"""Γ by what its data look like: one by one is the oracle."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from oriented_scenes import STRAIGHT, datum

from plogic.match.gamma.data import data_of
from plogic.match.oriented.asked import typed_data

NAMES = ("a", "b", "c")


def some_data(rng, count):
    """Of three known types and an unknown one, a fifth of them without an angle, crowded."""
    kinds, places, angles = (
        rng.choice([*NAMES, "x"], count),
        rng.uniform(0.0, 60.0, (count, 2)),
        rng.uniform(0.0, 2.0 * np.pi, count),
    )
    return data_of([datum(i, kinds[i], places[i], None if i % 5 == 0 else angles[i]) for i in range(count)], STRAIGHT)


@settings(max_examples=60, deadline=None, derandomize=True)
@given(st.integers(0, 10**6), st.integers(0, 40), st.integers(0, 12))
def test_each_sight_has_all_data_of_its_type_that_have_an_angle(seed, count, sights):
    rng = np.random.default_rng(seed)
    data, looks = some_data(rng, count), rng.integers(-1, 3, sights)
    table = typed_data(data, NAMES)
    row, at = table.of(looks)
    assert (np.diff(row) >= 0).all()
    for sight, look in enumerate(looks):
        mine = [
            i for i, kind in enumerate(data.types) if look >= 0 and kind == NAMES[look] and np.isfinite(data.angle[i])
        ]
        wanted = sorted((*data.ideal[i].tolist(), data.angle[i]) for i in mine)
        of = at[row == sight]
        assert sorted((*table.places[i].tolist(), table.angles[i]) for i in of) == wanted


@pytest.mark.parametrize("kinds", [(), ("x",), ("b", "x", "b")])
def test_data_are_counted_by_type_and_what_no_sight_has_is_nobodys(kinds):
    table = typed_data(data_of([datum(i, kind, (i, i), 0.1) for i, kind in enumerate(kinds)], STRAIGHT), NAMES)
    assert table.looks.tolist() == [NAMES.index(kind) if kind in NAMES else -1 for kind in kinds]
    assert table.count.tolist() == [*(kinds.count(name) for name in NAMES), 0]
    assert len(table.places) == len(table.angles) == kinds.count("b")


def test_the_order_of_the_data_does_not_matter():
    rng = np.random.default_rng(3)
    data = some_data(rng, 40)
    other = data.only(np.ones(40, bool))
    order = rng.permutation(40)
    shuffled = data_of(
        [datum(i, data.types[i], data.uv[i], None if np.isnan(data.angle[i]) else data.angle[i]) for i in order],
        STRAIGHT,
    )
    for table in (typed_data(other, NAMES), typed_data(shuffled, NAMES)):
        assert np.allclose(table.places, typed_data(data, NAMES).places)
        assert np.array_equal(table.angles, typed_data(data, NAMES).angles)
