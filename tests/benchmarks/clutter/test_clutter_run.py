"""``plogic bench clutter`` end to end, on few types and little clutter."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest
from learned_cube import learned_kb

from benchmarks.clutter import bench as clutter
from benchmarks.clutter.bench import Plan, run, series_of
from benchmarks.clutter.peers import Peer
from benchmarks.clutter.scenes import PLAN, Case
from benchmarks.clutter.types import EASY, HARD, Detector
from benchmarks.recognition import scenes as recognition_scenes
from benchmarks.recognition.score import Found
from plogic.base.errors import InputError
from plogic.cycle.delta import Options

FEW = Case(EASY, types=2, appearance_types=40, features=60, appearances=60)


def nobody(say, seed):
    return None


@pytest.fixture
def knowing(monkeypatch):
    """Our side stands aside: it says what the truth is, and remembers what it was asked."""
    asked = []

    def ours(perceiver, gamma):
        asked.append((perceiver.kb, gamma))
        return [], []

    monkeypatch.setattr(clutter, "ours", ours)
    return asked


def test_a_real_run_finds_real_objects():
    """Of a sharp detector: with one pixel of noise few points of a small object do not tell its pose to 5 degrees."""
    said = []
    sharp = replace(FEW, detector=Detector("sharp", 0.8, 0.1, 0.05))
    text, _ = run(seed=0, limit=0.2, quick=True, as_json=True, say=said.append, learn=nobody, plan=Plan([sharp], 5, 0))
    document = json.loads(text)
    mine, accepted, told = document["rows"]
    assert document["bench"] == "clutter"
    assert (mine["who"], mine["trials"], mine["learned"]) == ("ours", 3, "0/0")
    assert mine["pose"] >= 0.6
    assert mine["build"] >= 0
    assert (accepted["who"], accepted["median s"]) == ("accepted", mine["median s"])
    assert accepted["identity"] <= mine["identity"]
    assert (told["who"], told["trials"], told["pose"], told["build"]) == ("told", 3, 1, "")
    assert [line.split(",")[0] for line in said if line.startswith("trial")] == ["trial 1", "trial 2", "trial 4"]


class Perceiver:
    """Has accepted a and, as better, b; considered c, and rejected d."""

    kb = None

    class Hypothesis:
        """What is asked of one."""

        def __init__(self, name, surplus, status="accepted"):
            self.surplus, self.status = surplus, status
            self.type, self.camera_from_object = name, np.eye(4)

    def delta(self, *asked):
        """As the real one's."""
        assert asked[1] == Options(reading="posterior")
        beliefs = {
            "h1": self.Hypothesis("a", 3.0),
            "h2": self.Hypothesis("b", 7.0),
            "h3": self.Hypothesis("c", 9.0, "rival"),
        }
        return type("Delta", (), {"beliefs": beliefs}), (self.Hypothesis("d", 10.0, "rejected"),), []


def test_the_accepted_ones_and_the_others_each_the_best_first():
    accepted, others = clutter.ours(Perceiver(), None)
    assert [found.type for found in accepted] == ["b", "a"]
    assert [found.type for found in others] == ["d", "c"]


@pytest.mark.parametrize(("accepted", "answer"), [(["b", "a"], "b"), ([], "d")])
def test_the_answer_is_the_best_accepted_or_else_the_best(monkeypatch, accepted, answer):
    asked = []
    monkeypatch.setattr(
        clutter,
        "ours",
        lambda *_: ([Found(name, np.eye(4)) for name in accepted], [Found(name, np.eye(4)) for name in "dc"]),
    )
    monkeypatch.setattr(
        clutter, "judged", lambda found, _: asked.append([one.type for one in found]) or (True, True, False)
    )
    said = clutter.answered(series_of(FEW, None, 0), Perceiver(), (0, 1), (), 1.0)
    assert [one.who for one in said] == ["ours", "accepted", "told"]
    assert asked[:2] == [[answer], accepted]


def test_a_third_of_the_trials_is_of_learned_types(knowing):
    text, met = run(
        seed=0,
        limit=1,
        quick=True,
        as_json=True,
        say=lambda _: None,
        learn=lambda *_: learned_kb(),
        plan=Plan([FEW], 6, 0),
    )
    assert not met
    row = json.loads(text)["rows"][0]
    assert (row["trials"], row["learned"], row["identity"]) == (6, "0/2", 0)
    assert [kb.types[0].name for kb, _ in knowing] == ["cube"] * 6


