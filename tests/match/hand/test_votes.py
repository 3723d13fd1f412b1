"""Votes: how many features of a coarse pose find an appearance of a right type near their place.

Brute force is the oracle.
"""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from synthetic import CAMERA, camera_pose, perceiver, scene

from plogic.match.gamma.data import data_of, project_ideal, viewpoints_of
from plogic.match.hand.correspondences import Pairs, linked_pairs, places_of, votes
from plogic.match.hand.view_cells import best_apart, distance_maps, pose_votes, seen_cells, sizes
from sensing.appearance import Appearance

PLACES = st.lists(st.tuples(st.integers(0, 639), st.integers(0, 479)), min_size=1, max_size=6, unique=True)


def data_at(places, kinds=None):
    kinds = kinds or ["patch"] * len(places)
    rows = enumerate(zip(places, kinds, strict=True))
    return data_of([Appearance(f"a{i}", kind, tuple(map(float, uv)), "drawn") for i, (uv, kind) in rows], CAMERA)


@pytest.fixture(scope="module")
def view():
    index, rng = perceiver().models["t1"], np.random.default_rng(5030)
    pose = camera_pose(rng, (4.0, 5.0))
    data = data_of(scene(rng, {"t1": pose}, clutter=8).gamma.appearances, CAMERA)
    return index, pose, data, distance_maps(index.allowed(data), data)


@settings(max_examples=15, deadline=None, derandomize=True)
@given(PLACES, st.lists(st.tuples(st.integers(0, 639), st.integers(0, 479)), min_size=1, max_size=5))
def test_maps_tell_the_distance_to_the_nearest_datum_and_which_it_is(places, asked):
    data = data_at(places)
    maps = distance_maps(np.ones((1, len(places)), dtype=bool), data)
    off = np.linalg.norm(np.array(asked, float)[:, None] - data.ideal[None], axis=2)
    distance, datum = maps.look_up(np.array(asked, float)[:, None])
    assert np.allclose(distance[:, 0], off.min(axis=1), rtol=0.03, atol=0.6), "the 5x5 chamfer is within 2 %"
    assert np.allclose(off[np.arange(len(asked)), datum[:, 0]], off.min(axis=1), rtol=0.05, atol=1.0)


def test_each_feature_sees_only_the_data_it_may_have():
    data = data_at([(10, 10), (600, 400)], ["patch", "l_junction"])
    maps = distance_maps(np.array([[True, False], [False, True], [False, False]]), data)
    distance, datum = maps.look_up(np.full((1, 3, 2), 10.0))
    assert datum.tolist() == [[0, 1, -1]]
    assert distance[0, 0] == 0.0
    assert distance[0, 1] > 500.0
    assert np.isinf(distance[0, 2])


@pytest.mark.parametrize("place", [(-1.0, 5.0), (640.0, 5.0), (5.0, -3.0), (5.0, 480.0), (-1e6, -1e6)])
def test_outside_the_image_nothing_is_near(place):
    maps = distance_maps(np.ones((1, 1), dtype=bool), data_at([(0, 0)]))
    distance, datum = maps.look_up(np.array([[place]]))
    assert np.isinf(distance).all()
    assert (datum == -1).all()
    assert np.isinf(maps.seen_at(np.array([[place]]))[0]).all()


def test_covered_places_are_told():
    covered = np.zeros((480, 640), dtype=bool)
    covered[100:200, 300:400] = True
    maps = distance_maps(np.ones((1, 1), dtype=bool), data_at([(0, 0)]), covered)
    assert maps.is_covered(np.array([[350.0, 150.0], [350.0, 250.0], [-5.0, 150.0]])).tolist() == [True, False, False]


