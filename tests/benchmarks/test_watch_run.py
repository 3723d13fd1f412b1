"""``plogic bench watch``: what it makes of a run, and what it claims; and a run of one scene."""

from __future__ import annotations

import json
import os

from benchmarks.watch import bench
from benchmarks.watch.bench import Watched, claims, row_of


def test_a_row_leaves_the_start_aside():
    lines = [json.dumps({"frame": n}) for n in range(5)]
    row = row_of("at once", Watched(lines, 2.0, 5.0), Watched(lines[:1], 0.0, 1.0), 7)
    assert row == {
        "sent": "at once",
        "frames": 7,
        "interpreted": 5,
        "skipped": 2,
        "frames a second": 2.0,
        "processor": 1.0,
    }


def test_claims_are_of_two_frames_a_second_and_of_the_same_bytes():
    processors = len(os.sched_getaffinity(0))
    good = [{"processor": processors / 2}, {"skipped": 0}]
    assert [claim.met for claim in claims(good, 1.0)] == [True, True, True]
    bad = [{"processor": processors / 2 + 0.01}, {"skipped": 1}]
    assert [claim.met for claim in claims(bad, 0.5)] == [False, False, False]


def test_a_run_interprets_what_it_sends_and_finds_the_video_the_same(monkeypatch):
    monkeypatch.setattr(bench, "FEW", 1)
    text, _ = bench.run(seed=0, quick=True, as_json=True, say=lambda _: None)
    found = json.loads(text)
    at_once, paced = found["rows"]
    assert (at_once["frames"], at_once["interpreted"], at_once["skipped"]) == (3, 3, 0)
    assert paced["interpreted"] + paced["skipped"] == 3
    assert at_once["processor"] > 0.0
    assert found["claims"][2]["met"]
