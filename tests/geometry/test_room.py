"""Room for memory: what libraries take when they are loaded, and what is said where there is not so much."""

from __future__ import annotations

import subprocess
import sys

import numpy as np
import pytest

from geometry.room import MARGIN, MB, NEEDS, check_room
from sensing.compiled import COMPILING

SIZES = """
import os, sys
from importlib import import_module

def sizes():
    rows = dict(line.split(":", 1) for line in open("/proc/self/status"))
    return [int(rows[name].split()[0]) << 10 for name in ("VmSize", "VmData")]

*before, what = sys.argv[1:]
for name in before:
    import_module(name)
first = sizes()
for name in what.split(","):
    import_module(name)
print(*(b - a for a, b in zip(first, sizes())))
"""
LOOPS = "sensing.views.loops,sensing.pixels.loops,sensing.pixels.painting,sensing.detectors.edge_loops"


def taken(*modules, **environment):
    """Bytes of address space and of memory that the last of them takes, or the last ones together."""
    run = subprocess.run(
        [sys.executable, "-c", SIZES, *modules],
        capture_output=True,
        text=True,
        check=True,
        timeout=300,
        env={"OPENBLAS_NUM_THREADS": "1", "PYTHONPATH": ":".join(sys.path)} | environment,
    )
    return [int(each) for each in run.stdout.split()]


@pytest.mark.parametrize("name", NEEDS)
def test_what_a_library_takes(name):
    """No more than is asked for, and not far less, but for a few MB."""
    needs, found = MB * np.array(NEEDS[name]), np.array(taken(*(["numpy"] if name != "numpy" else []), name))
    assert (found <= MARGIN * needs).all()
    assert (needs <= np.maximum(2 * found, found + 10 * MB)).all()


def test_what_the_compiling_of_our_loops_takes(tmp_path):
    """At most, with nothing kept: of what is compiled when it is called, no more than this is known before."""
    reserved, memory = taken("cv2", "numba", LOOPS, NUMBA_CACHE_DIR=str(tmp_path))
    for need, found in zip(COMPILING, (memory, reserved), strict=True):
        assert found <= MARGIN * need < found * 2


def test_there_is_no_room_for_more_than_there_is():
    check_room(MB, 2 * MB)
    with pytest.raises(MemoryError):
        check_room(1 << 60)
    with pytest.raises(MemoryError):
        check_room(0, 1 << 60)
