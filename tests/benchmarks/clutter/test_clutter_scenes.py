"""The trials of ``plogic bench clutter``: what a Γ holds of its object, and that nothing else tells."""

from __future__ import annotations

import numpy as np
import pytest

from benchmarks.clutter.scenes import CAMERA, MARGIN, PIXELS, PLAN, picture, random_pose, trial, visible
from benchmarks.clutter.types import EASY, HALF_ANGLE, HARD, Detector, made, random_types
from benchmarks.recognition.score import Found, pose_right
from geometry.frames import inverse, transform_points
from plogic.match.gamma.data import data_of
from plogic.match.judged.expectation import pose_of

EXACT = Detector("exact", 1.0, 0.0, 0.0)


@pytest.fixture(scope="module")
def kb():
    return random_types(4, 100, 50, np.random.default_rng(5))


def one(kb, detector=EXACT, seed=0, appearances=200):
    return trial(kb.types[seed % 4], kb, detector, np.random.default_rng(seed), appearances)


def own(posed, kb):
    """(datum, feature) of the object's own data."""
    kind = kb.type(posed.truth.type)
    return [(a, kind.features[posed.causes[a.id]]) for a in posed.gamma.appearances if a.id in posed.causes]


def opened(kind, half_angle):
    """The same type, its features seen from farther aside."""
    features = kind.features
    frames = np.array([f.rotation for f in features])
    return made(
        kind.name,
        kind.surface,
        np.array([f.at for f in features]),
        frames,
        [f.type for f in features],
        np.full(len(features), half_angle),
    )


@pytest.mark.parametrize("seed", range(6))
def test_without_noise_the_data_are_the_projected_features(kb, seed):
    posed = one(kb, seed=seed)
    pose = posed.truth.camera_from_object
    assert len(posed.causes) > 5
    for datum, feature in own(posed, kb):
        at, tip = transform_points(pose, [feature.at, feature.at + 1e-6 * feature.rotation[:, 0]])
        assert datum.uv == pytest.approx(CAMERA.project(at), abs=1e-9)
        step = CAMERA.project(tip) - CAMERA.project(at)
        assert [np.cos(datum.angle), np.sin(datum.angle)] == pytest.approx(step / np.linalg.norm(step), abs=1e-4)
        assert datum.type == feature.appearances[0].type
        assert 0 <= datum.angle < 2 * np.pi


@pytest.mark.parametrize("seed", range(6))
def test_what_shows_is_what_its_lobe_lets_be_seen(kb, seed):
    posed = one(kb, seed=seed)
    kind = kb.type(posed.truth.type)
    view = inverse(posed.truth.camera_from_object)[:3, 3] - kind.lobes.at
    cosine = (view * kind.lobes.axis).sum(axis=1) / np.linalg.norm(view, axis=1)
    assert set(posed.causes.values()) == set(np.flatnonzero(cosine >= np.cos(HALF_ANGLE)))


@pytest.mark.parametrize("seed", range(4))
def test_of_a_convex_body_the_far_side_is_hidden_however_wide_the_lobes(kb, seed):
    kind = opened(kb.types[seed], np.radians(179))
    pose = random_pose(kind, np.random.default_rng(seed))
    view = inverse(pose)[:3, 3] - kind.lobes.at
    facing = (view * kind.lobes.axis).sum(axis=1) / np.linalg.norm(view, axis=1)
    seen = visible(kind, pose, 600.0)
    assert seen[facing > 0.05].all()
    assert not seen[facing < -0.3].any()  # near a rim the sight may pass through less of the body than the tolerance
    assert (facing < -0.3).sum() > 20


def test_the_engine_expects_at_the_true_pose_what_shows(kb):
    posed = one(kb, seed=3)
    data = data_of(posed.gamma.appearances, posed.gamma.camera)
    expected = pose_of(kb.type(posed.truth.type), posed.truth.camera_from_object, data, kb).candidate
    assert set(np.flatnonzero(expected)) == set(posed.causes.values())


