"""The process's own alarm: what is called now and then while a block runs, however long a step of it takes.

An alarm and no thread, for the block may make copies of its process.
"""

import signal
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from threading import current_thread, main_thread

TICK = 1.0
"""Seconds between two calls: what counts whole seconds shows each of them."""


@contextmanager
def alarmed(tell: Callable[[], None], first: float, then: float) -> Iterator[None]:
    """Call ``tell`` after ``first`` seconds of the block, and every ``then`` seconds from there.

    It is called between two steps of the interpreter, wherever that is. Never beside another alarm, nor in a thread of
    somebody's program.
    """
    if current_thread() is not main_thread() or signal.getsignal(signal.SIGALRM) is not signal.SIG_DFL:
        yield
        return
    signal.signal(signal.SIGALRM, lambda *_: tell())
    signal.setitimer(signal.ITIMER_REAL, first, then)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        signal.signal(signal.SIGALRM, signal.SIG_DFL)
