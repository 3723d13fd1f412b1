"""Votes of pairs: what an exact picture at a cell's very viewpoint says of type, cell, roll, scale and place."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from oriented_scenes import STRAIGHT, a_trial, clouds, datum, picture_of, seen_from

from geometry.frames import pose_error
from plogic.match.gamma.data import centre_of, data_of
from plogic.match.gamma.grid import wrapped
from plogic.match.hand.view_cells import DISTANCE
from plogic.match.oriented.asked import typed_data
from plogic.match.oriented.oriented_search import coarse_poses
from plogic.match.oriented.pair_index import FINE, STEP
from plogic.match.oriented.pair_votes import BENT, NEAREST, REACH, WHOLE, counted, raw_votes

SIGMA = float(np.radians(5.0))
FIELDS = ("kind", "cell", "centre", "roll", "scale", "weight")


def votes_of(ready, appearances, camera=STRAIGHT):
    data = data_of(appearances, camera)
    return counted(raw_votes(ready.shared, typed_data(data, ready.shared.looks).looks, data, SIGMA))


def exact(ready, kind, cell, roll, most=None):
    """The picture of all that a cell shows, or of the nearest ``most`` to its first, and how many pixels a metre is."""
    index = ready.rows[kind]
    shown = np.flatnonzero(index.cells.visible[cell])
    apart = np.linalg.norm(index.cells.xy[cell, shown] - index.cells.xy[cell, shown[0]], axis=1)
    chosen = shown[np.argsort(apart, kind="stable")][:most]
    return picture_of(index, seen_from(index, cell, roll), chosen), STRAIGHT.f / (DISTANCE * index.cells.diameter)


def true_ones(votes, kind, cell, roll, scale):
    """Which votes are right in everything, as exactly as the index tells it: the object's middle is the picture's."""
    right = (votes.kind == kind) & (votes.cell == cell) & (np.abs(wrapped(votes.roll - roll)) <= 1.01 * np.pi / FINE)
    right &= np.abs(np.log(votes.scale / scale)) <= 0.51 * STEP
    size = STRAIGHT.f / DISTANCE
    return right & (np.linalg.norm(votes.centre - centre_of(STRAIGHT), axis=1) < 0.02 * size)


@settings(max_examples=25, deadline=None, derandomize=True)
@given(st.integers(0, 4), st.integers(0, 161), st.floats(-3.1, 3.1))
def test_an_exact_picture_votes_for_what_it_shows(kind, cell, roll):
    ready = clouds()
    appearances, scale = exact(ready, kind, cell, roll)
    votes = votes_of(ready, appearances)
    right = true_ones(votes, kind, cell, roll, scale)
    assert right.any()
    assert votes.weight[right].max() >= 0.5 * votes.weight.max(), "with nearly as much as any"
    assert votes.weight[right].max() >= 20 * WHOLE


@settings(max_examples=25, deadline=None, derandomize=True)
@given(st.integers(0, 4), st.integers(0, 161), st.floats(-3.1, 3.1), st.integers(2, 8))
def test_a_vote_counts_different_pairs_of_the_image(kind, cell, roll, most):
    """However many cells and types a pair resembles, it counts once a box, and no more than whole.

    Of n data there are at most n (n − 1) / 2.
    """
    appearances, _ = exact(clouds(), kind, cell, roll, most)
    uv = np.array([a.uv for a in appearances])
    apart = np.linalg.norm(uv[:, None] - uv[None], axis=2)[np.triu_indices(len(uv), 1)]
    pairs = int(((apart >= NEAREST) & (apart <= REACH)).sum())
    votes = votes_of(clouds(), appearances)
    assert votes.weight.max(initial=0) <= pairs * WHOLE
    assert (votes.weight > 0).all()
    assert len(votes.weight) > 0 or not pairs


def test_two_three_and_four_neighbours_have_one_three_and_six_votes():
    """All of each are among the nearest of the others, so that each pair is in the index."""
    ready, checked = clouds(), 0
    for cell in range(0, 162, 9):
        for most, pairs in ((2, 1), (3, 3), (4, 6)):
            appearances, scale = exact(ready, 1, cell, 0.4, most)
            uv = np.array([a.uv for a in appearances])
            apart = np.linalg.norm(uv[:, None] - uv[None], axis=2)[np.triu_indices(most, 1)]
            if ((apart > NEAREST) & (apart < REACH)).all():
                votes = votes_of(ready, appearances)
                assert votes.weight[true_ones(votes, 1, cell, 0.4, scale)].max() == pairs * WHOLE
                checked += 1
    assert checked > 15


def test_what_has_no_angle_or_no_known_type_never_votes():
    _, case, data = a_trial(clouds(), 3)
    plain = list(case.gamma.appearances)
    silent = [replace(a, id=f"{a.id}n", angle=None, uv=(a.uv[0] + 3.0, a.uv[1] + 5.0)) for a in plain]
    unknown = [replace(a, id=f"{a.id}u", type="never seen", uv=(a.uv[0] - 5.0, a.uv[1] + 3.0)) for a in plain]
    first, second = votes_of(clouds(), plain, data.camera), votes_of(clouds(), [*plain, *silent, *unknown], data.camera)
    assert len(first.weight) > 100
    assert all(np.array_equal(getattr(first, name), getattr(second, name)) for name in FIELDS)
    assert not len(votes_of(clouds(), silent, data.camera).weight)
    assert not len(votes_of(clouds(), unknown, data.camera).weight)


@pytest.mark.parametrize("degrees", [0.0, 6.0, 12.0, 16.0])
def test_an_angle_that_is_off_weighs_less(degrees):
    """By a normal density of the noise and of what a cell's width turns.

    To the fineness with which an entry tells its angles.
    """
    ready, step, spread = clouds(), 2.0 * np.pi / FINE, np.hypot(SIGMA, BENT)
    appearances, scale = exact(ready, 2, 40, 1.0, 2)
    turned = [appearances[0], replace(appearances[1], angle=appearances[1].angle + np.radians(degrees))]
    votes = votes_of(ready, turned)
    weight = votes.weight[true_ones(votes, 2, 40, 1.0, scale)].max()
    least, most = (
        WHOLE * np.exp(-0.5 * (off / spread) ** 2)
        for off in (np.radians(degrees) + step, max(0.0, np.radians(degrees) - step))
    )
    assert round(least) <= weight <= round(most)


def test_an_angle_that_is_off_by_so_much_that_it_says_nothing_does_not_vote():
    ready = clouds()
    appearances, scale = exact(ready, 2, 40, 1.0, 2)
    turned = [appearances[0], replace(appearances[1], angle=appearances[1].angle + np.radians(23.0))]
    assert not true_ones(votes_of(ready, turned), 2, 40, 1.0, scale).any()


def test_a_datum_at_another_angle_says_something_else():
    ready = clouds()
    appearances, scale = exact(ready, 2, 40, 1.0, 2)
    turned = [appearances[0], replace(appearances[1], angle=appearances[1].angle + np.pi)]
    assert true_ones(votes_of(ready, appearances), 2, 40, 1.0, scale).any()
    assert not true_ones(votes_of(ready, turned), 2, 40, 1.0, scale).any()


@pytest.mark.parametrize("apart", [NEAREST - 0.5, REACH + 0.5, 0.0])
def test_what_is_too_near_or_too_far_is_no_pair(apart):
    names = clouds().shared.looks
    assert not len(
        votes_of(clouds(), [datum(0, names[0], (300, 200), 0.1), datum(1, names[1], (300 + apart, 200), 0.2)]).weight
    )


@pytest.mark.parametrize("number", [0, 1])
def test_fewer_than_two_data_have_no_votes(number):
    votes = votes_of(clouds(), [datum(i, clouds().shared.looks[0], (300, 200), 0.1) for i in range(number)])
    assert votes.centre.shape == (0, 2)
    assert all(len(getattr(votes, name)) == 0 for name in FIELDS)


@settings(max_examples=15, deadline=None, derandomize=True)
@given(st.integers(0, 4), st.integers(0, 161), st.floats(-3.1, 3.1))
def test_a_right_vote_is_the_pose_that_the_picture_was_made_at(kind, cell, roll):
    ready = clouds()
    appearances, scale = exact(ready, kind, cell, roll)
    votes = votes_of(ready, appearances)
    some = votes.take(np.flatnonzero(true_ones(votes, kind, cell, roll, scale)))
    poses = coarse_poses(ready.shared, some, data_of(appearances, STRAIGHT))
    for pose in poses:
        turned, moved = pose_error(pose, seen_from(ready.rows[kind], cell, roll))
        assert turned < np.radians(2.0)
        assert moved < 0.03 * pose[2, 3]
    assert np.allclose(poses[:, :3, :3] @ np.swapaxes(poses[:, :3, :3], 1, 2), np.eye(3), atol=1e-9)


def test_taking_some_votes_takes_all_that_is_said_of_them():
    votes = votes_of(clouds(), exact(clouds(), 0, 12, 0.5)[0])
    some = votes.take(np.array([3, 1]))
    assert all(np.array_equal(getattr(some, name), getattr(votes, name)[[3, 1]]) for name in FIELDS)
