"""SoftPOSIT on random clouds of 1 m, 4 to 9 m away, f = 600 px.

What it finds, what it says when it does not, and its laws.
"""

import numpy as np
import pytest
from softposit_scenes import NEAR, off, right, scene

from geometry.errors import GeometryError
from geometry.frames import from_rotation_translation, is_rigid, pose_error, transform_points
from geometry.poses.softposit import Annealing, random_starts, softposit


def from_near(seed, degrees=10.0, *, typed=False, **kwargs):
    """One start `degrees` and 5 % off.

    The result, whether it is right, and the share of the true matches that it has.
    """
    model, xy, pose, equal, truth, rng = scene(seed, **kwargs)
    found = softposit(model, xy, off(pose, rng, degrees, 0.05), allowed=equal if typed else None, annealing=NEAR)
    return found, right(found, pose)[0], (found.matches[0] == truth)[truth >= 0].mean()


def test_ten_degrees_off_it_finds_the_pose_without_knowing_any_match():
    outcomes = [from_near(seed) for seed in range(30)]  # 50 % clutter, 20 % missed, no types
    found = np.array([good for _, good, _ in outcomes])
    assert found.mean() >= 0.83  # seen: 0.97, and 0.90 over 60 seeds
    assert all(share > 0.9 for _, good, share in outcomes if good)
    counts = np.array([result.count[0] for result, _, _ in outcomes])
    assert counts[found].min() > counts[~found].max()  # the match count tells the two apart; seen: 34 and 19 of 50


def test_types_make_it_sure():
    typed, untyped = ([from_near(seed, 20.0, typed=typed, types=5) for seed in range(12)] for typed in (True, False))
    assert np.mean([good for _, good, _ in typed]) >= max(
        0.95, np.mean([good for _, good, _ in untyped])
    )  # seen: 1 and 0.92
    assert np.mean([share for _, _, share in typed]) > 0.98


def assigned_plainly(S, xy, Q, w, beta, annealing):
    """The paper's softassign as a matrix: m (N, M), without its slack."""
    gamma = 1 / (max(len(S), len(xy)) + 1)
    d2 = (((Q @ S.T).T[:, None] - w[:, None, None] * xy) ** 2).sum(axis=2) / annealing.pixel**2
    m = np.full((len(S) + 1, len(xy) + 1), gamma)
    m[:-1, :-1] = gamma * np.exp(-beta * (d2 - annealing.alpha))
    for _ in range(400):
        m[:-1] /= m[:-1].sum(axis=1, keepdims=True)
        m[:, :-1] /= m[:, :-1].sum(axis=0)
    return m[:-1, :-1]


def plainly(model, xy, start, annealing):
    """The paper's loop for one start, without blocks, pairs or an early end: the pose, and m (N, M) under it."""
    middle = model.mean(axis=0)
    S, R, beta = np.c_[model - middle, np.ones(len(model))], start[:3, :3], annealing.beta
    T = R @ middle + start[:3, 3]
    Q, w = np.c_[R[:2], T[:2]] / T[2], 1 + S[:, :3] @ R[2] / T[2]
    while beta <= annealing.beta_final:
        m = assigned_plainly(S, xy, Q, w, beta, annealing)
        L = np.einsum("k,ka,kb->ab", m.sum(axis=1), S, S)
        Q = np.einsum("kj,k,jx,ka->xa", m, w, xy, S) @ np.linalg.inv(L)
        lengths = np.linalg.norm(Q[:, :3], axis=1)
        scale = np.sqrt(lengths.prod())
        u, _, vt = np.linalg.svd(Q[:, :3] / lengths[:, None], full_matrices=False)  # the nearest orthonormal pair
        R = np.stack([*(u @ vt), np.cross(*(u @ vt))])
        Q, w = np.c_[R[:2] * scale, Q[:, 3]], 1 + S[:, :3] @ R[2] * scale
        beta *= annealing.rate
    pose = from_rotation_translation(R, np.array([*Q[:, 3], 1.0]) / scale - R @ middle)
    return pose, assigned_plainly(S, xy, Q, w, annealing.beta_final, annealing)


@pytest.mark.parametrize("seed", [0, 1, 2])
def test_the_same_pose_and_matches_as_the_papers_loop(seed):
    model, xy, pose, _, _, rng = scene(seed, points=25, noise=0.5)
    annealing = Annealing(beta=2e-3, patience=1000)  # no early end
    start = off(pose, rng, 15, 0.05)
    expected, m = plainly(model, xy, start[0], annealing)
    found = softposit(model, xy, start, annealing=annealing)
    rotation, translation = pose_error(found.camera_from_object[0], expected)
    assert np.degrees(rotation) < 0.02  # Sinkhorn ends at 1e-3
    assert translation < 1e-3
    assert (m > 0.51).sum() >= 4
    assert np.array_equal(found.matches[0], np.where((m > 0.51).any(axis=1), m.argmax(axis=1), -1))


