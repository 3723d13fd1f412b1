"""Δh of all types at once: the right pose comes first, and what does not matter changes nothing."""

import warnings
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from oriented_scenes import STRAIGHT, Ready, a_trial, clouds, datum, off, picture_of, seen_from

from benchmarks.clutter.scenes import CAMERA
from benchmarks.clutter.types import HARD
from geometry.camera import Camera
from geometry.frames import is_rigid, pose_error
from plogic.match.gamma.data import data_of
from plogic.match.oriented.oriented_search import Search
from plogic.match.oriented.pair_index import pair_index

QUARTER = np.array([[0.0, -1.0, 0.0, 0.0], [1.0, 0.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 0.0, 1.0]])
"""A quarter turn clockwise on the screen: x to y."""
SEEDS = range(10)


@cache
def answers(seed):
    """Of one easy trial."""
    _, _, data = a_trial(clouds(), seed)
    return clouds().proposals(data)


def little():
    """Fewer and smaller types among fewer data: for what does not depend on how many there are."""
    return clouds(count=3, features=60, appearances=120)


def small_trial(seed):
    return a_trial(little(), seed, appearances=120)


@cache
def small_answers(seed):
    return little().proposals(small_trial(seed)[2])


def alike(one, other, tolerance=1e-6):
    """Whether two answers are of the same types at the same poses, in the same order."""
    same = [a.kind == b.kind and np.abs(a.pose - b.pose).max() < tolerance for a, b in zip(one, other, strict=False)]
    return len(one) == len(other) and all(same)


def test_the_right_pose_comes_first():
    """Of a hundred features sixteen or so are seen, a pixel off, among 200 data of 30 kinds.

    Within 5 degrees and 5 %, nearly always.
    """
    errors = []
    for seed in range(30):
        _, case, _ = a_trial(clouds(), seed)
        errors.append(off(clouds(), answers(seed)[0], case))
    right = [turned < np.radians(10.0) and moved < 0.06 for turned, moved in errors]
    close = [turned < np.radians(5.0) and moved < 0.05 for turned, moved in errors]
    assert sum(right) >= 27, errors
    assert sum(close) >= 22, errors


def test_answers_are_rigid_poses_of_finite_worth_the_best_first():
    for seed in SEEDS:
        worths = [found.worth for found in answers(seed)]
        assert worths == sorted(worths, reverse=True)
        assert np.isfinite(worths).all()
        assert all(is_rigid(found.pose) and 0 <= found.kind < 5 for found in answers(seed))
        assert worths, seed


def test_no_two_answers_of_a_type_are_alike():
    assert sum(len(answers(seed)) for seed in SEEDS) > len(SEEDS), "there are pairs"
    for seed in SEEDS:
        found = answers(seed)
        for i, one in enumerate(found):
            for other in (b for b in found[:i] if b.kind == one.kind):
                turned, moved = pose_error(one.pose, other.pose)
                assert turned > np.radians(5.0) or moved > 0.02 * other.pose[2, 3]


def test_an_exact_picture_is_answered_exactly():
    """Every other visible feature of one object and nothing else; no noise."""
    for kind, cell in ((0, 10), (1, 77), (3, 140)):
        index = clouds().rows[kind]
        pose = seen_from(index, cell, 0.7)
        features = np.flatnonzero(index.cells.visible[cell])[::2]
        best = clouds().proposals(data_of(picture_of(index, pose, features), STRAIGHT))[0]
        assert best.kind == kind
        assert np.allclose(best.pose, pose, atol=1e-4)


@pytest.mark.parametrize("seed", SEEDS)
def test_the_order_of_the_data_does_not_matter(seed):
    _, case, _ = small_trial(seed)
    data = case.gamma.appearances
    assert small_answers(seed)
    for order in (np.arange(len(data))[::-1], np.random.default_rng(seed).permutation(len(data))):
        found = little().proposals(data_of([data[i] for i in order], case.gamma.camera))
        assert alike(found, small_answers(seed))


@pytest.mark.parametrize("seed", [0, 8, 11])
def test_nor_where_much_is_missed_and_far_off(seed):
    hard = clouds(detector=HARD)
    _, case, data = a_trial(hard, seed, HARD)
    order = np.random.default_rng(seed).permutation(len(data.ids))
    other = hard.proposals(data_of([case.gamma.appearances[i] for i in order], case.gamma.camera))
    assert alike(other, hard.proposals(data), 1e-9)


@pytest.mark.parametrize("seed", SEEDS)
def test_the_order_of_the_types_changes_their_numbers_alone(seed):
    rows = little().rows
    assert small_answers(seed)
    for order in (np.arange(3)[::-1], np.random.default_rng(seed).permutation(3)):
        ready = Ready(little().kb)
        ready.__dict__["shared"] = pair_index([rows[i] for i in order])
        renamed = [found._replace(kind=int(order[found.kind])) for found in ready.proposals(small_trial(seed)[2])]
        assert alike(renamed, small_answers(seed))


def turned(appearances, camera):
    """The image turned clockwise by a quarter: what was up is to the right."""
    K, H, W = camera.K, camera.height, camera.width
    rotated = Camera(H, W, np.array([[K[1, 1], 0.0, H - 1 - K[1, 2]], [0.0, K[0, 0], K[0, 2]], [0.0, 0.0, 1.0]]))
    new = [replace(a, uv=(H - 1 - a.uv[1], a.uv[0]), angle=(a.angle + np.pi / 2) % (2.0 * np.pi)) for a in appearances]
    return data_of(new, rotated)


