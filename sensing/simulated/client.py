"""One pybullet client per use, closed afterwards, without a word on standard output; and whether there is pybullet at all.

It has wheels for CPython 3.11 on x86-64 Linux; its fork ``pybullet-arm64``, a module of the same name, has them for 3.12
and 3.13 and for macOS on Arm. Elsewhere pictures are drawn by rays, and nothing settles or is held.
"""

from __future__ import annotations

import os
import sys
from contextlib import contextmanager
from importlib.metadata import PackageNotFoundError, version
from importlib.util import find_spec
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from collections.abc import Iterator

DISTRIBUTIONS = "pybullet", "pybullet-arm64"
INSTALL = "pip install pybullet (CPython 3.11 on x86-64 Linux) or pybullet-arm64 (3.12, 3.13; macOS on Arm)"
"""What a user can do who needs physics."""
NO_PHYSICS = "pybullet is not installed"


def has_physics() -> bool:
    """Whether pybullet is installed."""
    return find_spec("pybullet") is not None


def physics_version() -> str:
    """The distribution and its version, ``pybullet 3.2.7``; empty where there is none."""
    for name in DISTRIBUTIONS if has_physics() else ():
        try:
            return f"{name} {version(name)}"
        except PackageNotFoundError:
            continue
    return ""


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
