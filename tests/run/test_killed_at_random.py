"""Commands with children, killed at random: nothing of them lives on, and the next start takes away what they left."""

from __future__ import annotations

import os
import random
import shutil
import signal
import subprocess
import time
from pathlib import Path

import pytest
from console import BIN, few_views, good
from painted_cube import write_cube

from geometry.files.begun import scratch

ROOT = Path(__file__).parents[2]
FAMILY = "TEST_FAMILY"
"""The variable by which a process and all that it starts are known."""
LOOK, PATIENCE = 0.1, 20
"""Seconds between two looks, and how many of them whatever was killed has to go: 2 s."""
SIDE = 12
HEAVY = "\n".join(
    [
        *(f"0.5::edge({a},{a + step})." for a in range(SIDE**2) for step in (1, SIDE) if a + step < SIDE**2),
        "path(X, Y) :- edge(X, Y). path(X, Y) :- edge(Y, X). path(X, Y) :- path(X, Z), path(Z, Y).\n",
    ]
)
"""Whether there is a way through a grid, which takes minutes."""
COMMANDS = {
    "query": (3, ("query", "heavy.pl", f"path(0,{SIDE**2 - 1})")),
    "batch": (1, ("batch", "shots", "--kb", "first", "--jobs", "2", "--order", "done")),
    "learn": (1, ("kb", "learn", "--jobs", "2", "--kb", "kb")),
}
"""How often each is killed: it starts as many processes each time as it has children."""


@pytest.fixture(scope="module")
def work(tmp_path_factory):
    """A folder with what the commands read."""
    folder = tmp_path_factory.mktemp("work")
    (folder / "heavy.pl").write_text(HEAVY)
    (folder / "shots").mkdir()
    for i in range(200):
        shutil.copy(ROOT / "examples" / "first_gamma.json", folder / "shots" / f"{i:03d}.json")
    good("kb", "add", "one", "--mesh", write_cube(folder), "--units", "m", "--kb", folder / "kb")
    return folder


def family(token):
    """The processes that live, of those whose environment has a token."""
    found = []
    for place in Path("/proc").iterdir():
        if place.name.isdecimal():
            try:
                has = f"{FAMILY}={token}".encode() in (place / "environ").read_bytes().split(b"\0")
            except OSError:  # it has ended, or is somebody else's
                continue
            if has and (place / "stat").read_text().rpartition(")")[2].split()[0] != "Z":
                found.append(int(place.name))
    return found


def started(command, token, folder, scratch):
    own = few_views(folder) | {FAMILY: token, "TMPDIR": str(scratch), "TEST_DIRECTIONS": "200"}
    own["PYTHONPATH"] = os.pathsep.join([own["PYTHONPATH"], str(ROOT)])
    quiet = {"stdin": subprocess.DEVNULL, "stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
    return subprocess.Popen([str(BIN / "plogic"), *command], cwd=folder, env=os.environ | own, **quiet)


def with_children(process, token):
    """Wait until it has some; whether it lives."""
    while len(family(token)) < 2 and process.poll() is None:
        time.sleep(LOOK)
    return process.poll() is None


@pytest.mark.parametrize("name", COMMANDS)
def test_nothing_lives_on_and_the_next_start_takes_the_rest_away(work, tmp_path, monkeypatch, name):
    kills, command = COMMANDS[name]
    rng, left = random.Random(name), set()  # noqa: S311 - no secret
    for i in range(kills):
        token = f"{os.getpid()}-{name}-{i}"
        process = started(command, token, work, tmp_path)
        assert with_children(process, token), "it ended before it could be killed"
        time.sleep(rng.uniform(0.0, 0.6))
        before = family(token)
        process.send_signal(signal.SIGKILL)
        assert process.wait() == -signal.SIGKILL, "it ended before it could be killed"
        assert len(before) > 1
        looks = 0
        while (living := family(token)) and looks < PATIENCE:
            time.sleep(LOOK)
            looks += 1
        assert living == []
        left |= {path.name for path in tmp_path.iterdir()}
    assert left, "whoever has children has a folder for what they write"
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    with scratch() as mine:  # as every process does that is about to have children
        assert list(tmp_path.iterdir()) == [mine]
