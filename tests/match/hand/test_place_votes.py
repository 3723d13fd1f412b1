"""Three features and their image give the pose in closed form, up to a reflection (Huttenlocher and Ullman 1990)."""

from __future__ import annotations

from itertools import combinations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from synthetic import CAMERA

from benchmarks.clutter.types import made
from benchmarks.places.scenes import scene
from benchmarks.places.types import places_kb
from benchmarks.recognition.score import HALF, Found, errors_of
from geometry.frames import from_rotation_translation, rotation_angle, rotation_from_quat_xyzw, transform_points
from plogic.match.gamma.data import data_of
from plogic.match.hand.distance_maps import distance_maps
from plogic.match.hand.hand_models import type_index
from plogic.match.hand.place_index import NEIGHBOURS, least_sets, neighbours, permutations, place_index
from plogic.match.hand.place_votes import _poses, _rarest, coarse_poses, image_triples, turn_z_to
from plogic.match.kinds import models_of
from plogic.measures.distinctiveness import distinctiveness, instance_counts
from sensing.appearance import Appearance

RAYS = st.tuples(st.floats(-0.5, 0.5), st.floats(-0.4, 0.4))
QUATERNIONS = st.tuples(*[st.floats(-1.0, 1.0)] * 4).filter(lambda q: np.linalg.norm(q) > 0.2)
LOOKS = "a", "b", "c", "d"
AT = np.array([[0.0, 0.0, 0.0], [0.1, 0.01, 0.0], [0.02, 0.09, 0.03], [-0.05, 0.04, 0.08]])


def glass(looks=LOOKS):
    """A type of four features that are seen from everywhere."""
    return made("glass", None, AT, np.tile(np.eye(3), (4, 1, 1)), looks, np.full(4, np.pi))


def index_of(*kinds):
    return place_index([type_index(kind, distinctiveness(instance_counts(kinds))) for kind in kinds])


def seen(kind, pose):
    rows = zip(kind.features, CAMERA.project(transform_points(pose, AT)), strict=True)
    return data_of([Appearance(f.name, f.type, tuple(map(float, uv)), "drawn") for f, uv in rows], CAMERA)


@settings(max_examples=60, deadline=None, derandomize=True)
@given(RAYS, QUATERNIONS)
def test_of_the_two_poses_of_a_far_triple_one_is_right(place, quaternion):
    """Far away perspective is weak: a triple that is not seen edge on gives the true pose, and its reflection."""
    ray = np.array([*place, 1.0]) / np.linalg.norm([*place, 1.0])
    pose = from_rotation_translation(
        rotation_from_quat_xyzw(np.array(quaternion) / np.linalg.norm(quaternion)), 4.0 * ray
    )
    index, kind = index_of(glass()), glass()
    data = seen(kind, pose)
    image = image_triples(index, data, 12)
    assert len(image.key) <= 4
    for row in range(len(image.key)):
        entry = np.flatnonzero(index.triples.key == image.key[row])
        assert len(entry) == 1
        assert [kind.features[f].name for f in index.triples.features[entry[0]]] == [
            data.ids[i] for i in image.data[row]
        ]
        *_, poses = _poses(index, image, np.array([row]), entry, data)
        if not len(poses):
            continue
        assert len(poses) == 2
        assert np.allclose(poses[:, :3, :3] @ np.swapaxes(poses[:, :3, :3], 1, 2), np.eye(3), atol=1e-4)
        turned = rotation_angle(np.swapaxes(poses[:, :3, :3].astype(float), 1, 2) @ pose[:3, :3])
        assert np.degrees(turned.min()) < 12.0, "of a triple that is seen nearly face on the slant is vague"
        assert np.allclose(poses[turned.argmin(), :3, 3], pose[:3, 3], atol=0.15)


@settings(max_examples=40, deadline=None, derandomize=True)
@given(RAYS)
def test_the_smallest_rotation_takes_the_axis_to_the_ray(place):
    ray = np.array([*place, 1.0]) / np.linalg.norm([*place, 1.0])
    turned = turn_z_to(ray[None])[0]
    assert np.allclose(turned @ [0, 0, 1], ray)
    assert np.allclose(turned @ turned.T, np.eye(3))
    assert rotation_angle(turned) == pytest.approx(np.arccos(ray[2]), abs=1e-6)


