"""What Γ says of poses, softly.

Sights, data and poses one by one are the oracle, and the evidence of the cycle at the noise of the detector.
"""

from dataclasses import replace

import numpy as np
import pytest
from oriented_scenes import EASY, HARD, STRAIGHT, a_trial, clouds, kb_of, picture_of, seen_from

from geometry.camera import Camera
from geometry.frames import inverse, transform_points
from kb.clouds.lobes import in_lobe
from plogic.match.gamma.data import data_of
from plogic.match.gamma.grid import screen_angle
from plogic.match.judged.evidence import evidence
from plogic.match.oriented.asked import chances_of
from plogic.match.oriented.drawn import AS_GOOD, DEVIATIONS, MATCHED, NEAR, WITHIN, by_fours, climbed, drawn, shown
from plogic.match.oriented.oriented_search import turned_about
from plogic.match.oriented.pair_votes import BENT


def posed(seed, detector=EASY):
    """What is asked of a trial, and the true pose, shaken a little, of the right type."""
    ready = clouds(detector=detector)
    which, case, data = a_trial(ready, seed, detector)
    return ready.asked(data), which, case.truth.camera_from_object


def expected(index, pose):
    """(F,) in a lobe of the true viewpoint, and seen from one of the nearest cells.

    Every feature has one appearance.
    """
    viewpoint = inverse(pose)[:3, 3]
    held = in_lobe(index.object_type.lobes, viewpoint[None])[0]
    near = np.argsort(-(index.cells.directions @ (viewpoint - index.cells.centre)))[:NEAR]
    return held & index.cells.visible[near].any(axis=0)


@pytest.mark.parametrize("seed", range(6))
def test_a_pose_shows_what_its_lobes_hold_of_what_cells_beside_it_show(seed):
    asked, which, pose = posed(seed)
    poses, kinds = np.array([pose, pose @ np.diag([-1.0, -1.0, 1.0, 1.0])]), np.array([which, (which + 1) % 5])
    found = shown(asked.index, kinds, poses)
    for row in (0, 1):
        index = asked.index.indices[kinds[row]]
        mine = found.feature[found.pose == row]
        assert sorted(mine.tolist()) == np.flatnonzero(expected(index, poses[row])).tolist()
        assert [asked.index.looks[i] for i in found.looks[found.pose == row]] == [
            index.object_type.lobes.types[f] for f in mine
        ]


def one_by_one(asked, which, pose, share):
    """The evidence of one pose, but for its freedom.

    Σ ln(1 − h + Σ h·N / f), of data each of which serves one sight.
    """
    index, camera = asked.index.indices[which], asked.data.camera
    middle = transform_points(pose, index.cells.centre[None])[0]
    sigma = max(share * index.cells.diameter * camera.f / middle[2] / DEVIATIONS, asked.noise.pixels)
    spread = float(np.hypot(asked.noise.angle, BENT * share / 0.1))
    sights, within = np.flatnonzero(expected(index, pose)), WITHIN if share else MATCHED
    at = transform_points(pose, index.points[sights])
    uv, angle = camera.project(at), screen_angle(index.turns[sights] @ pose[:3, :3].T, at)
    table = np.zeros((len(sights), len(asked.data.ids)))
    hit = [asked.chances.hit[asked.index.feature_types[0].index(index.object_type.features[f].type)] for f in sights]
    for row, f in enumerate(sights):
        name = index.object_type.lobes.types[f]
        look = asked.index.looks.index(name)
        for column, kind in enumerate(asked.data.types):
            off, bent = (
                np.linalg.norm(asked.data.uv[column] - uv[row]),
                np.angle(np.exp(1j * (asked.data.angle[column] - angle[row]))),
            )
            if kind == name and off <= within * sigma and abs(bent) <= within * spread:
                bell = np.exp(-0.5 * ((off / sigma) ** 2 + (bent / spread) ** 2)) / (
                    2.0 * np.pi * sigma**2 * np.sqrt(2.0 * np.pi) * spread
                )
                table[row, column] = hit[row] * bell / (asked.chances.clutter[look] / asked.area / (2.0 * np.pi))
    table[table < table.max(axis=0)] = 0.0  # a datum serves the likeliest
    inside = ((uv >= 0.0) & (uv < [camera.width, camera.height])).all(axis=1)
    missed = 1.0 - np.array(hit)
    total = missed + table.sum(axis=1)
    return float(np.log(total)[inside | (total > missed)].sum()), float((table.sum(axis=1) / total).sum())


