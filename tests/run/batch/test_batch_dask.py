"""Faults of somebody else's cluster are told in one line and in bounded time, and nothing of ours stays on it."""

from __future__ import annotations

import json
import os
import shutil
import signal
import socket
import subprocess
import sys
import threading
import time
from contextlib import ExitStack, contextmanager, suppress

import pytest
from console import BIN, plogic
from hostile_pictures import WAITS, hostile
from small_frames import KB, NAMES, picture

from plogic.base.errors import InputError
from plogic.run.batch import dask as cluster
from plogic.run.batch.dask import Connection

PATIENCE = 60


class Machines:
    """A scheduler and its workers, each the head of a process group."""

    def __init__(self, folder):
        self.folder, self.said, self.children = folder, folder / "scheduler.json", []
        self.start("scheduler", "--port", "0")
        wait_until(lambda: self.said.exists() and self.said.read_text().endswith("}"))
        self.address = json.loads(self.said.read_text())["address"]

    def start(self, *args, **env):
        """One process more."""
        command = [
            sys.executable,
            "-m",
            "dask",
            *args,
            "--scheduler-file",
            str(self.said),
            "--no-dashboard",
            "--host",
            "127.0.0.1",
        ]
        void = subprocess.DEVNULL
        self.children.append(
            subprocess.Popen(
                command,
                cwd=self.folder,
                stdin=void,
                stdout=void,
                stderr=void,
                start_new_session=True,
                env=os.environ | env,
            )
        )

    def worker(self, **env):
        """A worker more, which has come."""
        before = self.threads()
        self.start("worker", "--nthreads", "1", "--no-nanny", **env)
        wait_until(lambda: self.threads() == before + 1)

    def threads(self):
        """As the scheduler knows them."""
        connection = Connection(self.address, lambda _: None)
        try:
            return connection.threads()
        finally:
            connection.close(lambda: None)


def wait_until(met):
    end = time.monotonic() + PATIENCE
    while not met():
        assert time.monotonic() < end, "it does not happen"
        time.sleep(0.1)


@pytest.fixture
def machines(tmp_path):
    found = Machines(tmp_path)
    yield found
    for child in reversed(found.children):
        os.killpg(child.pid, signal.SIGKILL)
        child.wait()


def of_ours(child):
    """The processes that a worker has started."""
    rows = subprocess.run(
        ["ps", "-o", "stat=", "--ppid", str(child.pid)], capture_output=True, text=True, check=False
    ).stdout.split()
    return len([state for state in rows if not state.startswith("Z")])


@contextmanager
def listening(answer):
    """The port of one who says ``answer`` and no more to everybody."""
    with socket.create_server(("127.0.0.1", 0)) as server:

        def serve():
            with ExitStack() as kept, suppress(OSError):
                while True:
                    kept.enter_context(server.accept()[0]).sendall(answer)

        threading.Thread(target=serve, daemon=True).start()
        yield server.getsockname()[1]
        server.shutdown(socket.SHUT_RDWR)


@pytest.mark.parametrize("answer", [b"", b"HTTP/1.1 400 Bad Request\r\n\r\n" * 20], ids=["silence", "HTTP"])
def test_who_is_no_scheduler_is_not_waited_for(monkeypatch, answer, capfd):
    monkeypatch.setattr(cluster, "CONNECTING", 1.0)
    start = time.monotonic()
    with listening(answer) as port, pytest.raises(InputError, match=r"no Dask scheduler answers there: \w") as told:
        Connection(f"tcp://127.0.0.1:{port}", print)
    assert time.monotonic() - start < 5
    assert "\n" not in str(told.value)
    assert capfd.readouterr().err == ""