def test_starts_together_end_as_each_would_alone():
    model, xy, pose, equal, _, rng = scene(4, points=30, types=3)
    starts = np.concatenate([off(pose, rng, degrees, 0.05, 2) for degrees in (5, 40, 90, 170)])
    together = softposit(model, xy, starts, allowed=equal)
    assert len(starts) > 4
    for k, start in enumerate(starts):
        alone = softposit(model, xy, start[None], allowed=equal)
        np.testing.assert_allclose(alone.camera_from_object[0], together.camera_from_object[k], atol=1e-9)
        assert np.array_equal(alone.matches[0], together.matches[k])
        assert alone.converged[0] == together.converged[k]


def test_blocks_change_nothing(monkeypatch):
    model, xy, pose, equal, _, rng = scene(5, points=20, types=3)
    starts = off(pose, rng, 30, 0.05, 7)
    whole = softposit(model, xy, starts, allowed=equal)
    monkeypatch.setattr("geometry.poses.softposit.BLOCK", 2 * int(equal.sum()))
    parts = softposit(model, xy, starts, allowed=equal)
    np.testing.assert_allclose(whole.camera_from_object, parts.camera_from_object, atol=1e-9)
    assert np.array_equal(whole.matches, parts.matches)


def test_permuting_the_image_points_permutes_the_matches_only():
    model, xy, pose, equal, _, rng = scene(6, points=30, types=4)
    start, order = off(pose, rng, 15, 0.05, 3), rng.permutation(len(xy))
    found = softposit(model, xy, start, allowed=equal, annealing=NEAR)
    shuffled = softposit(model, xy[order], start, allowed=equal[:, order], annealing=NEAR)
    np.testing.assert_allclose(found.camera_from_object, shuffled.camera_from_object, atol=1e-9)
    assert (found.matches >= 0).any()
    assert np.array_equal(found.matches, np.append(order, -1)[shuffled.matches])


def test_where_the_models_origin_lies_and_its_unit_change_nothing():
    model, xy, pose, equal, _, rng = scene(7, points=30, types=4)
    start = off(pose, rng, 15, 0.05, 3)
    found = softposit(model, xy, start, allowed=equal, annealing=NEAR)
    away = from_rotation_translation(np.eye(3), [3.0, -2.0, 5.0])  # moved_from_object
    moved = softposit(transform_points(away, model), xy, start @ np.linalg.inv(away), allowed=equal, annealing=NEAR)
    np.testing.assert_allclose(moved.camera_from_object @ away, found.camera_from_object, atol=1e-7)
    in_mm = start.copy()
    in_mm[:, :3, 3] *= 1000
    scaled = softposit(model * 1000, xy, in_mm, allowed=equal, annealing=NEAR)
    np.testing.assert_allclose(
        scaled.camera_from_object[:, :3, 3], 1000 * found.camera_from_object[:, :3, 3], atol=1e-6
    )
    assert np.array_equal(scaled.matches, found.matches)
    assert np.array_equal(moved.matches, found.matches)


def test_matches_are_allowed_one_to_one_and_explain_the_error():
    model, xy, pose, equal, _, rng = scene(8, types=3, noise=0.5)
    found = softposit(model, xy, off(pose, rng, 60, 0.2, 20), allowed=equal)
    assert (found.count >= 4).sum() >= 5
    for T, matches, count, error in zip(found.camera_from_object, found.matches, found.count, found.error, strict=True):
        k = np.nonzero(matches >= 0)[0]
        assert len(k) == count == len(set(matches[k]))
        assert equal[k, matches[k]].all()
        placed = transform_points(T, model[k])
        square = ((placed[:, :2] / placed[:, 2:] - xy[matches[k]]) ** 2).sum(axis=1)
        assert error == (pytest.approx(square.mean()) if count else np.inf)


def bad_starts(pose):
    behind, mirrored, torn = (np.array(pose) for _ in range(3))
    behind[:3, 3] *= -1
    mirrored[:3, :3] = np.diag([1.0, 1, -1]) @ mirrored[:3, :3]
    torn[0, 0] = np.nan
    flat, huge, far = np.zeros((4, 4)), np.full((4, 4), 1e300), np.array(pose)
    far[:3, 3] *= 1e200
    return {"behind": behind, "mirrored": mirrored, "nan": torn, "zero": flat, "huge": huge, "far": far}


