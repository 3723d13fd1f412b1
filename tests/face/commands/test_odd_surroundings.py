"""Where nothing can be written, or the shell says nothing of where programs are: a line, or the same answer."""

from __future__ import annotations

import errno
import os
import resource
import subprocess
from pathlib import Path

import pytest
from console import BIN, SECONDS

import cli
from plogic.face.shown.printed import tell_unkept
from plogic.run.health.remains import caches

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


def test_loops_that_are_kept_nowhere_are_told(monkeypatch, capfd):
    tell_unkept()
    assert capfd.readouterr() == ("", "")
    monkeypatch.setattr("sensing.compiled.UNKEPT", ["added", "drawn"])
    tell_unkept()
    assert capfd.readouterr().err.startswith("2 loops were compiled for this run alone, as no folder takes them")


def test_doctor_tells_where_no_folder_takes_loops(monkeypatch):
    """A user who may write neither to the installation nor to his cache, which no test can be, as root."""
    monkeypatch.setattr("os.access", lambda *_: False)
    (found,) = [one for one in caches(fix=False) if one.name == "numba"]
    assert (found.state, found.remedy) == ("note", "set NUMBA_CACHE_DIR to a folder that can be written to")