def test_left_out_trials_are_said(knowing):
    text, _ = run(seed=0, limit=1, quick=True, as_json=False, say=lambda _: None, learn=nobody, plan=Plan([FEW], 6, 0))
    assert "There are no learned types: their trials are left out." in text
    assert len(knowing) == 4


@pytest.mark.parametrize(("budget", "least"), [(0.5, 0.5), (4.0, 2)])
def test_peers_get_the_same_data_in_the_first_trials_and_no_more_time_than_the_limit(
    knowing, monkeypatch, budget, least
):
    asked = []

    def ask(kb, gamma, seconds):
        asked.append((kb, gamma, seconds))
        return kb.types[0].name, np.eye(4)

    monkeypatch.setattr(clutter, "there", lambda *_: (Peer("first", "", ask),))
    text, _ = run(
        seed=3, limit=2.0, quick=True, as_json=True, say=lambda _: None, learn=nobody, plan=Plan([FEW], 6, 3, budget)
    )
    assert [seconds for *_, seconds in asked] == [least, least]
    assert [gamma for _, gamma, _ in asked] == [gamma for _, gamma in knowing[:2]]
    listed = json.loads(text)["rows"]
    assert [(row["who"], row["trials"]) for row in listed] == [
        ("ours", 4),
        ("accepted", 4),
        ("told", 4),
        (f"first {least} s", 2),
    ]
    assert listed[3]["identity"] + listed[3]["false"] / 2 == 1


def test_a_quick_run_asks_less():
    full, quick = Plan(), clutter.QUICK
    assert (full.cases, full.trials, full.peer_trials, full.budget) == (PLAN, 200, 10, 2)
    assert (quick.trials, quick.peer_trials, quick.budget) == (10, 3, 2)
    assert set(quick.cases) < set(full.cases)


def test_trials_are_the_same_each_time_and_alike_for_both_detectors():
    first, again = (series_of(FEW, None, 7) for _ in range(2))
    dim = series_of(replace(FEW, detector=HARD), None, 7)
    assert first.numbers(3) == [1, 2]
    assert first.kb.digest == again.kb.digest
    assert first.trial(7, 1).gamma.appearances == again.trial(7, 1).gamma.appearances
    assert first.trial(7, 1).gamma.appearances != first.trial(7, 2).gamma.appearances
    assert first.trial(7, 1).gamma.appearances != first.trial(8, 1).gamma.appearances
    one, other = first.trial(7, 2).truth, dim.trial(7, 2).truth
    assert one.type == other.type
    assert np.array_equal(one.camera_from_object, other.camera_from_object)


def test_the_object_of_a_learned_trial_is_a_learned_one():
    series = series_of(FEW, learned_kb(), 0)
    assert series.numbers(9) == list(range(9))
    types = [series.trial(0, n).truth.type for n in range(9)]
    assert types == [*["cube", "r0000", "r0000"] * 3]
    assert [kind.name for kind in series.kb.types] == ["cube", "r0000"]


def test_without_the_meshes_it_goes_on_and_says_so(monkeypatch, tmp_path):
    monkeypatch.setattr(recognition_scenes, "YCB", tmp_path / "none")
    said = []
    assert clutter.learned_kb(said.append) is None
    assert len(said) == 1
    assert said[0].startswith("no trials of learned types: ")


def test_what_is_learned_is_read_back(monkeypatch, tmp_path):
    """As for ``recognition``; here an empty one is written."""
    from plogic.face.authoring.kb_types import new_command

    monkeypatch.setattr(recognition_scenes, "ycb_meshes", lambda: {"it": tmp_path})
    monkeypatch.setattr("benchmarks.recognition.kb.learn_into", lambda folder, *_: new_command(folder, None))
    kb = clutter.learned_kb(lambda _: None)
    assert kb.types == ()

    def fails(*_):
        raise InputError("no")

    monkeypatch.setattr("benchmarks.recognition.kb.learn_into", fails)
    assert clutter.learned_kb(lambda _: None) is None


def test_a_found_object_is_what_a_peer_answers():
    (found,) = clutter._one(Peer("it", "", lambda *_: ("cup", np.eye(4))), 1.0, None, None)
    assert isinstance(found, Found)
    assert found.type == "cup"
    assert clutter._one(Peer("it", "", lambda *_: None), 1.0, None, None) == []