def test_votes_of_pairs_are_the_sum_they_say(view):
    """(N,) Σ weight of visible features by nearness, in units of their whole weight: against a plain loop."""
    index, _, data, maps = view
    pairs = linked_pairs(index.cells, index.links, index.allowed(data), data, (10.0, 2000.0))
    pairs = pairs.take(np.arange(0, len(pairs.cell), max(1, len(pairs.cell) // 20)))
    got = votes(pairs, index.cells, maps, index.weights, data)
    places = places_of(pairs, index.cells, data)
    assert len(got) == len(pairs.cell) >= 20
    for n in range(len(pairs.cell)):
        seen = np.flatnonzero(index.cells.visible[pairs.cell[n]])
        distance = maps.look_up(places[n][None])[0][0]
        near = np.maximum(0.0, 1.0 - distance[seen] / (0.10 * index.cells.diameter * pairs.scale[n]))
        assert got[n] == pytest.approx((index.weights[seen] * near).sum() / index.weights[seen].sum(), abs=1e-4)


def test_a_pair_lies_on_its_own_two_data(view):
    index, _, data, _ = view
    pairs = linked_pairs(index.cells, index.links, index.allowed(data), data, (10.0, 2000.0))
    places, rows = places_of(pairs, index.cells, data), np.arange(len(pairs.cell))
    assert np.allclose(places[rows, pairs.feature], data.ideal[pairs.datum], atol=0.01)
    assert np.allclose(places[rows, pairs.other_feature], data.ideal[pairs.other_datum], atol=0.05)


def test_the_true_pose_has_more_votes_than_random_ones(view):
    index, pose, data, maps = view
    rng = np.random.default_rng(7)
    poses = np.stack([pose, *(camera_pose(rng, (3.0, 6.0)) for _ in range(100))])
    worth = pose_votes(poses, index.cells, index.points, index.weights, maps, data)
    assert worth.argmax() == 0
    assert ((worth >= 0) & (worth <= 1 + 1e-6)).all()


def test_no_pose_no_vote(view):
    index, _, data, maps = view
    nothing = np.zeros((0, 4, 4))
    assert pose_votes(nothing, index.cells, index.points, index.weights, maps, data).shape == (0,)
    assert project_ideal(nothing, index.points, data).shape == (0, len(index.points), 2)
    assert best_apart(np.zeros(0), nothing, index.cells, data, 5).tolist() == []


def test_projection_is_the_cameras(view):
    index, pose, data, _ = view
    at = index.points @ pose[:3, :3].T + pose[:3, 3]
    assert np.allclose(project_ideal(pose[None], index.points, data)[0], CAMERA.project(at), atol=0.01)


def test_behind_the_camera_is_far_outside(view):
    index, pose, data, _ = view
    behind = pose.copy()
    behind[2, 3] = -5.0
    assert (project_ideal(behind[None], index.points, data) < -1e5).all()


def test_a_poses_cell_and_size_are_those_of_its_viewpoint(view):
    index, pose, _, _ = view
    assert np.allclose(viewpoints_of(pose[None])[0], -pose[:3, :3].T @ pose[:3, 3])
    there = viewpoints_of(pose[None])[0] - index.cells.centre
    off = index.cells.directions @ (there / np.linalg.norm(there))
    assert seen_cells(pose[None], index.cells)[0] == off.argmax()
    depth = (pose[:3, :3] @ index.cells.centre + pose[:3, 3])[2]
    assert sizes(pose[None], index.cells, 600.0)[0] == pytest.approx(600 * index.cells.diameter / depth)


def test_of_poses_alike_one_is_kept_the_best(view):
    index, pose, data, _ = view
    beside = pose.copy()
    beside[0, 3] += 0.01
    elsewhere = pose.copy()
    elsewhere[0, 3] += 1.0
    kept = best_apart(np.array([0.5, 0.9, 0.7]), np.stack([pose, beside, elsewhere]), index.cells, data, 10)
    assert kept.tolist() == [1, 2]
    assert best_apart(
        np.array([0.5, 0.9, 0.7]), np.stack([pose, beside, elsewhere]), index.cells, data, 1
    ).tolist() == [1]


def test_pairs_are_taken_by_index():
    pairs = Pairs(*(np.arange(4) for _ in range(5)), np.arange(4.0), np.arange(4.0))
    assert pairs.take(np.array([2, 0])).scale.tolist() == [2.0, 0.0]