@pytest.mark.parametrize(("looks", "orders"), [(LOOKS, 1), (("a", "a", "b", "c"), None), (("a",) * 4, 6)])
def test_a_triple_is_in_the_index_in_every_order_in_which_its_looks_increase(looks, orders):
    index = index_of(glass(looks))
    three = [tuple(row) for row in index.triples.features.tolist()]
    assert len(set(three)) == len(three)
    for some in combinations(range(4), 3):
        ways = [row for row in three if tuple(sorted(row)) == some]
        equal = 3 - len({looks[f] for f in some})
        assert len(ways) == (orders or 1 + equal)
        assert all(list(row) == sorted(row, key=lambda f: looks[f]) for row in map(list, ways))
    assert (np.diff(index.triples.key) >= 0).all()


def test_triples_of_the_index_are_neighbours_in_some_cell_and_one_of_each_family():
    kb = places_kb(12, 1)
    kind = next(kind for kind in kb.types if len(kind.symmetries) > 1)
    cells, points = index_of(kind).indices[0].cells, np.array([f.at for f in kind.features])
    three = neighbours(cells)
    assert len(three) > 100
    for some in three[:: len(three) // 40].tolist():
        assert any(_beside(cells, c, some) for c in np.flatnonzero(cells.visible[:, some].all(axis=1)))
    moves = permutations(points, kind.symmetries)
    kept = {tuple(row) for row in least_sets(three, moves).tolist()}
    assert len(moves) == len(kind.symmetries)
    assert 0 < len(kept) < len(three)
    for row in three:
        family = {tuple(sorted(move[row].tolist())) for move in moves}
        assert len(family & kept) == 1, "symmetries carry it onto one"


def _beside(cells, c, some):
    away = np.linalg.norm(cells.xy[c][:, None] - cells.xy[c], axis=2)
    away[:, ~cells.visible[c]] = np.inf
    reach = np.sort(away, axis=1)[:, min(NEIGHBOURS, len(away) - 1)]
    return any(all(away[f, g] <= reach[f] for g in some) for f in some)


def test_directions_find_their_cells():
    index = index_of(glass())
    ways = np.random.default_rng(0).normal(size=(3, 2000))
    along = index.directions @ (ways / np.linalg.norm(ways, axis=0))
    found = along[index.cells_of(ways), np.arange(2000)]
    assert (found > along.max(axis=0) - 0.03).all()
    assert (index.cells_of(ways) == along.argmax(axis=0)).mean() > 0.9


@settings(max_examples=50, deadline=None, derandomize=True)
@given(st.lists(st.integers(0, 60), max_size=40), st.integers(1, 400))
def test_the_rarest_are_looked_at_whole_and_others_evenly(count, most):
    count = np.array(count, int)
    some = _rarest(count, most)
    assert len(set(some.tolist())) == len(some)
    if count.sum() <= most:
        assert some.tolist() == list(range(len(count)))
    else:
        rare = np.sort(count)[np.cumsum(np.sort(count)) <= most // 2]
        assert np.sort(count[some])[: len(rare)].tolist() == rare.tolist()
        assert count[some].sum() <= most // 2 + most + 60


def test_of_what_is_there_some_coarse_pose_is_near_the_truth():
    kb = places_kb(12)
    index = models_of(kb, distinctiveness(instance_counts(kb.types))).kinds["hand"].places
    near = []
    for seed in range(8):
        gamma, truths = scene(kb, seed)
        data = data_of(gamma.appearances, gamma.camera)
        found = coarse_poses(index, data, distance_maps(index.allowed(data), data), 2000)
        for truth in (t for t in truths if t.fraction >= HALF):
            own = found.poses[[index.indices[k].object_type.name == truth.type for k in found.kind]]
            errors = np.array([errors_of(Found(truth.type, pose.astype(float)), truth) for pose in own[:200]])
            near.append(((errors[:, 0] < np.radians(15.0)) & (errors[:, 1] < 0.15)).any())
    assert len(near) > 8
    assert sum(near) >= len(near) - 1


def test_fewer_than_three_data_make_no_triple():
    index = index_of(glass())
    data = data_of([Appearance(n, n, (9.0 * i, 2.0), "drawn") for i, n in enumerate("ab")], CAMERA)
    assert image_triples(index, data, 12).data.shape == (0, 3)
    nobody = data_of([Appearance(str(i), "z", (9.0 * i, 2.0 * i * i), "drawn") for i in range(5)], CAMERA)
    assert image_triples(index, nobody, 12).data.shape == (0, 3)
