"""Turns of a shape against a cloud.

Those that its texture keeps are found, others are not, and what nobody knows is not written.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from made_meshes import CORNERS, box_triangles
from random_cloud import random_cloud, unit

from geometry.cones import even_directions
from kb.errors import CloudError
from kb.files.schema import SymmetryModel
from kb.learning import symmetry_trials
from kb.learning.observations import Observations
from kb.learning.symmetry_trials import (
    HOLDS,
    LIKELY,
    Trial,
    counterparts,
    entries,
    judged,
    reach_of,
    read_trials,
    share,
    trials,
    trials_bytes,
)
from kb.surfaces.surface import Surface
from kb.surfaces.symmetries import Turn, motions

SIDES = np.array([0.1, 0.1, 0.16])
MIDDLE = np.array([0.3, -0.2, 0.5])
BOX = Surface((CORNERS - 0.5) * SIDES + MIDDLE, box_triangles())
VIEWS = even_directions(6)


def turn_about_z(angle):
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])


def painted(fold, kept=1.0, features=240, seed=0):
    """A cloud on the box's sides that ``fold`` takes onto itself, except the share ``kept`` of its looks."""
    rng = np.random.default_rng(seed)
    some = features // fold
    at = np.column_stack([np.full(some, 0.5), rng.uniform(-0.5, 0.5, (some, 2))]) * SIDES
    axis = unit(np.array([1.0, 0, 0]) + 0.3 * rng.normal(size=(some, 3)))
    up, looks = unit(np.cross(axis, rng.normal(size=(some, 3)))), rng.integers(0, 256, (some, 128), np.uint8)
    turns = [turn_about_z(2 * np.pi * i / fold) for i in range(fold)]
    looks = np.concatenate([looks] * fold)
    own = rng.permutation(features)[: round((1 - kept) * features)]
    looks[own] = rng.integers(0, 256, (len(own), 128), np.uint8)
    noise = rng.normal(0, 2e-4, (features, 3))
    parts = {
        "at": np.concatenate([at @ R.T for R in turns]) + noise + MIDDLE,
        "axis": np.concatenate([axis @ R.T for R in turns]),
    }
    parts |= {
        "up": np.concatenate([up @ R.T for R in turns]),
        "descriptor": looks,
        "half_angle": np.full(features, 1.2),
    }
    parts |= {"feature": np.arange(features), "sigma": np.full(features, 3e-4), "size": np.full(features, 0.01)}
    return random_cloud(seed, features, features, **parts)


def pictures(cloud, seed=1):
    """What a detector would see of the cloud from ``VIEWS``: two in three of what it should, a little off."""
    rng, rows = np.random.default_rng(seed), []
    for view, direction in enumerate(VIEWS):
        held = np.flatnonzero(cloud.axis @ direction >= np.cos(cloud.half_angle))
        rows += [(view, i) for i in held[rng.random(len(held)) < 2 / 3]]
    view, i = np.array(rows).T
    count = len(i)
    at, numbers = cloud.at[i] + rng.normal(0, 2e-4, (count, 3)), np.zeros(count, int)
    return Observations(
        at=at, normal=cloud.axis[i], direction=VIEWS[view], up=cloud.up[i], size=cloud.size[i], pixel=np.full(count, 1e-4), view=view,
        level=numbers, hit=np.ones(count), descriptor=cloud.descriptor[i].astype(np.float32),
    )  # fmt: skip


def verdicts(cloud):
    """Of the trials by the axis of their turns."""
    return {trial.turn.axis: trial for trial in judged(trials(cloud, BOX), cloud, pictures(cloud), VIEWS)}


X, Y, Z = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)


@pytest.mark.parametrize("fold", [2, 4])
def test_the_turns_that_the_texture_keeps_hold_and_no_others(fold):
    found = verdicts(painted(fold))
    assert {axis: trial.verdict for axis, trial in found.items()} == {X: "broken", Y: "broken", Z: "holds"}
    assert found[Z].turn.fold == fold
    assert found[Z].share > 0.9
    assert found[Z].control < 0.05
    (entry,) = entries(list(found.values()))
    assert entry["fold"] == fold
    assert entry["axis"] == pytest.approx(Z, abs=2e-3)
    assert entry["at"][:2] == pytest.approx(MIDDLE[:2], abs=1e-4)


def test_a_texture_without_symmetries_breaks_all_turns_of_the_shape():
    found = verdicts(painted(1))
    assert {trial.verdict for trial in found.values()} == {"broken"}
    assert max(trial.share for trial in found.values()) < 0.02
    assert not any(trial.likely for trial in found.values()), "nobody need look at new pictures"
    assert entries(list(found.values())) == []


