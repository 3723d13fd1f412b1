"""Where nothing can be written, or the shell says nothing of where programs are: a line, or the same answer."""

from __future__ import annotations

import errno
import os
import resource
import subprocess
import threading
from pathlib import Path

import pytest
from console import BIN, SECONDS

import cli
from geometry.room import check_threads

ALARM = Path(__file__).parents[3] / "examples" / "alarm.pl"


def ran(*args, file_size=None, **environment):
    """A finished run of the console script; files of at most ``file_size`` bytes may be written."""

    def limited():
        resource.setrlimit(resource.RLIMIT_FSIZE, (file_size, file_size))

    return subprocess.run(
        [str(BIN / "plogic"), *map(str, args)],
        capture_output=True,
        text=True,
        timeout=SECONDS,
        check=False,
        preexec_fn=None if file_size is None else limited,
        env=os.environ | environment,
    )


def test_where_no_folder_takes_temporary_files():
    run = ran("query", ALARM, file_size=0)
    said = "no folder for temporary files can be written to (TMPDIR)"
    assert (run.returncode, run.stdout) == (1, "")
    assert run.stderr == f"plogic: a scratch file: cannot be written: {said}\n"
    told = ran("doctor", file_size=0)
    assert told.returncode == 1
    assert " ".join(told.stdout.split()).count(said) == 2
    assert "mend the installation" not in told.stdout


@pytest.mark.parametrize("args", [["query", ALARM], ["kb", "check", "first"]], ids=lambda args: args[0])
def test_where_no_folder_holds_programs(args):
    there, none = ran(*args), ran(*args, PATH="")
    assert there.returncode == 0
    assert (none.returncode, none.stdout, none.stderr) == (0, there.stdout, there.stderr)


@pytest.mark.parametrize(
    "error",
    [
        BlockingIOError(errno.EAGAIN, "Resource temporarily unavailable"),
        RuntimeError("can't start new thread"),
        RuntimeError("pthread_create has failed: Resource temporarily unavailable"),
    ],
    ids=["process", "thread", "Embree's"],
)
def test_where_no_process_or_thread_can_be_started(error):
    """What the system says under ``ulimit -u``, which does not hold for root."""
    said = "no more threads or processes can be started: their number, or memory, is at its limit (ulimit -u, -v)"
    assert cli._told(error) == [said]


def test_embree_is_not_asked_for_where_there_are_no_threads(monkeypatch):
    def none(_):
        raise RuntimeError("can't start new thread")

    monkeypatch.setattr(threading.Thread, "start", none)
    with pytest.raises(RuntimeError, match="can't start new thread"):
        check_threads(1)
    check_threads(0)
