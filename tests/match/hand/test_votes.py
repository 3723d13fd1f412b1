"""Votes: how many features of a coarse pose find an appearance of a right type near their place.

Brute force is the oracle.
"""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from synthetic import CAMERA, camera_pose, perceiver, scene

from plogic.match.gamma.data import data_of, project_ideal, viewpoints_of
from plogic.match.hand.distance_maps import distance_maps
from plogic.match.hand.extend import shown
from plogic.match.hand.links import Pairs, linked_pairs, places_of, votes
from plogic.match.hand.place_index import place_index
from plogic.match.hand.place_votes import MISSED, REACH, SHARP, pose_votes
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
    places = place_index([index])
    return places, pose, data, distance_maps(places.allowed(data), data)


@settings(max_examples=15, deadline=None, derandomize=True)
@given(PLACES, st.lists(st.tuples(st.integers(0, 639), st.integers(0, 479)), min_size=1, max_size=5))
def test_maps_tell_the_distance_to_the_nearest_datum_and_which_it_is(places, asked):
    data = data_at(places)
    maps = distance_maps(np.ones((1, len(places)), dtype=bool), data)
    off = np.linalg.norm(np.array(asked, float)[:, None] - data.ideal[None], axis=2)
    distance, datum = maps.look_up(np.array(asked, float)[:, None], np.zeros((len(asked), 1), int))
    assert np.allclose(distance[:, 0], off.min(axis=1), rtol=0.03, atol=0.6), "the 5x5 chamfer is within 2 %"
    assert np.allclose(off[np.arange(len(asked)), datum[:, 0]], off.min(axis=1), rtol=0.05, atol=1.0)


def test_each_feature_sees_only_the_data_it_may_have():
    data = data_at([(10, 10), (600, 400)], ["patch", "l_junction"])
    maps = distance_maps(np.array([[True, False], [False, True], [False, False]]), data)
    distance, datum = maps.look_up(np.full((1, 3, 2), 10.0), np.arange(3)[None])
    assert datum.tolist() == [[0, 1, -1]]
    assert distance[0, 0] == 0.0
    assert distance[0, 1] > 500.0
    assert np.isinf(distance[0, 2])


@pytest.mark.parametrize("place", [(-1.0, 5.0), (640.0, 5.0), (5.0, -3.0), (5.0, 480.0), (-1e6, -1e6)])
def test_outside_the_image_nothing_is_near(place):
    maps = distance_maps(np.ones((1, 1), dtype=bool), data_at([(0, 0)]))
    distance, datum = maps.look_up(np.array([[place]]), np.zeros((1, 1), int))
    assert np.isinf(distance).all()
    assert (datum == -1).all()
    assert np.isinf(maps.seen_at(np.array([[place]]), np.zeros((1, 1), int))[0]).all()


def test_covered_places_are_told():
    covered = np.zeros((480, 640), dtype=bool)
    covered[100:200, 300:400] = True
    maps = distance_maps(np.ones((1, 1), dtype=bool), data_at([(0, 0)]), covered)
    assert maps.is_covered(np.array([[350.0, 150.0], [350.0, 250.0], [-5.0, 150.0]])).tolist() == [True, False, False]


