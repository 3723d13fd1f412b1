"""Pairs by places alone: the way of a Γ whose detector reports no arms (§6.3)."""

from dataclasses import replace

import numpy as np
from synthetic import CAMERA, camera_pose, is_right, perceiver, scene, towers

from geometry.frames import pose_error
from plogic.match.gamma.data import data_of
from plogic.match.hand.correspondences import MOST_PAIRS, open_pairs
from plogic.match.hand.extend import coarse_poses
from plogic.match.hand.generate import generate
from plogic.match.hand.triples import plane_triples
from plogic.match.hand.view_cells import distance_maps


def view(name, seed, clutter=6, distance=(3.0, 6.0), **options):
    rng = np.random.default_rng(seed)
    pose = camera_pose(rng, distance)
    return pose, data_of(scene(rng, {name: pose}, arms=False, clutter=clutter, **options).gamma.appearances, CAMERA)


def pairs_of(name, data, scales=(10.0, 2000.0)):
    index = perceiver().models[name]
    return of_allowed(index, index.allowed(data), data, scales)


def of_allowed(index, allowed, data, scales):
    return open_pairs(index.cells, index.anchors, allowed, data, scales, distance_maps(allowed, data))


def test_a_gamma_without_arms_still_gives_the_right_pose_from_pairs_alone():
    """Without the triples, which patches would give: only pairs of places are left."""
    right = []
    for seed in range(5100, 5106):
        for name in ("t1", "t2"):
            pose, data = view(name, seed, hit=0.95, distance=(3.0, 5.0))
            index = replace(perceiver().models[name])
            vars(index)["triples"] = plane_triples([])
            rows = generate(index, data, towers())
            right.append(bool(rows) and is_right(name, rows[0][1].camera_from_object, pose))
    assert sum(right) >= 11, right


def test_some_pair_is_near_the_true_pose():
    for seed in range(5110, 5114):
        pose, data = view("t2", seed)
        index = perceiver().models["t2"]
        poses = coarse_poses(pairs_of("t2", data), index.cells, data)
        turned = pose_error(poses, np.broadcast_to(pose, poses.shape), index.object_type.symmetries)[0]
        assert np.degrees(turned).min() < 20.0


def test_pairs_are_legal_and_bounded():
    _, data = view("t1", 5115, clutter=60)
    index, allowed = perceiver().models["t1"], perceiver().models["t1"].allowed(data)
    pairs = pairs_of("t1", data, (50.0, 400.0))
    assert 0 < len(pairs.cell) <= MOST_PAIRS
    assert allowed[pairs.feature, pairs.datum].all()
    assert allowed[pairs.other_feature, pairs.other_datum].all()
    assert (pairs.datum != pairs.other_datum).all()
    assert (pairs.feature != pairs.other_feature).all()
    assert index.cells.visible[pairs.cell, pairs.feature].all()
    assert index.cells.visible[pairs.cell, pairs.other_feature].all()
    assert ((pairs.scale > 50.0) & (pairs.scale < 400.0)).all()
    assert np.isin(pairs.feature, index.anchors).all()


def test_the_same_gamma_gives_the_same_pairs():
    _, data = view("t1", 5116)
    one, two = pairs_of("t1", data), pairs_of("t1", data)
    assert np.array_equal(one.cell, two.cell)
    assert np.array_equal(one.roll, two.roll)


def test_nothing_gives_no_pair():
    data = data_of([], CAMERA)
    assert len(pairs_of("t1", data).cell) == 0
    _, data = view("t1", 5117)
    index = perceiver().models["t1"]
    nothing = np.zeros((len(index.points), len(data.ids)), dtype=bool)
    assert len(of_allowed(index, nothing, data, (10.0, 2000.0)).cell) == 0
