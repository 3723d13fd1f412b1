"""Tables of all data by all data, in blocks of rows.

The same answers whatever the blocks, and time is asked for between them.
"""

from __future__ import annotations

from itertools import combinations

import numpy as np
import pytest
from synthetic import CAMERA, perceiver

from plogic.base.clock import OutOfTimeError
from plogic.match.gamma import data as blocks
from plogic.match.gamma.data import data_of
from plogic.match.gamma.grid import wrapped
from plogic.match.hand import links
from plogic.match.hand.generate import generate
from plogic.match.hand.links import ALONG_ONE_ARM, POINTING, data_links, linked_pairs
from plogic.match.hand.place_index import place_index
from plogic.match.hand.place_votes import image_triples
from sensing.appearance import Appearance

SCALES = (10.0, 2000.0)
NEIGHBOURS = 12


def clutter(number, seed, arms=4, step=1.0):
    """``step``: places are whole multiples of it, so that distances are equal often."""
    rng = np.random.default_rng(seed)
    kinds = perceiver().kb.appearance_types
    rows = []
    for i in range(number):
        place = np.rint(rng.uniform(0, [639, 479]) / step) * step
        angles = tuple(np.sort(rng.uniform(0, 2 * np.pi, rng.integers(0, arms + 1))).tolist())
        rows.append(
            Appearance(
                f"a{i}", kinds[rng.integers(len(kinds))], (float(place[0]), float(place[1])), "drawn", arms=angles
            )
        )
    return data_of(rows, CAMERA)


def assert_same(one, other):
    bytes_of_one, bytes_of_other = (
        {name: (a.dtype, a.shape, a.tobytes()) for name, a in vars(each).items()} for each in (one, other)
    )
    assert bytes_of_one == bytes_of_other


def links_one_by_one(data):
    found = set()
    for i, arms in enumerate(data.arms):
        step = data.ideal - data.ideal[i]
        length, angle = np.hypot(*step.T), np.arctan2(step[:, 1], step[:, 0])
        for arm in arms[np.isfinite(arms)]:
            on = np.flatnonzero((np.abs(wrapped(angle - arm)) < POINTING) & (length > 1.0))
            found |= {(i, int(j)) for j in sorted(on, key=lambda j: length[j])[:ALONG_ONE_ARM]}
    return sorted(found)


@pytest.mark.parametrize("entries", [1, 700, 2**20])
@pytest.mark.parametrize("seed", range(4))
def test_links_are_those_that_each_arm_has_alone(seed, entries, monkeypatch):
    data = clutter(90, seed, step=(1e-9, 20.0)[seed % 2])
    monkeypatch.setattr(blocks, "ENTRIES", entries)
    found = data_links(data)
    assert list(zip(found.first.tolist(), found.second.tolist(), strict=True)) == links_one_by_one(data)
    step = data.ideal[found.second] - data.ideal[found.first]
    assert np.array_equal(found.length, np.hypot(*step.T))
    np.testing.assert_allclose(found.angle, np.arctan2(step[:, 1], step[:, 0]), rtol=1e-14)


@pytest.mark.parametrize(("number", "most"), [(0, 60_000), (1, 60_000), (2, 60_000), (60, 60_000), (60, 50)])
def test_pairs_by_links_are_the_same_in_any_blocks(number, most, monkeypatch):
    index, data = perceiver().models["t2"], clutter(number, 9)
    monkeypatch.setattr(links, "MOST_PAIRS", most)
    whole = linked_pairs(index.cells, index.links, index.allowed(data), data, SCALES)
    assert len(whole.cell) == most or number < 3 or most > 1000
    monkeypatch.setattr(blocks, "ENTRIES", 3000)
    assert_same(linked_pairs(index.cells, index.links, index.allowed(data), data, SCALES), whole)


@pytest.mark.parametrize(("number", "step"), [(0, 1e-9), (1, 1e-9), (2, 1e-9), (80, 1e-9), (80, 20.0)])
def test_triples_are_the_same_in_any_blocks(number, step, monkeypatch):
    places, data = place_index([perceiver().models["t2"]]), clutter(number, 5, step=step)
    whole = image_triples(places, data, NEIGHBOURS)
    assert whole.data.shape == (len(whole.key), 3)
    assert len(whole.key) > 0 or number < 3
    monkeypatch.setattr(blocks, "ENTRIES", 100)
    assert_same(image_triples(places, data, NEIGHBOURS), whole)
    near = np.hypot(*(data.ideal[:, None] - data.ideal).T)
    reach = np.sort(near, axis=1)[:, NEIGHBOURS] if number > NEIGHBOURS else None
    for three in whole.data.tolist():
        assert any(all(near[i, j] <= reach[i] for j in three) for i in three), "two are neighbours of the third"


def test_blocks_are_bounded_and_cover_every_row_once():
    for rows, columns in ((0, 5), (7, 0), (1, 10**9), (20_000, 20_000), (3, 2**19)):
        found = list(blocks.blocks(rows, columns))
        assert [i for some in found for i in range(some.start, some.stop)] == list(range(rows))
        assert all((some.stop - some.start) * columns <= max(blocks.ENTRIES, columns) for some in found)


@pytest.mark.parametrize("arms", [0, 3])
def test_the_search_for_a_type_can_be_stopped_at_every_look(arms, monkeypatch):
    """Between blocks too: the more there are the oftener it looks, and it finds the same."""
    index, data, kb = place_index([perceiver().models["t2"]]), clutter(40, 2, arms), perceiver().kb

    def looks(most):
        count = 0

        def check():
            nonlocal count
            count += 1
            if count > most:
                raise OutOfTimeError

        return generate(index, data, kb, check=check)["t2"], count

    found, few = looks(np.inf)
    monkeypatch.setattr(blocks, "ENTRIES", 500)
    again, many = looks(np.inf)
    assert many > few > 20
    assert (
        [ratio for ratio, _ in again]
        == [ratio for ratio, _ in found]
        == [ratio for ratio, _ in generate(index, data, kb)["t2"]]
    )
    for most in np.linspace(0, many - 1, 6).astype(int):
        with pytest.raises(OutOfTimeError):
            looks(most)
    assert all(
        np.array_equal(a[1].camera_from_object, b[1].camera_from_object)
        for a, b in combinations([*found[:1], *again[:1]], 2)
    )
