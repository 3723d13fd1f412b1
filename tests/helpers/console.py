"""The console script, run as a user would: ``plogic("worlds", file)``."""

from __future__ import annotations

import atexit
import json
import os
import select
import signal
import subprocess
import sys
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from so_far import without_so_far

BIN = Path(sys.executable).parent
SECONDS = 120
"""More than any command of these tests takes, so that one that hangs fails."""


READ_LATE = frozenset({"XDG_CACHE_HOME", "XDG_STATE_HOME", "NO_COLOR", "PLOGIC_TRACEBACK", "COLUMNS", "TERM", "HOME"})
"""Variables that are read while a command runs, not while Python starts or packages are imported."""
FEWER = """\
import os
import kb.clouds.words as words
import kb.learning.observations as views
count = int(os.environ.get("TEST_DIRECTIONS", "26"))
views.PIXELS, views.DIRECTIONS, views.PICTURES = (160.0, 90.0), count, 3
words.MOST = 256
"""
"""Read by Python as it starts: the console script itself is as it is, its views and words are fewer and smaller."""


def few_views(folder: Path) -> dict[str, str]:
    """Variables with which a type is learned from few and small views, and kept below ``folder``."""
    if not (folder / "sitecustomize.py").exists():
        (folder / "sitecustomize.py").write_text(FEWER)
    return {"PYTHONPATH": str(folder), "XDG_CACHE_HOME": str(folder / "cache")}


def plogic(
    *args: object, cwd: Path | None = None, stdin: str | None = None, **env: str
) -> subprocess.CompletedProcess[str]:
    """Run the script; stdin is empty unless given.

    It runs in a copy of a process that has imported everything (``copied_commands``); in one that starts afresh where a
    variable is given that may matter before, ``PYTHONHASHSEED`` for one.
    """
    variables = {key: value for key, value in os.environ.items() if key not in ("NO_COLOR", "PLOGIC_TRACEBACK")} | env
    command = [str(BIN / "plogic"), *map(str, args)]
    few = (Path(env.get("PYTHONPATH", "")) / "sitecustomize.py").is_file()
    if env.keys() <= READ_LATE | ({"PYTHONPATH", "TEST_DIRECTIONS"} if few else set()):
        return _copies().run(command, str(cwd or Path.cwd()), stdin or "", variables)
    return subprocess.run(
        command, cwd=cwd, input=stdin or "", capture_output=True, text=True, timeout=SECONDS, check=False, env=variables
    )


@cache
def _copies() -> _Copies:
    """The process that is copied, started when it is first needed."""
    return _Copies()


class _Copies:
    """A running ``copied_commands``: one command at a time."""

    def __init__(self) -> None:
        command = [sys.executable, str(Path(__file__).with_name("copied_commands.py"))]
        self._server = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE)
        atexit.register(self._end)

    def _end(self) -> None:
        with self._server:  # which closes its stdin
            pass

    def run(
        self, command: list[str], cwd: str, stdin: str, environment: dict[str, str]
    ) -> subprocess.CompletedProcess[str]:
        """As ``subprocess.run`` with captured text."""
        with TemporaryDirectory(prefix="console-") as folder:
            streams = Path(folder)
            (streams / "stdin").write_text(stdin)
            for name in ("stdout", "stderr"):
                (streams / name).touch()
            request = {"command": command, "cwd": cwd, "environment": environment, "streams": folder}
            os.write(self._server.stdin.fileno(), json.dumps(request).encode() + b"\n")
            copy = int(self._line())
            if not select.select([self._server.stdout], [], [], SECONDS)[0]:
                os.killpg(copy, signal.SIGKILL)
                self._line()
                raise subprocess.TimeoutExpired(command, SECONDS)
            status = int(self._line())
            return subprocess.CompletedProcess(
                command, status, (streams / "stdout").read_text(), without_so_far((streams / "stderr").read_text())
            )

    def _line(self) -> bytes:
        line = b""
        while not line.endswith(b"\n"):
            piece = os.read(self._server.stdout.fileno(), 1)
            assert piece, "the process that is copied has ended"
            line += piece
        return line


def good(*args: object, cwd: Path | None = None, stdin: str | None = None, **env: str) -> str:
    """The stdout of a command that must succeed."""
    done = plogic(*args, cwd=cwd, stdin=stdin, **env)
    assert done.returncode == 0, done.stderr
    return done.stdout


def document(*args: object, cwd: Path | None = None, stdin: str | None = None, **env: str) -> dict[str, Any]:
    """The one JSON document on stdout of a command that must succeed."""
    return json.loads(good(*args, cwd=cwd, stdin=stdin, **env), parse_constant=_no_json)


def _no_json(constant: str) -> float:
    raise AssertionError(f"{constant} is no JSON")


def bytes_in(folder: Path) -> dict[str, bytes | None]:
    """Every path below a folder with its bytes (None: a folder), hidden ones included.

    What nothing-written is held against.
    """
    return {str(p.relative_to(folder)): p.read_bytes() if p.is_file() else None for p in sorted(folder.rglob("*"))}
