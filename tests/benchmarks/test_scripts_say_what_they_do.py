"""Each script of ``benchmarks/`` answers ``--help`` and refuses what it does not know, in place of a traceback."""

import subprocess
import sys
from pathlib import Path

import pytest

FOLDER = Path(__file__).parent.parent.parent / "benchmarks"
SCRIPTS = sorted(path.name for path in FOLDER.glob("*.py") if "__main__" in path.read_text())


@pytest.mark.parametrize("script", SCRIPTS)
@pytest.mark.parametrize(("argument", "status"), [("--help", 0), ("--odd", 2)])
def test_a_script(script, argument, status):
    run = subprocess.run(
        [sys.executable, FOLDER / script, argument], capture_output=True, text=True, check=False, timeout=60
    )
    assert run.returncode == status, run.stderr
    assert "usage: " in run.stdout + run.stderr
    assert "Traceback" not in run.stderr
