"""A process that starts children of every kind and tells their numbers; then it waits to be killed.

Run as ``family.py KIND``.

As ``family.py child``, one that sleeps, having started another.
"""

from __future__ import annotations

import os
import sys
import time
from pathlib import Path

from plogic.base import children, memory
from plogic.base.children import Child, Copy, begin

HERE = str(Path(__file__).resolve())


def sleeper():
    """Begin, start one more, tell both numbers, and sleep."""
    begin()
    inner = Child(["sleep", "600"], told=b"")
    tell(os.getpid(), inner.pid)
    time.sleep(600)


def hungry(*sizes):
    """Begin, have children of all but the first size, take so many MB oneself, and keep them."""
    begin()
    others = [Child([sys.executable, HERE, "hungry", size]) for size in sizes[1:]]
    held = [b"x" * (1 << 20) for _ in range(int(sizes[0]))]
    for child in others:
        told(child)
    tell(len(held))
    time.sleep(600)


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


def limited(most, *sizes):
    """With a limit of so many MB and children of these sizes: how each of them ends, where one is ended."""
    memory.hold(most << 20)
    others = [Child([sys.executable, HERE, "hungry", str(size)]) for size in sizes]
    for child in others:
        child.read()  # it has taken all, or is killed
    time.sleep(1.0)
    tell(*(child.end().replace(" ", "_") for child in others))


if __name__ == "__main__":
    what = sys.argv[1]
    if what == "watched child":
        children._asked_system = lambda: False
    if what.endswith("child"):
        sleeper()
    elif what == "hungry":
        hungry(*sys.argv[2:])
    elif what == "limited":
        limited(*map(int, sys.argv[2:]))
    else:
        parent(what)