@pytest.mark.parametrize("seed", SEEDS)
def test_a_camera_turned_in_its_plane_turns_the_best_answer(seed):
    _, case, _ = small_trial(seed)
    best, other = small_answers(seed)[0], little().proposals(turned(case.gamma.appearances, case.gamma.camera))[0]
    assert other.kind == best.kind
    assert np.allclose(other.pose, QUARTER @ best.pose, atol=1e-6)
    assert other.worth == pytest.approx(best.worth, rel=1e-5)


@pytest.mark.parametrize("seed", SEEDS)
def test_clutter_of_unknown_types_and_without_angles_changes_nothing(seed):
    _, case, _ = small_trial(seed)
    rng, names = np.random.default_rng(seed), little().shared.looks
    places, angles = rng.uniform(0.0, 479.0, (120, 2)), rng.uniform(0.0, 6.28, 120)
    more = [
        datum(1000 + i, "unknown" if i % 2 else names[i % 30], uv, angles[i] if i % 2 else None)
        for i, uv in enumerate(places)
    ]
    found = little().proposals(data_of([*case.gamma.appearances, *more], case.gamma.camera))
    assert small_answers(seed)
    assert alike(found, small_answers(seed), 1e-12)


@pytest.mark.parametrize("seed", [0, 3, 4])
def test_whole_turns_of_an_angle_say_the_same(seed):
    _, _, data = a_trial(clouds(), seed)
    more = replace(data, angle=data.angle + 2.0 * np.pi * np.random.default_rng(seed).integers(-2, 3, len(data.angle)))
    assert alike(clouds().proposals(more), answers(seed))


def few(which):
    names = clouds().shared.looks
    places = {
        "none": [],
        "one": [(100, 100)],
        "three": [(100, 100), (120, 110), (130, 90)],
        "all at one place": [(200, 150)] * 40,
        "in a row": [(100 + 5 * i, 100) for i in range(40)],
        "outside": [(-500 + 10 * i, 2000) for i in range(12)],
    }[which]
    return [datum(i, names[i % len(names)], uv, 0.3 * i) for i, uv in enumerate(places)]


@pytest.mark.parametrize("which", ["none", "one", "three", "all at one place", "in a row", "outside"])
def test_little_or_odd_data_do_no_harm(which):
    data = data_of(few(which), CAMERA)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        found = clouds().proposals(data)
        together = clouds().together(data)
    assert all(np.isfinite(some.worth) and is_rigid(some.pose) for some in found)
    assert list(together) == ([kind.name for kind in clouds().kb.types] if which != "none" else [])
    if which not in {"in a row", "outside"}:
        assert found == []
        assert not any(together.values())


def test_alone_the_data_of_unknown_types_and_without_angles_say_nothing():
    _, case, _ = a_trial(clouds(), 1)
    silent = [replace(a, angle=None) for a in case.gamma.appearances]
    unknown = [replace(a, type="unknown") for a in case.gamma.appearances]
    assert clouds().proposals(data_of(silent, CAMERA)) == clouds().proposals(data_of(unknown, CAMERA)) == []
    assert clouds().together(data_of(silent, CAMERA)) == {}, "each type is searched for as without angles"


def test_together_each_type_has_its_own_poses_best_first():
    """The true type's best hypothesis is the best of all, and is where the object is."""
    for seed in SEEDS:
        _, case, data = a_trial(clouds(), seed)
        together = clouds().together(data)
        for name, rows in together.items():
            ratios = [ratio for ratio, _ in rows]
            assert ratios == sorted(ratios, reverse=True)
            assert all(posed.object_type.name == name for _, posed in rows)
        best = max((row for rows in together.values() for row in rows), key=lambda row: row[0])[1]
        assert best.object_type.name == case.truth.type
        turned_by, moved = pose_error(best.camera_from_object, case.truth.camera_from_object)
        assert turned_by < np.radians(12.0)
        assert moved < 0.08 * case.truth.camera_from_object[2, 3]


def test_what_accepted_objects_hide_counts_for_nothing():
    """The true object, wholly hidden, is not among the hypotheses."""
    _, _, data = a_trial(clouds(), 4)
    assert any(clouds().together(data, lambda posed: np.zeros(len(posed.uv), bool)).values())
    assert not any(clouds().together(data, lambda posed: np.ones(len(posed.uv), bool)).values())


def test_what_is_claimed_is_no_longer_counted():
    """A search that goes on with some of the data finds what a new one with those alone finds.

    Its own pairs are left out of the votes.
    """
    assert all(answers(seed) for seed in SEEDS[:3])
    assert len(SEEDS) >= 3
    for seed in SEEDS[:3]:
        _, case, data = a_trial(clouds(), seed)
        others = [a for a in case.gamma.appearances if a.id not in case.causes]
        left = data.only(np.array([a in others for a in case.gamma.appearances]))
        search = Search(clouds().asked(data))
        assert alike(search.proposals(data), answers(seed))
        assert alike(search.proposals(left), clouds().proposals(data_of(others, CAMERA)))