@pytest.mark.parametrize("which", ["behind", "mirrored", "nan", "zero", "huge", "far"])
def test_a_start_that_is_no_pose_in_front_is_given_up_and_disturbs_no_other(which):
    model, xy, pose, equal, _, _ = scene(9, points=20, types=4)
    found = softposit(model, xy, [pose, bad_starts(pose)[which], pose], allowed=equal, annealing=NEAR)
    assert found.converged.tolist() == [True, False, True]
    assert right(found, pose).tolist() == [True, False, True]
    assert found.count[1] == 0
    assert found.error[1] == np.inf
    assert is_rigid(found.camera_from_object[1])


def test_what_stands_in_for_a_start_that_was_given_up_is_never_taken_for_an_answer():
    model = np.random.default_rng(0).uniform(-0.5, 0.5, (20, 3))
    stand_in = softposit(model, np.zeros((1, 2)), np.zeros((1, 4, 4))).camera_from_object[0]
    placed = transform_points(stand_in, model)
    found = softposit(model, placed[:, :2] / placed[:, 2:], [np.zeros((4, 4)), stand_in], annealing=NEAR)
    assert found.count.tolist() == [0, 20]
    assert found.converged.tolist() == [False, True]


def test_turned_over_starts_end_as_proper_poses_in_front_and_say_that_they_failed():
    model, xy, pose, _, _, rng = scene(10, points=30)
    found = softposit(model, xy, off(pose, rng, 180, 0.5, 20), annealing=NEAR)
    wrong = ~right(found, pose)
    assert wrong.sum() >= 10
    assert np.all(
        ~found.converged[wrong] | (found.count[wrong] <= 16)
    )  # of 30, some 24 seen; seen here: none converged, 14 at most
    assert all(is_rigid(T, tolerance=1e-9) for T in found.camera_from_object)
    assert np.all(transform_points(found.camera_from_object, model.mean(axis=0)[None])[..., 2] > 0)


@pytest.mark.parametrize("seed", range(4))
def test_poses_are_proper_and_in_front_whatever_the_points(seed):
    rng = np.random.default_rng(seed)
    model, xy = rng.normal(size=(6, 3)) * [1, 1, [1, 1e-3, 0, 10][seed]], rng.uniform(-3, 3, (9, 2))
    found = softposit(model, xy, random_starts(model, xy, 40, rng, depth=(0.5, 50)))
    assert all(is_rigid(T, tolerance=1e-9) for T in found.camera_from_object)
    assert np.all(transform_points(found.camera_from_object, model.mean(axis=0)[None])[..., 2] > 0)
    assert np.isfinite(found.error[found.converged]).all()
    assert (found.count[found.converged] >= 4).all()


def test_a_flat_model_fixes_no_pose():
    model, xy, pose, _, _, _ = scene(11, points=20)
    assert not softposit(model * [1, 1, 0], xy, pose[None]).converged.any()


@pytest.mark.parametrize("count", [0, 3])
def test_nothing_in_the_image_and_nothing_allowed(count):
    model, pose = np.random.default_rng(0).uniform(-0.5, 0.5, (7, 3)), from_rotation_translation(np.eye(3), [0, 0, 5])
    starts = np.tile(pose, (count, 1, 1))
    for xy in (np.zeros((0, 2)), np.zeros((4, 2))):
        found = softposit(model, xy, starts, allowed=np.zeros((7, len(xy)), dtype=bool))
        assert not found.converged.any()
        assert found.matches.shape == (count, 7)
        assert np.all(found.matches == -1)
        assert np.all(found.error == np.inf)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"points": np.zeros((5, 2))}, "points must have the shape"),
        ({"points": np.zeros((5, 3))}, "at different places"),
        ({"points": np.full((5, 3), np.nan)}, "must be finite"),
        ({"allowed": np.ones((5, 9), dtype=bool)}, "must agree"),
        ({"start": np.eye(4)}, r"must have the shape \(K, 4, 4\)"),
        ({"annealing": Annealing(rate=1.0)}, "beta must rise"),
        ({"annealing": Annealing(noise=10.0)}, "must be below 100"),
        ({"annealing": Annealing(pixel=0.0)}, "beta must rise"),
    ],
)
def test_what_does_not_fit_is_said(change, message):
    good = {
        "points": np.eye(5, 3),
        "xy": np.zeros((6, 2)),
        "start": np.eye(4)[None],
        "allowed": None,
        "annealing": None,
    }
    arguments = good | change
    with pytest.raises(GeometryError, match=message):
        softposit(arguments.pop("points"), arguments.pop("xy"), arguments.pop("start"), **arguments)


def test_it_can_be_ended_between_two_steps():
    model, xy, pose, _, _, rng = scene(0)
    steps = []

    def check():
        steps.append(1)
        if len(steps) == 3:
            raise TimeoutError

    with pytest.raises(TimeoutError):
        softposit(model, xy, off(pose, rng, 10.0, 0.05), annealing=NEAR, check=check)
    assert len(steps) == 3
