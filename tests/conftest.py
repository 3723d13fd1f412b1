"""Common to all tests: one thread for products of matrices, ProbLog without its warnings, a small heap.

As the commands do (``cli.main``), numpy's library is told to use one thread: our products are many and small, and two
workers whose threads wait for each other take a third longer. ProbLog brings an old pyparsing, which is imported once,
its deprecation warnings aside. What importing and collecting all tests leaves stays to the end, and is not looked
through again with each collection of garbage, of which there are fewer. Ctrl-C reaches the commands that are tested, in
a shell's background as well, where it would be ignored by all that is started there.
"""

import gc
import json
import os
import signal
import sys

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import pytest

from plogic.logic.safety.author import load_problog
from plogic.logic.served.engine import through
from plogic.logic.served.program_child import reply_to, serve

load_problog()
signal.signal(signal.SIGINT, signal.default_int_handler)


def pytest_collection_finish(session):
    gc.collect()
    gc.freeze()
    gc.set_threshold(50_000, 20, 20)


@pytest.fixture
def programs_run_here():
    """Requests are served by the code of the child process, without starting one for each: no limits hold."""
    depth = sys.getrecursionlimit()
    with through(lambda request: json.loads(json.dumps(reply_to(json.loads(json.dumps(request)))))):
        yield
    sys.setrecursionlimit(depth)


@pytest.fixture
def served_here():
    """Requests are served by the same code as in the child process, without starting one for each."""
    with through(serve):
        yield


def pytest_unconfigure():
    """Libraries that count what is left at the end find nothing."""
    gc.unfreeze()
