"""Links: an edge of the cloud on two junctions of Γ whose arms point at each other (§6.3)."""

import numpy as np
import pytest
from synthetic import CAMERA, camera_pose, perceiver, scene

from geometry.frames import pose_error
from plogic.match.gamma.data import data_of
from plogic.match.gamma.grid import wrapped
from plogic.match.hand.links import MOST_PAIRS, coarse_poses, data_links, feature_links, linked_pairs
from sensing.appearance import Appearance

SQUARE = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]])
ALONG = [np.array(SQUARE[[(i + 1) % 4, (i - 1) % 4]] - SQUARE[i]) for i in range(4)]


def junction(name, uv, *arms):
    return Appearance(name, "l_junction", uv, "drawn", arms=tuple(np.mod(arms, 2 * np.pi)))


def test_links_of_a_square_are_its_sides_both_ways_round():
    found = {tuple(pair) for pair in feature_links(SQUARE, ALONG).tolist()}
    assert found == {(i, j) for i in range(4) for j in range(4) if (i - j) % 4 in (1, 3)}


def test_an_edge_ends_at_the_nearest_feature_with_edges():
    points = np.array([[0.0, 0, 0], [1, 0, 0], [2, 0, 0]])
    right, nothing, left = np.array([[1.0, 0, 0]]), np.zeros((0, 3)), np.array([[-1.0, 0, 0]])
    assert feature_links(points, [right, nothing, left]).tolist() == [[0, 2], [2, 0]]
    assert feature_links(points, [right, left, left]).tolist() == [[0, 1], [1, 0], [1, 2], [2, 1]]


def test_features_without_edges_have_no_links():
    assert feature_links(SQUARE, [np.zeros((0, 3))] * 4).shape == (0, 2)


def test_an_arm_links_to_what_it_points_at():
    data = data_of(
        [
            junction("a", (100.0, 100.0), 0.0, 1.57),
            junction("b", (200.0, 101.0), 2.5),
            junction("c", (100.0, 40.0), 3.0),
        ],
        CAMERA,
    )
    links = data_links(data)
    assert list(zip(links.first.tolist(), links.second.tolist(), strict=True)) == [(0, 1)]
    assert links.length[0] == pytest.approx(np.hypot(100, 1))
    assert links.angle[0] == pytest.approx(np.arctan2(1, 100))


def test_a_gamma_without_arms_has_no_links():
    data = data_of([junction("a", (1.0, 1.0)), junction("b", (9.0, 9.0))], CAMERA)
    assert len(data_links(data).first) == 0


@pytest.mark.parametrize("name", ["t1", "t2"])
def test_every_view_has_a_pair_near_the_true_pose(name):
    """Some link of the cloud on some link of Γ gives the pose to a cell's width, in clutter and with misses."""
    index = perceiver().models[name]
    for seed in range(5000, 5006):
        rng = np.random.default_rng(seed)
        pose = camera_pose(rng, (3.0, 6.0))
        data = data_of(scene(rng, {name: pose}).gamma.appearances, CAMERA)
        pairs = linked_pairs(index.cells, index.links, index.allowed(data), data, (10.0, 2000.0))
        assert 0 < len(pairs.cell) <= MOST_PAIRS
        turned = pose_error(
            coarse_poses(pairs, index.cells, data),
            np.broadcast_to(pose, (len(pairs.cell), 4, 4)),
            index.object_type.symmetries,
        )
        assert np.degrees(turned[0]).min() < 20.0


def test_arms_that_do_not_fit_refuse_a_pair():
    """The same junctions with their arms turned by 45° beside the link lose their pairs."""
    index, rng = perceiver().models["t1"], np.random.default_rng(5010)
    pose = camera_pose(rng, (3.0, 5.0))
    shot = scene(rng, {"t1": pose}, hit=1.0, clutter=0, noise=0.0)
    data = data_of(shot.gamma.appearances, CAMERA)
    allowed = index.allowed(data)
    right = linked_pairs(index.cells, index.links, allowed, data, (10.0, 2000.0))
    bent = data_of(
        [
            Appearance(a.id, a.type, a.uv, a.detector, arms=(*a.arms[:1], *(x + np.pi / 4 for x in a.arms[1:])))
            for a in shot.gamma.appearances
        ],
        CAMERA,
    )
    assert len(linked_pairs(index.cells, index.links, allowed, bent, (10.0, 2000.0)).cell) < len(right.cell)


def test_scales_bound_the_pairs():
    index, rng = perceiver().models["t2"], np.random.default_rng(5011)
    data = data_of(scene(rng, {"t2": camera_pose(rng, (3.0, 5.0))}).gamma.appearances, CAMERA)
    pairs = linked_pairs(index.cells, index.links, index.allowed(data), data, (100.0, 200.0))
    assert len(pairs.scale) > 0
    assert ((pairs.scale > 100.0) & (pairs.scale < 200.0)).all()


def test_a_coarse_pose_lays_its_two_features_on_their_two_data():
    """Weak perspective about the object's ray: within a tenth of the object's size in true perspective."""
    index, rng = perceiver().models["t1"], np.random.default_rng(5012)
    data = data_of(scene(rng, {"t1": camera_pose(rng, (6.0, 9.0))}).gamma.appearances, CAMERA)
    pairs = linked_pairs(index.cells, index.links, index.allowed(data), data, (10.0, 300.0))
    poses = coarse_poses(pairs, index.cells, data)
    some = np.arange(0, len(poses), max(1, len(poses) // 50))
    for i in some:
        for f, a in ((pairs.feature[i], pairs.datum[i]), (pairs.other_feature[i], pairs.other_datum[i])):
            at = poses[i] @ np.append(index.points[f], 1.0)
            off = CAMERA.project(at[None, :3])[0] - data.uv[a]
            assert np.linalg.norm(off) < 0.15 * index.cells.diameter * pairs.scale[i]


def test_turn_brings_angles_into_one_round():
    angles = np.linspace(-20, 20, 101)
    assert (np.abs(wrapped(angles)) <= np.pi + 1e-12).all()
    assert np.allclose(np.exp(1j * wrapped(angles)), np.exp(1j * angles))
