"""Room for memory: what libraries take when they are loaded, and what is said where there is not so much."""

from __future__ import annotations

import subprocess
import sys
import threading

import numpy as np
import pytest

from geometry.arrays import PRODUCT
from geometry.room import MB, NEEDS, check_room, check_threads
from geometry.visibility import rays

SIZES = """
import sys
from importlib import import_module

def sizes():
    rows = dict(line.split(":", 1) for line in open("/proc/self/status"))
    return [int(rows[name].split()[0]) << 10 for name in ("VmData", "VmSize")]

*before, what = sys.argv[1:]
for name in before:
    import_module(name)
first = sizes()
import_module(what)
print(*(b - a for a, b in zip(first, sizes())))
"""


def taken(*modules, **more):
    """(2,) bytes of memory and of address space that the last of them takes; ``more`` of the environment."""
    run = subprocess.run(
        [sys.executable, "-c", SIZES, *modules],
        capture_output=True,
        text=True,
        check=True,
        timeout=300,
        env={"OPENBLAS_NUM_THREADS": "1", "PYTHONPATH": ":".join(sys.path), **more},
    )
    return np.array(run.stdout.split(), int)


MORE = {"scipy.linalg": "scipy.optimize"}


@pytest.mark.parametrize("name", NEEDS)
def test_what_a_library_takes_is_asked_for(name):
    """No less; that it is not far more, ``test_out_of_memory.py`` shows."""
    found = taken(*(["numpy"] if name != "numpy" else []), MORE.get(name, name))
    assert (found <= MB * np.array(NEEDS[name])).all()


@pytest.mark.parametrize("core", [None, "Haswell"], ids=["this processor", "one without AVX-512"])
def test_what_the_first_product_takes_is_asked_for(core):
    """Whose small products take nothing has its memory asked for by a large one."""
    found = taken("numpy", "geometry.arrays", **({} if core is None else {"OPENBLAS_CORETYPE": core}))[0]
    assert PRODUCT / 2 < found < PRODUCT + 4 * MB  # and a few modules


def test_there_is_no_room_for_more_than_there_is():
    check_room(MB, 2 * MB)
    with pytest.raises(MemoryError):
        check_room(1 << 60)
    with pytest.raises(MemoryError):
        check_room(MB, 1 << 60)


def test_embree_is_not_started_where_there_are_no_threads(monkeypatch):
    def none(_):
        raise RuntimeError("can't start new thread")

    monkeypatch.setattr("embreex.rtcore.EmbreeDevice", lambda: pytest.fail("it was started"))
    monkeypatch.setattr(threading.Thread, "start", none)
    with pytest.raises(RuntimeError, match="can't start new thread"):
        rays._device.__wrapped__()


def test_threads_that_were_counted_are_gone():
    before = threading.active_count()
    check_threads(5)
    assert threading.active_count() == before
