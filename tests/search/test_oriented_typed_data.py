"""The nearest datum of a right type and angle for any number of places at once: one by one is the oracle."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from oriented_scenes import STRAIGHT, datum

from plogic.search.data import data_of
from plogic.search.oriented.typed_data import typed_data

NAMES = ("a", "b", "c")


def some_data(rng, count):
    """Of three known types and an unknown one, a fifth of them without an angle, crowded."""
    kinds, places, angles = rng.choice([*NAMES, "x"], count), rng.uniform(0.0, 60.0, (count, 2)), rng.uniform(0.0, 2.0 * np.pi, count)
    return data_of([datum(i, kinds[i], places[i], None if i % 5 == 0 else angles[i]) for i in range(count)], STRAIGHT)


def one_by_one(data, uv, looks, angle, tolerance, turned):
    """The datum of each sight (V,) of one pose, −1 for none; of those that want the same the nearest has it."""
    wanted = []
    for place, look, facing in zip(uv, looks, angle, strict=True):
        off = np.linalg.norm(data.ideal - place, axis=1)
        bent = np.abs(np.angle(np.exp(1j * (np.nan_to_num(data.angle) - facing))))
        right = (np.array(data.types) == NAMES[look]) & np.isfinite(data.angle) & (bent <= turned)
        best = int(np.where(right, off, np.inf).argmin())
        wanted.append((best, off[best]) if right[best] and off[best] <= tolerance else (-1, np.inf))
    first = {best: min(other for same, other in wanted if same == best) for best, _ in wanted}
    return [best if best >= 0 and off == first[best] else -1 for best, off in wanted]


@settings(max_examples=60, deadline=None, derandomize=True)
@given(st.integers(0, 10**6), st.integers(1, 40), st.integers(1, 3), st.integers(1, 12))
def test_each_sight_has_the_nearest_that_is_right_and_no_two_have_the_same(seed, count, poses, sights):
    rng = np.random.default_rng(seed)
    data = some_data(rng, count)
    uv, looks = rng.uniform(0.0, 60.0, (poses, sights, 2)), rng.integers(0, 3, (poses, sights))
    angle, tolerance, turned = rng.uniform(-np.pi, np.pi, (poses, sights)), rng.uniform(5.0, 40.0, poses), float(rng.uniform(0.3, 3.0))
    got, off, bent = typed_data(data, NAMES).nearest(uv, looks, angle, tolerance, turned)
    for n in range(poses):
        assert got[n].tolist() == one_by_one(data, uv[n], looks[n], angle[n], tolerance[n], turned)
    pose, sight = np.nonzero(got >= 0)
    mine = got[pose, sight]
    assert np.allclose(off[pose, sight], np.linalg.norm(data.ideal[mine] - uv[pose, sight], axis=1))
    assert np.allclose(np.exp(1j * bent[pose, sight]), np.exp(1j * (data.angle[mine] - angle[pose, sight])))
    assert (np.abs(bent[pose, sight]) <= turned).all()


def test_two_sights_that_want_one_datum_give_it_to_the_nearer():
    data = data_of([datum(0, "a", (100.0, 100.0), 0.5)], STRAIGHT)
    got, _, _ = typed_data(data, NAMES).nearest(
        np.array([[[103.0, 100.0], [101.0, 100.0]]]), np.zeros((1, 2), np.intp), np.full((1, 2), 0.5), np.array([10.0]), 0.3
    )
    assert got.tolist() == [[-1, 0]]


@pytest.mark.parametrize("kinds", [(), ("x",), ("b", "x", "b")])
def test_data_are_counted_by_type_and_what_no_sight_has_is_nobodys(kinds):
    table = typed_data(data_of([datum(i, kind, (i, i), 0.1) for i, kind in enumerate(kinds)], STRAIGHT), NAMES)
    assert table.looks.tolist() == [NAMES.index(kind) if kind in NAMES else -1 for kind in kinds]
    assert table.count[: len(NAMES)].tolist() == [kinds.count(name) for name in NAMES]
    got, _, _ = table.nearest(np.ones((1, 3, 2)), np.array([[0, 1, -1]]), np.full((1, 3), 0.1), np.array([50.0]), 0.5)
    assert got[0, 0] == got[0, 2] == -1
    assert (got[0, 1] >= 0) == ("b" in kinds)
