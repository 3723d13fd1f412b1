"""The console script, run as a user would: ``plogic("worlds", file)``."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

BIN = Path(sys.executable).parent
SECONDS = 120
"""More than any command of these tests takes, so that one that hangs fails."""


def plogic(
    *args: object, cwd: Path | None = None, stdin: str | None = None, **env: str
) -> subprocess.CompletedProcess[str]:
    """Run the script; stdin is empty unless given."""
    variables = {key: value for key, value in os.environ.items() if key not in ("NO_COLOR", "PLOGIC_TRACEBACK")} | env
    command = [str(BIN / "plogic"), *map(str, args)]
    return subprocess.run(
        command, cwd=cwd, input=stdin or "", capture_output=True, text=True, timeout=SECONDS, check=False, env=variables
    )


def good(*args: object, cwd: Path | None = None, stdin: str | None = None, **env: str) -> str:
    """The stdout of a command that must succeed."""
    done = plogic(*args, cwd=cwd, stdin=stdin, **env)
    assert done.returncode == 0, done.stderr
    return done.stdout


def document(*args: object, cwd: Path | None = None, stdin: str | None = None) -> dict[str, Any]:
    """The one JSON document on stdout of a command that must succeed."""
    return json.loads(good(*args, cwd=cwd, stdin=stdin), parse_constant=_no_json)


def _no_json(constant: str) -> float:
    raise AssertionError(f"{constant} is no JSON")


def bytes_in(folder: Path) -> dict[str, bytes | None]:
    """Every path below a folder with its bytes (None: a folder), hidden ones included: what nothing-written is held against."""
    return {str(p.relative_to(folder)): p.read_bytes() if p.is_file() else None for p in sorted(folder.rglob("*"))}
