"""Votes of single data: against a count of boxes one by one, and what an exact picture tells of its view."""

from collections import defaultdict
from dataclasses import fields

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from oriented_scenes import STRAIGHT, a_trial, clouds, datum, picture_of, seen_from

from plogic.base.clock import OutOfTimeError, unhurried
from plogic.match.gamma.data import centre_of, data_of
from plogic.match.hand.view_cells import DISTANCE
from plogic.match.oriented import single_votes as module
from plogic.match.oriented.asked import typed_data
from plogic.match.oriented.oriented_search import Search, coarse_poses
from plogic.match.oriented.single_votes import CELL, FEWEST, SCALE, TURNS, single_votes

TWO = 1, 2
"""Types by number, the one that is there in trial 6 among them."""


def votes_of(ready, data, most=2000, kinds=None, check=unhurried):
    return single_votes(
        ready.shared,
        data,
        ready.noise,
        np.arange(len(ready.rows)) if kinds is None else np.array(kinds, np.intp),
        most,
        check,
    )


def same(one, other):
    return all(np.array_equal(getattr(one, field.name), getattr(other, field.name)) for field in fields(one))


@settings(max_examples=20, deadline=None, derandomize=True)
@given(st.integers(0, 4), st.integers(0, 161), st.floats(-3.1, 3.1))
def test_an_exact_picture_votes_for_what_it_shows(kind, cell, roll):
    """One of the best hundred is right in everything, as well as a cell, a box and a turn tell it.

    The best is of the right type and place.
    """
    ready = clouds()
    index = ready.rows[kind]
    data = data_of(picture_of(index, seen_from(index, cell, roll), np.flatnonzero(index.cells.visible[cell])), STRAIGHT)
    votes, asked = votes_of(ready, data, 100)
    size = STRAIGHT.f / DISTANCE
    assert asked == len(ready.rows)
    placed = (votes.kind == kind) & (np.linalg.norm(votes.centre - centre_of(STRAIGHT), axis=1) < CELL * size)
    sized = np.abs(np.log(votes.scale * index.cells.diameter / size)) < SCALE
    turned = coarse_poses(ready.shared, votes, data)[:, :3, :3] @ seen_from(index, cell, roll)[:3, :3].T
    off = np.degrees(np.arccos(np.clip((np.trace(turned, axis1=1, axis2=2) - 1.0) / 2.0, -1.0, 1.0)))
    assert placed[0]
    assert (placed & sized & (off < 20.0)).any()


@settings(max_examples=10, deadline=None, derandomize=True)
@given(st.integers(0, 20), st.integers(0, 4), st.sampled_from([50.0, 120.0, 300.0]), st.sampled_from([0.0, 0.5]))
def test_boxes_are_those_that_counting_one_by_one_finds(seed, kind, size, offset):
    _, _, data = a_trial(clouds(), seed)
    matches = module._matches(
        clouds().shared, kind, slice(30, 60), typed_data(data, clouds().shared.looks), np.zeros(2)
    )
    wide, one = np.float32(CELL * size), np.float32(CELL)
    x, y = matches.x / wide - matches.right / one, matches.y / wide - matches.down / one
    boxes = defaultdict(list)
    for i in range(len(matches.cell)):
        where = (int(np.floor(at[i] + np.float32(offset - np.floor(at.min())))) for at in (x, y))
        boxes[int(matches.cell[i]), int(matches.turn[i]), *where].append(i)
    full = {tuple(rows) for rows in boxes.values() if len(rows) >= FEWEST}
    rows, first = module._boxed(matches, size, offset)
    assert {tuple(part.tolist()) for part in np.split(rows, first[1:]) if len(part)} == full


def test_each_datum_votes_at_the_two_nearest_turns():
    _, _, data = a_trial(clouds(), 2)
    matches = module._matches(clouds().shared, 1, slice(0, 162), typed_data(data, clouds().shared.looks), np.zeros(2))
    half = len(matches.cell) // 2
    step = 2.0 * np.pi / TURNS
    assert half > 1000
    assert np.array_equal((matches.turn[:half] + 1) % TURNS, matches.turn[half:])
    assert (np.abs(matches.bent) <= step + 1e-5).all()
    assert np.allclose(matches.bent[half:] - matches.bent[:half], step, atol=1e-5)


def test_the_order_of_the_data_says_nothing():
    _, case, data = a_trial(clouds(), 5)
    mixed = [case.gamma.appearances[i] for i in np.random.default_rng(0).permutation(len(case.gamma.appearances))]
    assert same(votes_of(clouds(), data)[0], votes_of(clouds(), data_of(mixed, case.gamma.camera))[0])


def test_in_blocks_the_same(monkeypatch):
    _, _, data = a_trial(clouds(), 6)
    whole = votes_of(clouds(), data, 500, TWO)[0]
    monkeypatch.setattr(module, "BLOCK", 300)
    parts = votes_of(clouds(), data, 500, TWO)[0]
    assert np.array_equal(np.sort(whole.weight), np.sort(parts.weight))
    monkeypatch.setattr(module, "KEPT", 0)
    assert same(parts, votes_of(clouds(), data, 500, TWO)[0])


def test_the_best_come_first_and_no_more_than_are_asked_for():
    _, _, data = a_trial(clouds(), 7)
    many, few = votes_of(clouds(), data, 3000)[0], votes_of(clouds(), data, 30)[0]
    assert (np.diff(many.weight) <= 0).all()
    assert len(few.weight) == 30
    assert same(few, many.take(np.arange(30)))


def test_of_more_than_can_be_asked_the_first_are(monkeypatch):
    _, _, data = a_trial(clouds(), 8)
    typed = typed_data(data, clouds().shared.looks)
    monkeypatch.setattr(module, "MOST", int(typed.count[clouds().shared.sights.looks[3]].sum()) + 10)
    votes, asked = votes_of(clouds(), data, kinds=[3, 0, 1])
    assert asked == 1
    assert set(votes.kind) == {3}


@pytest.mark.parametrize(
    "appearances", [[], [datum(0, "never seen", (300, 200), 0.1)], [datum(0, clouds().shared.looks[0], (300, 200))]]
)
def test_who_says_nothing_has_no_votes(appearances):
    votes, asked = votes_of(clouds(), data_of(appearances, STRAIGHT))
    assert asked == len(clouds().rows)
    assert votes.centre.shape == (0, 2)
    assert not len(votes.weight)


def test_it_ends_when_told():
    def ended():
        raise OutOfTimeError

    with pytest.raises(OutOfTimeError):
        votes_of(clouds(), a_trial(clouds(), 1)[2], check=ended)


def test_a_search_asks_single_data_once():
    ready = clouds(count=3, features=60)
    _, _, data = a_trial(ready, 9)
    search = Search(ready.asked(data))
    usual = search.proposals(data)
    assert not search.deepened
    search.deepen()
    assert search.deepened
    deep, after = search.proposals(data), search.proposals(data)
    assert [p.worth for p in after] == [p.worth for p in usual]
    assert deep[0].kind == usual[0].kind
    assert search.deepened