@pytest.mark.parametrize("share", [0.0, 0.03, 0.1])
@pytest.mark.parametrize("seed", range(4))
def test_the_evidence_is_that_of_all_sights_one_by_one(seed, share, monkeypatch):
    asked, which, pose = posed(seed)
    monkeypatch.setattr("plogic.match.oriented.drawn._freedom", lambda *_: 0.0)
    poses = np.concatenate([pose[None], turned_about(asked.index, np.array([which]), pose[None], 0.1)[:2]])
    got = drawn(asked, np.full(3, which), poses, share)
    assert len(got.worth) == len(poses) == 3
    for row, one in enumerate(poses):
        worth, likely = one_by_one(asked, which, one, share)
        assert got.worth[row] == pytest.approx(worth, abs=1e-6)
        assert got.likely[row] == pytest.approx(likely, abs=1e-6)


@pytest.mark.parametrize("detector", [EASY, HARD])
def test_at_the_noise_of_the_detector_it_is_the_evidence_of_the_cycle(detector):
    """Where no two data are of one sight: its own sights, its matches, all poses together.

    Rays tell a little else of what is shown than cells do.
    """
    close = []
    for seed in range(12):
        asked, which, pose = posed(seed, detector)
        found = asked.index.indices[which].settle(pose, asked.data, clouds(detector=detector).kb, rounds=2)
        exact = evidence(found, asked.data, clouds(detector=detector).kb).surplus
        close.append(abs(drawn(asked, np.array([which]), found.camera_from_object[None], 0.0).worth[0] - exact))
    assert np.median(close) < 0.05, close
    assert max(close) < 3.0, close


def test_what_is_found_how_often_is_told_by_the_type_of_the_feature_not_by_what_it_looks_like():
    """As the evidence takes it (``plogic.match.judged.evidence.hit_rates``)."""
    kind = clouds().kb.types[0]
    features = tuple(replace(f, type=("often", "rarely", "at_times")[i % 3]) for i, f in enumerate(kind.features))
    ready = kb_of(replace(kind, features=features, all_features=features))
    rates = replace(ready.kb.rates, hit={"often": 0.9, "rarely": 0.2})
    names, number = ready.shared.feature_types
    told = chances_of(ready.shared, rates).hit[number[0]]
    assert names == ("at_times", "often", "rarely")
    assert told.tolist() == [(0.9, 0.2, 0.8)[i % 3] for i in range(len(features))]


def test_poses_do_not_depend_on_each_other():
    asked, which, pose = posed(2)
    poses = turned_about(asked.index, np.array([which]), pose[None], 0.2)
    kinds = (which + np.arange(8)) % 5
    moved, worth, likely = climbed(asked, kinds, poses, 0.05, 3)
    for row in range(8):
        alone = climbed(asked, kinds[row : row + 1], poses[row : row + 1], 0.05, 3)
        assert np.allclose(alone[0][0], moved[row], atol=1e-9)
        assert alone[1][0] == pytest.approx(worth[row], abs=1e-6)
        assert alone[2][0] == pytest.approx(likely[row], abs=1e-6)


@pytest.mark.parametrize("seed", range(6))
def test_climbing_never_makes_a_pose_worse(seed):
    asked, which, pose = posed(seed)
    starts, kinds = turned_about(asked.index, np.array([which]), pose[None], 0.06), np.full(8, which)
    before = drawn(asked, kinds, starts, 0.02).worth
    moved, worth, _ = climbed(asked, kinds, starts, 0.02, 8)
    assert (worth >= before - AS_GOOD).all()
    assert (worth > before).any()
    assert np.allclose(worth, drawn(asked, kinds, moved, 0.02).worth, atol=1e-6)
    assert climbed(asked, kinds, starts, 0.02, 0)[1].tolist() == pytest.approx(before.tolist())


