"""Another process that holds something until it is killed."""

from __future__ import annotations

import os
import signal
import time
from contextlib import contextmanager


@contextmanager
def killed_while(held):
    """The number of a process that is within ``held()``, and is killed at the end of the block."""
    read, write = os.pipe()
    pid = os.fork()
    if not pid:
        try:
            with held():
                os.write(write, b".")
                time.sleep(600)
        finally:
            os._exit(1)
    try:
        os.close(write)
        assert os.read(read, 1) == b".", "the process came to nothing"
        yield pid
    finally:
        os.close(read)
        os.kill(pid, signal.SIGKILL)
        os.waitpid(pid, 0)
