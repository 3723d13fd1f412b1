"""One pybullet client per use, closed afterwards, without a word on standard output."""

from __future__ import annotations

import os
import sys
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from collections.abc import Iterator


@contextmanager
def quiet() -> Iterator[None]:
    """Send file descriptors 1 and 2 to nowhere meanwhile: pybullet's C code prints a banner and warnings past ``sys.stdout``."""
    sys.stdout.flush()
    sys.stderr.flush()
    saved = [os.dup(1), os.dup(2)]
    nowhere = os.open(os.devnull, os.O_WRONLY)
    try:
        os.dup2(nowhere, 1)
        os.dup2(nowhere, 2)
        yield
    finally:
        _flush_c()
        os.dup2(saved[0], 1)
        os.dup2(saved[1], 2)
        for descriptor in (*saved, nowhere):
            os.close(descriptor)


@contextmanager
def client() -> Iterator[tuple[Any, int]]:
    """Yield ``(pybullet, id)`` of a fresh DIRECT client; it is disconnected on the way out."""
    with quiet():
        import pybullet

        number = pybullet.connect(pybullet.DIRECT)
        try:
            yield pybullet, number
        finally:
            pybullet.disconnect(physicsClientId=number)


def _flush_c() -> None:
    """C's own buffers hold the banner back until they are flushed; flush them while the descriptors still lead nowhere."""
    import ctypes

    ctypes.CDLL(None).fflush(None)