def test_with_less_and_less_noise_it_leads_home():
    """From six degrees off: the evidence of the answer, which starts at nothing, over that from the true pose."""
    reached = []
    for seed in range(10):
        asked, which, pose = posed(seed)
        poses, kinds = turned_about(asked.index, np.array([which]), pose[None], np.radians(6.0)), np.full(8, which)
        assert drawn(asked, kinds, poses, 0.0).worth.max() < 0.7 * climbed(asked, kinds[:1], pose[None], 0.0, 8)[1][0]
        for share in (0.08, 0.04, 0.02, 0.0):
            poses, worth, _ = climbed(asked, kinds, poses, share, 6)
        reached.append(float(np.median(worth)) / climbed(asked, kinds[:1], pose[None], 0.0, 8)[1][0])
    assert np.median(reached) > 0.95, reached


@pytest.mark.parametrize(
    ("K", "dist", "within"),
    [((600.0, 600.0, 350.0, 200.0), (), 0.01), ((606.0, 594.0, 330.0, 250.0), (0.05, -0.02, 1e-3, -5e-4), 0.2)],
    ids=["off its middle", "distorted"],
)
def test_whatever_the_camera_exact_data_lead_to_the_exact_pose(K, dist, within):
    """A lens that distorts turns angles a little."""
    fx, fy, cx, cy = K
    camera = Camera(640, 480, np.array([[fx, 0.0, cx], [0.0, fy, cy], [0.0, 0.0, 1.0]]), np.array(dist))
    index = clouds().rows[0]
    pose = seen_from(index, 30, 0.4)
    data = data_of(picture_of(index, pose, np.flatnonzero(index.cells.visible[30]), camera), camera)
    poses, kinds = turned_about(clouds().shared, np.array([0]), pose[None], np.radians(3.0)), np.zeros(8, np.intp)
    for share in (0.02, 0.005, 0.0):
        poses, _, _ = climbed(clouds().asked(data), kinds, poses, share, 4)
    off = np.linalg.norm(
        camera.project(transform_points(poses[0], index.points)) - camera.project(transform_points(pose, index.points)),
        axis=1,
    )
    assert off.max() < within


def test_nothing_climbs_nowhere():
    asked, _, _ = posed(1)
    moved, worth, likely = climbed(asked, np.zeros(0, np.intp), np.zeros((0, 4, 4)), 0.1, 2)
    assert moved.shape == (0, 4, 4)
    assert len(worth) == len(likely) == 0
    assert len(by_fours(asked, np.zeros(0, np.intp), np.zeros((0, 4, 4)), 0.1)[0]) == 0


def test_without_data_nothing_is_matched_and_all_is_missed():
    asked, which, pose = posed(1)
    got = drawn(replace(asked, data=data_of([], asked.data.camera)), np.array([which]), pose[None], 0.05)
    assert got.likely[0] == 0.0
    assert got.worth[0] < 0.0
    assert (got.held.weight == 0.0).all()


def test_behind_the_camera_nothing_is_matched():
    asked, which, pose = posed(1)
    behind = pose.copy()
    behind[2, 3] *= -1.0
    assert drawn(asked, np.array([which]), behind[None], 0.1).likely[0] == 0.0


def test_four_right_data_among_wrong_ones_lead_home():
    """Six data of its own, and beside each second sight one of its type that is off.

    What draws a pose together leads between; a four does not.
    """
    index = clouds().rows[0]
    pose = seen_from(index, 30, 0.4)
    features = np.flatnonzero(index.cells.visible[30])[::3][:7]
    own = picture_of(index, pose, features)
    wrong = [replace(a, id=f"w{i}", uv=(a.uv[0] + 9.0, a.uv[1] - 7.0)) for i, a in enumerate(own[4:])]
    asked = clouds().asked(data_of([*own[:4], *wrong], STRAIGHT))
    kinds, poses = by_fours(asked, np.array([0]), pose[None], 0.08)
    assert set(kinds.tolist()) == {0}
    assert 1 <= len(poses) <= 35
    off = [
        np.linalg.norm(
            STRAIGHT.project(transform_points(p, index.points[features[:4]])) - [a.uv for a in own[:4]], axis=1
        ).max()
        for p in poses
    ]
    assert min(off) < 0.1
