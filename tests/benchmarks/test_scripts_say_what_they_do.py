"""Each script of ``benchmarks/`` answers ``--help`` and refuses what it does not know, in place of a traceback."""

import json
import subprocess
import sys
from pathlib import Path

import pytest

FOLDER = Path(__file__).parent.parent.parent / "benchmarks"
SCRIPTS = sorted(path.name for path in FOLDER.glob("*.py") if "__main__" in path.read_text())
ARGUMENTS = {"--help": 0, "--odd": 2}
ONE_AFTER_THE_OTHER = """
import contextlib, io, json, runpy, sys, traceback
told, arguments, paths = {}, sys.argv[1].split(), sys.argv[2:]
for path in paths:
    for argument in arguments:
        out, status = io.StringIO(), 0
        sys.argv, sys.path[0] = [path, argument], path.rpartition("/")[0]
        with contextlib.redirect_stdout(out), contextlib.redirect_stderr(out):
            try:
                runpy.run_path(path, run_name="__main__")
            except SystemExit as end:
                status = end.code or 0
            except BaseException:
                traceback.print_exc()
                status = 1
        told[path.rpartition("/")[2] + argument] = status, out.getvalue()
print(json.dumps(told))
"""
"""A fresh interpreter: it runs each script with each argument, as if alone, and imports shared modules once."""


@pytest.fixture(scope="module")
def told():
    """By script and argument, the status and what was printed."""
    command = [
        sys.executable,
        "-c",
        ONE_AFTER_THE_OTHER,
        " ".join(ARGUMENTS),
        *(str(FOLDER / name) for name in SCRIPTS),
    ]
    run = subprocess.run(command, capture_output=True, text=True, check=False, timeout=120)
    assert run.returncode == 0, run.stderr
    return json.loads(run.stdout)


def test_there_are_scripts():
    assert len(SCRIPTS) >= 3


@pytest.mark.parametrize("script", SCRIPTS)
@pytest.mark.parametrize("argument", ARGUMENTS)
def test_a_script(told, script, argument):
    status, text = told[script + argument]
    assert status == ARGUMENTS[argument], text
    assert "usage: " in text
    assert "Traceback" not in text
