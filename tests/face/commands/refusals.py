"""A command that must refuse its input, and what it says."""

from __future__ import annotations

from console import bytes_in, plogic

ONE = {"id": "a1", "type": "l_junction", "uv": [10.0, 20.0], "detector": "junction"}
"""An appearance."""


def refused(folder, *args, stdin=None):
    """The lines on stderr of a command that must fail on its input and leave its folder as it was."""
    before = bytes_in(folder)
    run = plogic(*args, cwd=folder, stdin=stdin)
    assert "Traceback" not in run.stderr
    assert "internal error" not in run.stderr
    assert (run.returncode, run.stdout) == (1, ""), run.stderr
    assert bytes_in(folder) == before
    lines = run.stderr.splitlines()
    assert all(line.startswith("plogic: ") for line in lines), run.stderr
    return [line.removeprefix("plogic: ") for line in lines]


def assert_lines(lines, wanted):
    """As many lines as mistakes, each mistake in one of them."""
    assert len(lines) == len(wanted), lines
    for part in wanted:
        assert sum(part in line for line in lines) == 1, lines
