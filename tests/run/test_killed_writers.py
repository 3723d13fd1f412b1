"""Commands killed at operations on files, and several that write at once: each is whole, or refused in one line.

``python -m benchmarks.fuzz.crashes`` kills every command at each of its operations; here, some at some.
"""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from console import BIN, bytes_in, good, plogic
from killed_processes import killed_while
from painted_cube import write_cube

from geometry.files.begun import sweep
from kb.files.changes import writing
from kb.files.read import read_kb

ROOT = Path(__file__).parents[2]
KILLED, MOST = ("kb learn", "report"), 5
GAMMA = ROOT / "examples" / "first_gamma.json"


@pytest.fixture(scope="module")
def rows():
    """What the tool found of each, by name."""
    command = [sys.executable, "-m", "benchmarks.fuzz.crashes", *KILLED, "--most", str(MOST), "--json"]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return {row["command"]: row for row in json.loads(done.stdout)}


@pytest.mark.parametrize("name", KILLED)
def test_what_is_read_after_a_kill_is_the_old_or_the_new(name, rows):
    row = rows[name]
    assert row["kills"] == min(MOST, row["operations"])
    assert row["old"] + row["new"] == row["kills"]
    assert (row["torn"], row["left"]) == (0, 0)


def at_once(folder, *commands):
    """Status and lines on stderr of commands that are started together."""
    started = [
        subprocess.Popen(
            [str(BIN / "plogic"), *map(str, command)],
            cwd=folder,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.PIPE,
            text=True,
            env=os.environ | {"PYTHONPATH": str(ROOT)},
        )
        for command in commands
    ]
    return [(one.communicate()[1].splitlines(), one.returncode) for one in started]


def test_types_added_at_once_are_all_there_each_once(tmp_path):
    kb, mesh = tmp_path / "kb", write_cube(tmp_path)
    good("kb", "new", kb)
    names = "a", "b", "b"
    told = at_once(tmp_path, *(("kb", "add", name, "--mesh", mesh, "--units", "m", "--kb", kb) for name in names))
    assert sorted(status for _, status in told) == [0, 0, 1]
    (refused,) = (lines for lines, status in told if status)
    assert len(refused) == 1
    assert refused[0].endswith("objects/b: exists already; remove it first, or choose another name")
    assert [kind.name for kind in read_kb(kb).types] == ["a", "b"]
    assert [path for path in kb.rglob("*") if path.name.startswith(".")] == []


def test_who_learns_while_another_does_is_refused_in_one_line(tmp_path):
    kb = tmp_path / "kb"
    good("kb", "add", "a", "--mesh", write_cube(tmp_path), "--units", "m", "--kb", kb)
    with killed_while(lambda: writing(kb)) as other:
        before = bytes_in(kb)
        done = plogic("kb", "learn", "--kb", kb)
        assert (done.returncode, done.stdout) == (1, "")
        assert done.stderr == f"plogic: {kb}: process {other} is changing it: wait until it has ended\n"
        assert bytes_in(kb) == before


def test_four_batches_on_one_output_at_once(tmp_path):
    (tmp_path / "shots").mkdir()
    for i in range(2):
        shutil.copy(GAMMA, tmp_path / "shots" / f"{i}.json")
    command = "batch", "shots", "--kb", "first", "--jobs", "1", "-o", "lines.jsonl"
    told = at_once(tmp_path, *[command] * 4)
    assert sum(not status for _, status in told) == 1
    assert all(len([line for line in lines if line.startswith("plogic:")]) == 1 for lines, status in told if status)
    lines = [json.loads(line) for line in (tmp_path / "lines.jsonl").read_text().splitlines()]
    assert [Path(line["input"]).name for line in lines] == ["0.json", "1.json"]
    sweep(tmp_path)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["lines.jsonl", "shots"]
