"""The gate of distinction: the most distinctive features are owed only where any of them is expected."""

from __future__ import annotations

import numpy as np
import pytest
from book_kb import write_book
from synthetic import CAMERA

from geometry.frames import look_at, pose_error
from kb.files.read import read_kb
from plogic.cycle.judging import FEWEST, judge, refusal
from plogic.cycle.perception import perceive
from plogic.cycle.state import State, Task
from plogic.match.gamma.data import data_of
from plogic.match.judged.expectation import pose_of
from plogic.run.perceive import Perceiver
from sensing.appearance import Appearance

BEHIND, BEFORE = np.array([0.35, 1.0, 0.3]), np.array([0.35, -1.0, 0.3])


@pytest.fixture(scope="module")
def ready(tmp_path_factory):
    return Perceiver(read_kb(write_book(tmp_path_factory.mktemp("library"))))


def task_from(ready, eye, left_out=""):
    """What the book shows from a place, and its pose; ``left_out``: the feature type that no detector reports."""
    pose = look_at(eye, np.zeros(3))
    kind = ready.kb.type("book")
    seen = pose_of(kind, pose, data_of((), CAMERA, 128), ready.kb)
    shown = [f for f in np.flatnonzero(seen.candidate) if kind.seen_features[f].type != left_out]
    noise = np.random.default_rng(0).normal(0.0, 0.3, (len(shown), 2))
    rows = [
        Appearance(f"a{i}", kind.seen_features[f].type, tuple(seen.uv[f] + off), "mine")
        for i, (f, off) in enumerate(zip(shown, noise, strict=True), 1)
    ]
    return Task(data_of(rows, CAMERA), ready.kb, ready.models, ready.dv, None), pose


def test_a_book_from_behind_does_not_owe_its_letters(ready):
    task, pose = task_from(ready, BEHIND)
    (book,) = perceive(task).accepted
    letters = [f.type == "letter" for f in ready.kb.type("book").seen_features]
    assert sum(letters) == 4
    assert not book.candidate[letters].any(), "none of them is expected from there"
    turn, shift = pose_error(book.camera_from_object, pose, ready.kb.type("book").symmetries)
    assert np.degrees(turn) < 3.0
    assert shift < 0.02


def test_from_before_it_owes_one(ready):
    task, _ = task_from(ready, BEFORE)
    assert [h.type for h in perceive(task).accepted] == ["book"]
    without, pose = task_from(ready, BEFORE, left_out="letter")
    there = judge(without, (), ready.models["book"].settle(pose, without.data, ready.kb, rounds=0), 0)
    assert (there.candidate & there.detected).sum() >= FEWEST
    assert refusal(without, State(), there) == "none of its most distinctive features was detected"
    assert not perceive(without).accepted