def test_a_texture_that_keeps_a_turn_in_part_is_told_and_not_written():
    trial = verdicts(painted(2, kept=0.85))[Z]
    assert trial.verdict == "ambiguous"
    assert LIKELY < trial.share < HOLDS
    assert entries([trial]) == []


def test_random_turns_are_a_control_that_finds_nothing():
    cloud, rng = painted(4), np.random.default_rng(5)
    for _ in range(10):
        quarter, _ = np.linalg.qr(rng.normal(size=(3, 3)))
        move = np.eye(4)
        move[:3, :3] = quarter * np.sign(np.linalg.det(quarter))
        move[:3, 3] = MIDDLE - move[:3, :3] @ MIDDLE
        assert share(cloud, counterparts(cloud, move, reach_of(cloud))[0]) < 0.02
    assert share(cloud, counterparts(cloud, np.eye(4), reach_of(cloud))[0]) == 1.0


def test_a_turn_is_settled_where_the_box_of_the_shape_is_a_little_off():
    cloud = painted(4)
    moved = replace(cloud, at=cloud.at + np.array([0.0015, -0.001, 0]))
    (entry,) = entries(list(verdicts(moved).values()))
    assert entry["at"][:2] == pytest.approx(MIDDLE[:2] + np.array([0.0015, -0.001]), abs=1e-4)


def test_a_cloud_of_nothing_has_no_turns():
    assert trials(random_cloud(0, 0, 0), BOX) == []


def trial(axis, fold, tilt=0.0, **more):
    """A trial whose settled motions are a little tilted."""
    tilted = unit(np.array(axis) + tilt)
    angles = (2 * np.pi / fold,) if fold else (0.6, 1.8)
    moves = []
    for angle in angles:
        K = np.array([[0, -tilted[2], tilted[1]], [tilted[2], 0, -tilted[0]], [-tilted[1], tilted[0], 0]])
        move = np.eye(4)
        move[:3, :3] = np.eye(3) + np.sin(angle) * K + (1 - np.cos(angle)) * K @ K
        move[:3, 3] = MIDDLE - move[:3, :3] @ MIDDLE
        moves.append(move)
    return Trial(Turn(axis, tuple(MIDDLE), fold), tuple(moves), 0.5, 0.0, **{"ratio": 1.0} | more)


def group_of(found):
    return motions([SymmetryModel.model_validate(entry) for entry in entries(found)])


@pytest.mark.parametrize(
    ("found", "count"),
    [
        ([trial(X, 2, 0.01), trial(Y, 2, -0.01), trial(Z, 4, 0.005)], 8),
        ([trial(X, 4, 0.01), trial(Y, 4), trial(Z, 4, 0.005)], 24),
        ([trial(X, 2, 0.01), trial(Z, 0)], 144),
        ([trial(X, 2, ratio=0.7), trial(Z, 2)], 2),
    ],
    ids=["a brick", "a cube", "a can", "one of two"],
)
def test_what_is_written_closes_though_the_axes_were_measured(found, count):
    group = group_of(found)
    assert len(group) == count
    middle = np.append(MIDDLE, 1.0)
    assert np.abs(group @ middle - middle).max() < 1e-5


def test_the_axes_of_a_ball_do_not_close_and_only_the_first_is_written(monkeypatch):
    monkeypatch.setattr(symmetry_trials, "seen_again", lambda *_: 0.5)
    cloud = painted(1)
    found = judged([[trial(axis, 0, ratio=None)] for axis in (X, Y, Z)], cloud, pictures(cloud), VIEWS)
    assert [one.closes for one in found] == [True, False, False]
    assert [one.verdict for one in found] == ["holds", "ambiguous", "ambiguous"]


def test_trials_come_back_from_their_file_and_no_others_do():
    tried = [
        Trial(Turn((0.0, 0.0, 1.0), (0.1, 0.2, 0.3), 0), (np.eye(4), np.eye(4) * 2), 0.3, 0.1, 0.97, closes=False),
        Trial(Turn((0.0, 1.0, 0.0), (0.1, 0.2, 1 / 3), 2), (np.eye(4) / 3,), 0.1, 0.0),
    ]
    for some in (tried, tried[1:], []):
        content = trials_bytes(some)
        found = read_trials(content)
        assert trials_bytes(found) == content
        assert [(str(one.turn), one.verdict, one.ratio, one.closes) for one in found] == [
            (str(one.turn), one.verdict, one.ratio, one.closes) for one in some
        ]
        for i in range(0, len(content), 7):
            with pytest.raises(CloudError):
                read_trials(content[:i] + bytes([content[i] ^ 1 << i % 8]) + content[i + 1 :])
