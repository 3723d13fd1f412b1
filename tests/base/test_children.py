"""The four laws of children: they die with their parent, share its memory, may be raced, and sweep their scratch."""

from __future__ import annotations

import gc
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from geometry.files.begun import sweep
from plogic.base.children import Child, Copy, heard

FAMILY = Path(__file__).parents[1] / "helpers" / "family.py"
PATIENCE = 30.0
MEBIBYTE = 1 << 20


def alive(pid):
    """Whether there is such a process that is no mere entry of the system's table."""
    try:
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except FileNotFoundError:
        return False


def gone(pids):
    """Whether all of them end soon."""
    end = time.monotonic() + PATIENCE
    while any(alive(pid) for pid in pids):
        if time.monotonic() > end:
            return False
        time.sleep(0.02)
    return True


def shell(text, told=b"", **options):
    return Child(["sh", "-c", text], told=told, **options)


@pytest.fixture
def family(tmp_path):
    """Start a family of a kind, whose scratch is in ``tmp_path``; the process and what it tells."""
    started = []

    def start(*words):
        environment = os.environ | {"PYTHONPATH": str(FAMILY.parents[2]), "TMPDIR": str(tmp_path)}
        command = [sys.executable, FAMILY, *map(str, words)]
        started.append(subprocess.Popen(command, stdout=subprocess.PIPE, text=True, env=environment))
        return started[-1], started[-1].stdout.readline().split()

    yield start
    for process in started:
        process.kill()
        process.wait()
        process.stdout.close()


@pytest.mark.parametrize("kind", ["child", "copy", "watched"])
@pytest.mark.parametrize("number", [signal.SIGKILL, signal.SIGTERM])
def test_children_and_theirs_die_with_their_parent(family, kind, number):
    parent, said = family("system" if kind == "child" else kind)
    pids = [int(word) for word in said if word.isdecimal()]
    assert len(pids) == (1 if kind == "copy" else 2)
    assert all(map(alive, pids))
    parent.send_signal(number)
    parent.wait()
    assert gone(pids)


@pytest.mark.parametrize(("sizes", "ended"), [([90, 160, 120], 1), ([90, 100, 40], None)])
def test_the_largest_child_is_killed_where_a_process_and_its_children_take_too_much(family, sizes, ended):
    said = family("limited", 350, *sizes)[1]
    assert said == ["more_than_350_MB_of_memory" if i == ended else "signal_9" for i in range(3)]


@pytest.mark.parametrize(("sizes", "why"), [([150, 150], "more than 250 MB of memory"), ([90, 60], None)])
def test_a_child_and_its_own_share_its_limit(sizes, why):
    with Child([sys.executable, str(FAMILY), "hungry", *map(str, sizes)], memory=250 * MEBIBYTE) as child:
        child.read()  # it has taken all, or is killed
        assert child.rest(1.0)[1] is (why is None)
        assert child.end() == (why or "signal 9")


def test_the_system_holds_a_child_and_its_own_to_the_limit_too():
    with shell("ulimit -d; (ulimit -d); ulimit -c", memory=300 * MEBIBYTE) as child:
        assert child.rest(PATIENCE)[0].split() == [b"307200", b"307200", b"0"]


@settings(max_examples=12, deadline=None, derandomize=True)
@given(st.permutations([0.0, 60.0, 90.0]))
def test_the_first_of_several_is_heard_and_the_others_are_cancelled_with_all_they_started(delays):
    began = time.monotonic()
    racers = [shell(f"sleep {delay} & echo $!; read go; wait; echo done {delay}", told=None) for delay in delays]
    pids = [int(child.read()) for child in racers]
    for child in racers:
        child.tell(b"go\n")
    (first,) = heard(racers, PATIENCE)
    assert racers.index(first) == delays.index(0.0)
    assert [child.end() for child in racers if child is not first] == ["signal 9", "signal 9"]
    assert first.rest(PATIENCE) == (b"done 0.0\n", False)
    assert first.end() == "exit status 0"
    assert time.monotonic() - began < PATIENCE
    assert gone([*pids, *(child.pid for child in racers)])


def test_who_takes_too_long_is_killed_and_what_it_said_is_kept():
    with shell("echo early; sleep 60; echo late") as child:
        assert child.rest(0.5) == (b"early\n", True)
        assert child.wait() == -signal.SIGKILL


def test_who_waits_for_nobody_hears_nobody():
    assert heard([], 1.0) == []
    with shell("sleep 60") as child:
        assert heard([child], 0.0) == []


@pytest.mark.parametrize("how", ["end", "forgotten", "killed", "failed"])
def test_the_scratch_of_a_child_is_swept(how, monkeypatch, tmp_path):
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    if how == "failed":
        with pytest.raises(FileNotFoundError):
            Child(["no-such-command-anywhere"])
    else:
        child = shell('echo some > "$TMPDIR/file"; mkdir deep; echo more > deep/file; pwd; sleep 60')
        assert child.read().decode().strip() == str(child.folder)
        assert child.folder.parent == tmp_path
        if how == "killed":
            os.kill(child.pid, signal.SIGKILL)
        if how != "forgotten":
            child.end()
        del child
        gc.collect()
    assert list(tmp_path.iterdir()) == []


def test_what_a_killed_parent_left_is_swept_by_the_next_and_what_is_in_use_is_not(family, monkeypatch, tmp_path):
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    parent, said = family("system")
    left = Path(said[-1])
    sweep(tmp_path)
    assert left.is_dir(), "its process is alive"
    parent.kill()
    parent.wait()
    assert gone(int(pid) for pid in said[:2])
    with shell("sleep 60") as child:
        assert list(tmp_path.iterdir()) == [child.folder]


def test_last_words_and_files_and_variables():
    with shell('cat given; echo "$WORD"; echo worse >&2', files={"given": b"a"}, variables={"WORD": "b"}) as child:
        assert child.rest(PATIENCE) == (b"ab\n", False)
        assert child.last_words() == "worse\n"


def test_a_copy_that_was_killed_is_ended_all_the_same():
    copy = Copy(time.sleep, 600)
    os.kill(copy._process.pid, signal.SIGKILL)
    copy.end()
