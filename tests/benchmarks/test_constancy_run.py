"""``plogic bench constancy`` end to end on few sequences; the scenes; the scores; the peer."""

from __future__ import annotations

import json

import numpy as np
import pytest

from benchmarks.constancy.bench import run
from benchmarks.constancy.peers import epipolar
from benchmarks.constancy.scenes import constancy_kb, sequence
from benchmarks.constancy.score import Called, Score, score
from geometry.frames import inverse

SEED = 5_000


@pytest.fixture(scope="module")
def kb():
    return constancy_kb(7)


@pytest.fixture(scope="module")
def moved(kb):
    return sequence(kb, SEED, 3)


def test_a_real_run_calls_features_physical_and_clutter_noise():
    said = []
    text, _ = run(seed=50, quick=True, as_json=True, say=said.append, sequences=1)
    document = json.loads(text)
    rows = {(row["views"], row["who"]): row for row in document["rows"]}
    assert set(rows) == {(n, who) for n in (2, 3, 4, 5) for who in ("ours", "one look", "no angles", "epipolar")}
    assert rows[3, "ours"]["physical"] > 0.85
    assert rows[3, "ours"]["noise"] > 0.85
    assert rows[3, "ours"]["precise"] >= rows[3, "epipolar"]["precise"]
    assert [claim["bar"] for claim in document["claims"]] == [">= 0.9", ">= 0.95", "<= 1"]
    assert [line.split(":")[0] for line in said] == ["sequence 2000"]


def test_the_same_seed_gives_the_same_sequence(kb, moved):
    again = sequence(kb, SEED, 3)
    assert [v.gamma.appearances for v in again.views] == [v.gamma.appearances for v in moved.views]
    assert again.causes == moved.causes


def test_what_is_seen_can_be_seen(kb, moved):
    """Causes are visible features; no cause has two data in a view (§3.3); misses and clutter are there."""
    assert len(moved.views) > 1
    for view in moved.views:
        causes = list(moved.causes[view.id].values())
        assert len(causes) > 10
        assert len(set(causes)) == len(causes)
        assert set(causes) < moved.visible[view.id]
        assert len(view.gamma.appearances) > len(causes) + 10


def test_cameras_move_on_a_ring(moved):
    eyes = np.array([view.world_from_camera[:3, 3] for view in moved.views])
    steps = np.linalg.norm(np.diff(eyes, axis=0), axis=1)
    assert ((steps > 0.1) & (steps < 0.8)).all()
    assert all(inverse(view.world_from_camera)[2, 3] > 0.5 for view in moved.views)


def perfect(moved):
    """What the truth would call."""
    rows = {}
    for view in moved.views:
        for name, cause in moved.causes[view.id].items():
            if not moved.known[cause.object]:
                rows.setdefault(cause, {})[view.id] = name
    twice = [(cause, row) for cause, row in rows.items() if len(row) > 1]
    objects = tuple(
        tuple(i for i, (c, _) in enumerate(twice) if c.object == which) for which in {c.object for c, _ in twice}
    )
    noise = {v.id: frozenset(a.id for a in v.gamma.appearances if a.id not in moved.causes[v.id]) for v in moved.views}
    return Called(tuple(row for _, row in twice), objects, noise, {})


def test_the_truth_scores_full_marks(moved):
    s = score(moved, 3, perfect(moved))
    assert s.found == s.twice == s.called == s.right > 0
    assert s.noise == s.clutter == s.called_noise > 0
    assert s.whole == s.bodies > 0
    assert s.visible > s.twice


def test_nothing_called_scores_nothing_and_a_mixture_is_wrong(moved):
    nothing = score(moved, 3, Called((), (), {}, {}))
    assert (nothing.found, nothing.called, nothing.noise) == (0, 0, 0)
    truth = perfect(moved)
    mixed = truth._replace(
        physical=({**truth.physical[0], **dict(list(truth.physical[1].items())[:1])}, *truth.physical[2:]), objects=()
    )
    assert score(moved, 3, mixed).right <= len(mixed.physical)
    assert score(moved, 3, mixed).found < score(moved, 3, truth).found
    assert Score(1, 2) + Score(3, 4) == Score(4, 6)


def test_the_peer_uses_a_datum_once_a_pair(kb, moved):
    views = moved.views[:2]
    called = epipolar(views, {v.id: [a.id for a in v.gamma.appearances] for v in views}, kb.rates)
    assert len(views) == 2
    for view in views:
        used = [row[view.id] for row in called.physical]
        assert len(used) > 10
        assert len(set(used)) == len(used)
        assert not set(used) & called.noise[view.id]