def test_votes_of_pairs_are_the_sum_they_say(view):
    """(N,) Σ weight of visible features by nearness, in units of their whole weight: against a plain loop."""
    places, _, data, maps = view
    index, sets = places.indices[0], places.shown[0]
    pairs = linked_pairs(index.cells, index.links, index.allowed(data), data, (10.0, 2000.0))
    pairs = pairs.take(np.arange(0, len(pairs.cell), max(1, len(pairs.cell) // 20)))
    got = votes(pairs, index.cells, maps, index.weights, data, sets)
    at = places_of(pairs, index.cells, data)
    assert len(got) == len(pairs.cell) >= 20
    for n in range(len(pairs.cell)):
        seen = np.flatnonzero(index.cells.visible[pairs.cell[n]])
        distance = maps.look_up(at[n][None], sets[None])[0][0]
        near = np.maximum(0.0, 1.0 - distance[seen] / (0.10 * index.cells.diameter * pairs.scale[n]))
        assert got[n] == pytest.approx((index.weights[seen] * near).sum() / index.weights[seen].sum(), abs=1e-4)


def test_a_pair_lies_on_its_own_two_data(view):
    places, _, data, _ = view
    index = places.indices[0]
    pairs = linked_pairs(index.cells, index.links, index.allowed(data), data, (10.0, 2000.0))
    at, rows = places_of(pairs, index.cells, data), np.arange(len(pairs.cell))
    assert np.allclose(at[rows, pairs.feature], data.ideal[pairs.datum], atol=0.01)
    assert np.allclose(at[rows, pairs.other_feature], data.ideal[pairs.other_datum], atol=0.05)


def random_poses(pose, number=100):
    rng = np.random.default_rng(7)
    return np.stack([pose, *(camera_pose(rng, (3.0, 6.0)) for _ in range(number))])


def test_the_true_pose_has_more_votes_than_random_ones(view):
    places, pose, data, maps = view
    poses = random_poses(pose)
    worth = pose_votes(places, data, maps, np.zeros(len(poses), int), poses)
    assert worth.argmax() == 0
    assert (worth <= places.visible[0].sum(axis=1).max()).all()


def test_votes_of_poses_are_the_sum_they_say(view):
    """Half of a vote for coming near, half for coming nearer, less what is missed: against a plain loop."""
    places, pose, data, maps = view
    poses, index = random_poses(pose, 20), places.indices[0]
    kind = np.zeros(len(poses), int)
    got, seen = pose_votes(places, data, maps, kind, poses), shown(places, kind, poses, data)
    assert len(got) == 21
    for n in range(len(poses)):
        total = 0.0
        for f in np.flatnonzero(seen.visible[n]):
            at = poses[n, :3, :3] @ index.points[f] + poses[n, :3, 3]
            uv = np.array([at[:2] / at[2] * data.camera.f + (639 / 2, 479 / 2)])
            share = min(1.0, maps.look_up(uv, places.shown[:1, f])[0][0] / (REACH * seen.size[n]))
            total += (1 - share + max(0.0, 1 - SHARP * share)) / 2 * (1 + MISSED) - MISSED
        assert got[n] == pytest.approx(total, abs=0.05)


def test_no_pose_no_vote(view):
    places, _, data, maps = view
    nothing = np.zeros((0, 4, 4))
    assert pose_votes(places, data, maps, np.zeros(0, int), nothing).shape == (0,)
    points = places.indices[0].points
    assert project_ideal(nothing, points, data).shape == (0, len(points), 2)


def test_projection_is_the_cameras(view):
    places, pose, data, _ = view
    points = places.indices[0].points
    at = points @ pose[:3, :3].T + pose[:3, 3]
    assert np.allclose(project_ideal(pose[None], points, data)[0], CAMERA.project(at), atol=0.01)
    assert np.allclose(shown(places, np.zeros(1, int), pose[None], data).places[0], CAMERA.project(at), atol=0.01)


def test_behind_the_camera_is_far_outside(view):
    places, pose, data, _ = view
    behind = pose.copy()
    behind[2, 3] = -5.0
    assert (project_ideal(behind[None], places.indices[0].points, data) < -1e5).all()
    assert (shown(places, np.zeros(1, int), behind[None], data).places < -1e5).all()


def test_a_poses_cell_and_size_are_those_of_its_viewpoint(view):
    places, pose, data, _ = view
    cells = places.indices[0].cells
    assert np.allclose(viewpoints_of(pose[None])[0], -pose[:3, :3].T @ pose[:3, 3])
    there = viewpoints_of(pose[None])[0] - cells.centre
    off = cells.directions @ (there / np.linalg.norm(there))
    assert off[places.cells_of(there[:, None])[0]] == pytest.approx(off.max(), abs=0.02)
    depth = (pose[:3, :3] @ cells.centre + pose[:3, 3])[2]
    size = shown(places, np.zeros(1, int), pose[None], data).size[0]
    assert size == pytest.approx(CAMERA.f * cells.diameter / depth)


def test_pairs_are_taken_by_index():
    pairs = Pairs(*(np.arange(4) for _ in range(5)), np.arange(4.0), np.arange(4.0))
    assert pairs.take(np.array([2, 0])).scale.tolist() == [2.0, 0.0]
