"""Jobs for fresh processes, which find them in this module and import nothing else for them."""

from __future__ import annotations

import os
import signal
import time
from pathlib import Path


def half(number):
    """Half of it and in which process, the earlier the later; the eighth fails."""
    time.sleep(0.002 * (12 - number))
    if number == 7:
        raise ValueError(number)
    return number / 2, os.getpid()


def dies(number):
    """Kill the process at the fourth job."""
    if number == 3:
        os.kill(os.getpid(), signal.SIGKILL)
    return number


def resolved(name):
    """A relative path as the process sees it."""
    return Path(name).resolve()
