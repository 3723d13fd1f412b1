"""A batch whose processes are killed, in short, and what is told of lines that are not as they should be."""

from __future__ import annotations

import json
from random import Random

import pytest
from small_frames import KB, gamma

from benchmarks.fuzz.frames import PROCESSES, Frames, KillWorkers, Look, Run, claims, grown, megabytes, wrong_lines
from plogic.run.batch.frames import Frame, Settings
from plogic.run.batch.work import Worker

FRAMES, EVERY = 1000, 50


def test_workers_that_are_killed_cost_no_frame(tmp_path):
    (tmp_path / "frames").mkdir()
    paths = [tmp_path / "frames" / f"{i:04d}.json" for i in range(FRAMES)]
    for i, path in enumerate(paths):
        document = gamma(2)
        document["appearances"][0]["uv"] = [0.5 + i / 16, 20.0]
        path.write_text(json.dumps(document))
    names = [str(path) for path in paths]
    worker = Worker(Settings(str(KB)))
    right = [worker(Frame(name, None, "gamma"))[1] for name in names]
    kill = KillWorkers(EVERY, Random(0), spread=0.05)  # noqa: S311 - no secret
    run = Frames(tmp_path, str(KB), names).run(Run("killed"), [kill])
    assert kill.kills >= 2
    assert run.left == 0
    assert wrong_lines(names, run.rows, right) == dict.fromkeys(("lost", "doubled", "bad", "misplaced", "other"), 0)
    for who in PROCESSES.values():
        assert max(mb for mb in megabytes(run.looks, FRAMES, who) if mb) > 10.0


def line(name, status="done"):
    return json.dumps({"input": name, "status": status}).encode()


@pytest.mark.parametrize(
    ("rows", "wrong"),
    [
        ("abc", {}),
        ("ab", {"lost": 1, "other": 1}),
        ("abbc", {"doubled": 1, "misplaced": 1}),
        ("acb", {"misplaced": 2}),
        ("aBc", {"bad": 1, "other": 2}),
    ],
)
def test_what_is_wrong_with_lines(rows, wrong):
    right = [line(name) for name in "abc"]
    found = wrong_lines("abc", [line(name.lower(), "done" if name.islower() else "error") for name in rows], right)
    assert found == dict.fromkeys(("lost", "doubled", "bad", "misplaced", "other"), 0) | wrong


def test_memory_that_grows_breaks_a_claim():
    looks = [Look(i, 100_000_000, {1: 50_000_000 + 1_000_000 * i, 2: 10}) for i in range(100)]
    parent, worker = (megabytes(looks, 100, of) for of in (lambda look: look.parent, lambda look: look.workers[1]))
    assert parent == [100.0] * 10
    assert worker == [59.0 + 10 * i for i in range(10)]
    taken = [
        {"run": "unharmed", "MB of": who, **{str(i): mb for i, mb in enumerate(row, 1)}}
        for who, row in (("parent", parent), ("worker", worker))
    ]
    assert [grown(row) for row in taken] == [1.0, 149 / 69]
    rows = [
        {"run": name, "lost": 0, "doubled": 0, "bad": 0, "misplaced": 0, "other": 0, "left": 0, "kills": 9}
        for name in ("unharmed", "workers killed", "parent ended")
    ]
    assert [claim.met for claim in claims(rows, taken, 100, 10)] == [*[True] * 9, False]
    rows[1]["lost"] = 1
    assert not claims(rows, taken, 100, 10)[0].met
