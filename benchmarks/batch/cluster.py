"""A Dask cluster on this machine for the time of a test.

A scheduler and workers of one thread, each a process of its own.
"""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import tempfile
from contextlib import contextmanager
from importlib import import_module
from pathlib import Path
from time import monotonic, sleep
from typing import TYPE_CHECKING, Any

from plogic.base.errors import InputError

if TYPE_CHECKING:
    from collections.abc import Iterator

PATIENCE = 60.0
"""Seconds that scheduler and workers may take to be there."""


@contextmanager
def loopback(workers: int) -> Iterator[str]:
    """The address of the scheduler, as soon as all workers have come. Raises InputError where they do not."""
    with tempfile.TemporaryDirectory(prefix="plogic-dask-") as folder:
        said = Path(folder) / "scheduler.json"
        common = ["--scheduler-file", str(said), "--no-dashboard", "--host", "127.0.0.1"]
        own = ["--nthreads", "1", "--no-nanny", "--local-directory", folder]
        scheduler = ["scheduler", "--port", "0", *common]
        children = [_start(scheduler, folder)]
        try:
            address = _address(said)
            children += [_start(["worker", *common, *own], folder) for _ in range(workers)]
            _wait(address, workers)
            yield address
        finally:
            for child in reversed(children):
                os.killpg(child.pid, signal.SIGKILL)
                child.wait()


def _start(arguments: list[str], folder: str) -> subprocess.Popen[bytes]:
    command = [sys.executable, "-W", "ignore", "-m", "dask", *arguments]
    return subprocess.Popen(  # noqa: S603 - our own words
        command,
        cwd=folder,
        stdin=subprocess.DEVNULL,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
        start_new_session=True,
    )


def _address(said: Path) -> str:
    end = monotonic() + PATIENCE
    while monotonic() < end:
        try:
            return str(json.loads(said.read_text(encoding="utf-8"))["address"])
        except (OSError, ValueError):
            sleep(0.1)
    raise InputError("the Dask scheduler does not start")


def _wait(address: str, workers: int) -> None:
    distributed: Any = import_module("distributed")
    with distributed.Client(address, timeout=PATIENCE, set_as_default=False) as client:
        client.wait_for_workers(workers, timeout=PATIENCE)