@pytest.mark.parametrize("address", ["localhost", "tcp://", "foo:bar", "tls://127.0.0.1:1", "inproc://x", "odd://x:1"])
def test_what_is_no_address_is_told_at_once(frames, address):
    start = time.monotonic()
    run = plogic("batch", "frames", "--kb", KB, "--dask", address, cwd=frames)
    assert time.monotonic() - start < 8
    assert (run.returncode, run.stdout) == (1, "")
    assert run.stderr.startswith(f"plogic: {address}: no Dask scheduler answers there: ")
    assert len(run.stderr.splitlines()) == 1


def test_workers_are_waited_for_and_not_for_ever(machines, monkeypatch):
    monkeypatch.setattr(cluster, "WAITING", 1.0)
    monkeypatch.setattr(cluster, "LOOK", 0.2)
    said = []
    connection = Connection(machines.address, said.append)
    with pytest.raises(InputError, match=r"the Dask scheduler has had no workers for 1 s"):
        connection.wait()
    connection.close(lambda: None)
    assert said == [f"{machines.address}: the Dask scheduler has no workers: waiting for them, for 1 s"]


def test_a_worker_that_lacks_plogic_is_told_and_lives(machines, frames, tmp_path):
    (tmp_path / "bare").mkdir()
    (tmp_path / "bare" / "plogic.py").write_text("raise ModuleNotFoundError(\"No module named 'plogic'\")\n")
    machines.worker(PYTHONPATH=str(tmp_path / "bare"))
    run = plogic("batch", "frames", "--kb", KB, "--dask", machines.address, cwd=frames)
    assert run.returncode == 1
    assert (
        run.stderr
        == f"plogic: {machines.address}: a Dask worker lacks plogic, or has another one than is here: No module named 'plogic'\n"
    )
    assert machines.threads() == 1


@pytest.fixture
def late(machines, frames, tmp_path):
    """A worker that waits for ever over one of the frames, its cluster, and a folder with the frames."""
    shutil.copytree(frames / "frames", tmp_path / "frames")
    picture(tmp_path / "frames" / "shot" / "late.png", WAITS)
    machines.worker(**hostile(tmp_path / "detector"))
    return machines


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGKILL])
def test_a_run_that_ends_leaves_nothing_at_work(late, tmp_path, number):
    out = tmp_path / "out.jsonl"
    with started(late, tmp_path, out) as child:
        assert of_ours(late.children[1]) == 1
        child.send_signal(number)
        said = child.communicate()[1].decode()
    assert "Traceback" not in said
    wait_until(lambda: of_ours(late.children[1]) == 0)


def test_a_lost_scheduler_ends_the_run_and_what_is_done_stays(late, frames, tmp_path):
    out = tmp_path / "out.jsonl"
    with started(late, tmp_path, out) as child:
        os.killpg(late.children[0].pid, signal.SIGKILL)
        said = child.communicate()[1].decode().splitlines()
        assert child.returncode == 1
    failed = f"plogic: {late.address}: the Dask cluster failed: its scheduler is gone, or does not answer"
    assert said[-2:] == [f"stopped; --resume goes on with {out}", failed]
    before = out.read_bytes()
    run = plogic("batch", "frames", "--kb", KB, "--jobs", 1, "--resume", "-o", out, cwd=tmp_path)
    assert f"{out}: 9 frames, 7 of them before, 3 bad" in run.stderr
    assert out.read_bytes().startswith(before)


@contextmanager
def started(machines, folder, out):
    """Faults of somebody else's cluster are told in one line, in bounded time, and nothing of ours stays on it."""
    command = [str(BIN / "plogic"), "batch", "frames", "--kb", str(KB), "--dask", machines.address, "-o", str(out)]
    pipe = subprocess.PIPE
    with subprocess.Popen(command, cwd=folder, stdin=pipe, stdout=pipe, stderr=pipe, start_new_session=True) as child:
        try:
            wait_until(lambda: out.exists() and out.read_bytes().count(b"\n") == len(NAMES) - 1)
            time.sleep(1.0)
            yield child
        finally:
            if child.poll() is None:
                os.killpg(child.pid, signal.SIGKILL)
