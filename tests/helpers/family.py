"""A process that starts children of every kind and tells their numbers; then it waits to be killed.

Run as ``family.py KIND``.

As ``family.py child``, one that sleeps, having started another.
"""

from __future__ import annotations

import os
import resource
import sys
import time
from pathlib import Path

from plogic.base import children
from plogic.base.children import Child, Copy, begin

HERE = str(Path(__file__).resolve())


def sleeper():
    """Begin, start one more, tell both numbers, and sleep."""
    begin()
    inner = Child(["sleep", "600"], told=b"", foreign=True)
    tell(os.getpid(), inner.pid)
    time.sleep(600)


def hungry():
    """Begin, take memory until there is none, tell how much of address space that is, and keep it."""
    begin()
    tell(_fed())
    time.sleep(600)


def _fed():
    held = []
    try:
        while True:
            held.append(bytearray(1 << 20))
    except MemoryError:
        soft = resource.getrlimit(resource.RLIMIT_AS)[0]
    return soft


def told(child):
    """The numbers in a child's first line."""
    line = b""
    while not line.endswith(b"\n"):
        line += child.read()
    return [int(word) for word in line.split()]


def tell(*words):
    """A line."""
    sys.stdout.write(" ".join(map(str, words)) + "\n")
    sys.stdout.flush()


def parent(kind):
    """Start some of a kind, tell their numbers, and sleep."""
    if kind == "watched":
        children._bound = lambda *_: None
    if kind == "copy":
        copy = Copy(time.sleep, 600)
        tell(copy._process.pid)
    else:
        child = Child([sys.executable, HERE, "watched child" if kind == "watched" else "child"])
        tell(*told(child), child.folder)
    time.sleep(600)


def limited(megabytes, count):
    """With so much memory: the limits of this process and of so many children, each of which takes all that it gets."""
    limit = megabytes << 20
    resource.setrlimit(resource.RLIMIT_AS, (limit, limit))
    others = [Child([sys.executable, HERE, "hungry"]) for _ in range(count)]
    shares = [told(child)[0] for child in others]
    own = resource.getrlimit(resource.RLIMIT_AS)[0]
    for child in others:
        child.end()
    tell(limit, own, *shares, resource.getrlimit(resource.RLIMIT_AS)[0])


if __name__ == "__main__":
    what = sys.argv[1]
    if what == "watched child":
        children._asked_system = lambda: False
    if what.endswith("child"):
        sleeper()
    elif what == "hungry":
        hungry()
    elif what == "limited":
        limited(int(sys.argv[2]), int(sys.argv[3]))
    else:
        parent(what)