def test_sizes_and_places_are_as_promised(kb):
    sizes = []
    for seed in range(60):
        kind = kb.types[seed % 4]
        low, high = picture(kind.surface, random_pose(kind, np.random.default_rng(seed)))
        assert low.min() >= MARGIN
        assert (high <= [639 - MARGIN, 479 - MARGIN]).all()
        sizes.append((high - low).max())
    assert PIXELS[0] - 0.01 <= min(sizes) < 120
    assert 280 < max(sizes) <= PIXELS[1] + 0.01


def test_the_share_detected_and_the_noise_are_the_detectors(kb):
    found, expected, off, turned = 0, 0, [], []
    for seed in range(80):
        exact, noisy = one(kb, seed=seed), one(kb, HARD, seed)
        assert np.array_equal(exact.truth.camera_from_object, noisy.truth.camera_from_object)
        there = {exact.causes[a.id]: a for a, _ in own(exact, kb)}
        found, expected = found + len(noisy.causes), expected + len(there)
        for datum, _ in own(noisy, kb):
            true = there[noisy.causes[datum.id]]
            off += [datum.uv[0] - true.uv[0], datum.uv[1] - true.uv[1]]
            turned.append((datum.angle - true.angle + np.pi) % (2 * np.pi) - np.pi)
    assert found / expected == pytest.approx(HARD.hit, abs=0.04)
    assert np.std(off) == pytest.approx(HARD.sigma, rel=0.08)
    assert np.std(turned) == pytest.approx(HARD.turn, rel=0.1)
    assert abs(np.mean(off)) < 0.2


def test_clutter_makes_up_the_number_and_is_spread_evenly(kb):
    posed = one(kb, EASY, appearances=1000)
    assert len(posed.gamma.appearances) == 1000
    clutter = [a for a in posed.gamma.appearances if a.id not in posed.causes]
    uv = np.array([a.uv for a in clutter])
    assert posed.gamma.camera.contains(posed.gamma.uv).all()
    assert np.histogram2d(*uv.T, bins=(4, 3), range=((0, 640), (0, 480)))[0].min() > 45
    assert np.histogram([a.angle for a in clutter], 4, (0, 2 * np.pi))[0].min() > 180
    assert {a.type for a in clutter} == set(kb.appearance_types)


def test_neither_ids_nor_order_tell_whose_a_datum_is(kb):
    ranks = []
    for seed in range(20):
        posed = one(kb, EASY, seed, 1000)
        ids = [a.id for a in posed.gamma.appearances]
        assert ids == [f"d{n}" for n in range(1000)]
        ranks += [int(name[1:]) for name in posed.causes]
    assert np.histogram(ranks, 4, (0, 1000))[0].min() > 0.15 * len(ranks)


def test_a_seed_gives_one_trial_and_another_another(kb):
    first, again, other = one(kb, EASY, 1), one(kb, EASY, 1), one(kb, EASY, 5)
    assert first.gamma.appearances == again.gamma.appearances
    assert first.causes == again.causes
    assert first.gamma.appearances != other.gamma.appearances


def test_the_truth_is_right_by_the_score_and_its_neighbours_are_not(kb):
    truth = one(kb).truth
    assert pose_right(Found(truth.type, truth.camera_from_object), truth)
    farther = truth.camera_from_object.copy()
    farther[:3, 3] *= 1.06
    assert not pose_right(Found(truth.type, farther), truth)


def test_the_plan_is_the_issue_s():
    assert {(c.detector.name, c.types, c.appearance_types) for c in PLAN} == {
        ("easy", 100, 300), ("easy", 100, 100), ("hard", 100, 300), ("hard", 100, 100), ("easy", 1000, 300), ("easy", 1000, 100),
    }  # fmt: skip
    assert {(c.features, c.appearances) for c in PLAN} == {(100, 1000)}
    assert (EASY.hit, EASY.sigma, round(np.degrees(EASY.turn))) == (0.6, 1, 5)
    assert (HARD.hit, HARD.sigma, round(np.degrees(HARD.turn))) == (0.35, 2, 12)
