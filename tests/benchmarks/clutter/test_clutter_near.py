"""The refiners of ``plogic bench clutter``: all begin at the same near poses, and each is judged like any answer."""

import json

import numpy as np
import pytest

from benchmarks.clutter import bench as clutter
from benchmarks.clutter.bench import NEAR_CASES, Plan, run, series_of
from benchmarks.clutter.near import MOVED, TURNED, Refined, begun, near, near_rows
from benchmarks.clutter.scenes import Case
from benchmarks.clutter.types import EASY, HARD, Detector
from geometry.frames import pose_error
from plogic.run.perceive import Perceiver

FEW = Case(Detector("sharp", 0.9, 0.2, 0.03), types=2, appearance_types=60, features=60, appearances=60)


@pytest.fixture(scope="module")
def series():
    return series_of(FEW, None, 0)


def test_a_start_is_as_far_off_as_it_says(series):
    posed = series.trial(0, 1)
    truth, middle = posed.truth.camera_from_object, np.append(posed.truth.centre, 1.0)
    assert min(len(TURNED), len(MOVED)) > 1
    for turned in TURNED:
        for moved in MOVED:
            start = begun(posed, turned, moved, np.random.default_rng(0))
            assert np.degrees(pose_error(start, truth)[0]) == pytest.approx(turned)
            assert np.linalg.norm((start - truth) @ middle) == pytest.approx(
                moved * np.linalg.norm(truth @ middle - [0, 0, 0, 1])
            )


def test_from_small_errors_all_but_plain_settling_come_home(series):
    perceiver = Perceiver(series.kb)
    outcomes = near(FEW, series.trial(0, 1), perceiver, np.random.default_rng(0))
    assert len(outcomes) == 3 * len(TURNED) * len(MOVED)
    home = {(o.who, o.turned, o.moved) for o in outcomes if o.pose}
    assert {("climb", 10.0, 0.02), ("SoftPOSIT", 10.0, 0.02)} <= home
    again = near(FEW, series.trial(0, 1), perceiver, np.random.default_rng(0))
    assert [o.pose for o in again] == [o.pose for o in outcomes]


def test_rows_are_shares_of_each_refiner_a_start():
    case, other = (Case(detector, 2, 40) for detector in (EASY, HARD))
    some = [
        Refined(case, 5.0, 0.02, "a", right, seconds) for right, seconds in ((True, 1.0), (False, 2.0), (True, 3.0))
    ]
    some += [
        Refined(case, 5.0, 0.02, "b", pose=False, seconds=0.5),
        Refined(other, 40.0, 0.1, "a", pose=True, seconds=0.1),
    ]
    first, second = near_rows(some)
    assert first == {
        "case": "easy",
        "turned": "5 deg",
        "moved": "2 %",
        "trials": 3,
        "a": 0.6667,
        "a s": 2.0,
        "b": 0.0,
        "b s": 0.5,
    }
    assert (second["case"], second["turned"], second["moved"], second["a"]) == ("hard", "40 deg", "10 %", 1.0)


def test_the_table_is_beside_the_rows(monkeypatch):
    monkeypatch.setattr(clutter, "ours", lambda *_: ([], []))
    asked = {
        "seed": 0,
        "limit": 0.1,
        "quick": True,
        "say": lambda _: None,
        "learn": lambda *_: None,
        "plan": Plan([FEW], 2, 0, near=[FEW]),
    }
    document = json.loads(run(as_json=True, **asked)[0])
    assert [row["trials"] for row in document["near"]] == [1] * len(TURNED) * len(MOVED)
    assert set(document["near"][0]) >= {"settle", "climb", "SoftPOSIT", "settle s", "climb s", "SoftPOSIT s"}
    assert "\nnear\n" in run(as_json=False, **asked)[0]


def test_the_easy_and_the_hard_row_are_asked():
    assert [(case.detector.name, case.types, case.appearance_types) for case in NEAR_CASES] == [
        ("easy", 100, 300),
        ("hard", 100, 300),
    ]
    assert Plan().near == NEAR_CASES
