"""``plogic bench start``: how long the commands that people use most take, from their start to their end.

Beside each stands ``python -c "import numpy"``, in the same minute. ``peer``: the console script of another plogic, as
of the version before, is run in turn with ours.
"""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
import tempfile
from dataclasses import dataclass, field
from pathlib import Path
from time import perf_counter
from typing import TYPE_CHECKING, Any

from benchmarks.shared.claims import Claim, report
from benchmarks.shared.processor import processor_seconds

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence

CAPTION = (
    "processor seconds of whole processes, the least of their runs; `numpy`: python -c 'import numpy' in the same rounds.\n"
    "`perceive, search aside`: without the share of its wall time that --timings gives to the search."
)
ROUNDS, FEW = 7, 2
GOAL = "partially_occludes(X, Y)"
COMMANDS: Mapping[str, tuple[str, ...]] = {
    "--help": ("--help",),
    "demo": ("demo", "-o", "again"),
    "perceive": ("perceive", "demo/image.png", "--kb", "towers", "--camera", "demo/camera.json", "-o", "i.json"),
    "perceive a Γ": ("perceive", "demo/gamma.json", "--kb", "towers", "-o", "j.json"),
    "worlds": ("worlds", "demo/interpretation.json"),
    "query": ("query", "demo/interpretation.json", GOAL),
    "explain": ("explain", "demo/interpretation.json", "present(h1)"),
    "report": ("report", "demo/interpretation.json", "-o", "page.html"),
    "query a program": ("query", "alarm.pl"),
    "kb check": ("kb", "check", "towers"),
    "kb show": ("kb", "show", "towers"),
    "simulate": ("simulate", "--kb", "towers", "-o", "scene"),
}
"""Twelve, in a folder in which ``plogic demo -o demo`` was run, with a copy of ``examples/alarm.pl``."""
NEW = "again", "scene"
"""Folders that a command makes."""
ASIDE = "perceive, search aside"
HELP, ASIDE_SHARE, KEPT = 0.3, 0.6, 1.1
"""Seconds of ``--help``; what is left of ``perceive`` of the peer's; ``worlds`` and ``query`` stay as fast."""


@dataclass(frozen=True)
class Side:
    """``script``, the console script of one plogic, the ``folder`` in which it works, and its environment."""

    script: Path
    folder: Path
    environment: Mapping[str, str] = field(default_factory=lambda: dict(os.environ))

    def seconds(self, name: str) -> dict[str, float]:
        """Processor seconds of a command by its name; of ``perceive`` also those of all but the search.

        Raises RuntimeError where it fails.
        """
        for folder in NEW:
            shutil.rmtree(self.folder / folder, ignore_errors=True)
        if name != "perceive":
            return {name: self.run(COMMANDS[name])[0]}
        used, wall = self.run((*COMMANDS[name], "--timings", "t.json"))
        search = json.loads((self.folder / "t.json").read_text(encoding="utf-8"))["seconds"]["search"]
        return {name: used, ASIDE: used * (1.0 - search / wall)}

    def run(self, arguments: Sequence[str]) -> tuple[float, float]:
        """Seconds of the processor and of the wall clock."""
        return _run([str(self.script), *arguments], self.folder, self.environment)


def _run(command: list[str], folder: Path, environment: Mapping[str, str]) -> tuple[float, float]:
    before, start = processor_seconds(), perf_counter()
    done = subprocess.run(  # noqa: S603 - our own
        command, cwd=folder, env=dict(environment), capture_output=True, text=True, check=False
    )
    used, wall = processor_seconds() - before, perf_counter() - start
    if done.returncode:
        raise RuntimeError(f"{' '.join(command)}: {done.stderr.strip()}")
    return used, wall


def run(*, seed: int, quick: bool, peer: Path | None, as_json: bool, say: Callable[[str], None]) -> tuple[str, bool]:
    """Run the benchmark; ``seed`` is of no use to it."""
    del seed
    with tempfile.TemporaryDirectory() as place:
        sides = {"plogic": _side(Path(sys.executable).with_name("plogic"), Path(place, "ours"), os.environ)}
        if peer is not None:
            sides["peer"] = _side(peer.absolute(), Path(place, "theirs"), of_peer(os.environ))
        rows = [row for name in COMMANDS for row in _rows(name, sides, FEW if quick else ROUNDS, say)]
    text, met = report("start", rows, claims(rows), as_json=as_json)
    return (text if as_json else f"{CAPTION}\n\n{text}"), met


def of_peer(environment: Mapping[str, str]) -> dict[str, str]:
    """An environment without PYTHONPATH, which may lead to our own code: then the peer would be we ourselves."""
    return {name: value for name, value in environment.items() if name != "PYTHONPATH"}


def _side(script: Path, folder: Path, environment: Mapping[str, str]) -> Side:
    """The side made ready: what a command reads is there."""
    folder.mkdir()
    shutil.copy(Path(__file__).resolve().parents[2] / "examples" / "alarm.pl", folder)
    side = Side(script, folder, environment)
    side.run(("demo", "-o", "demo"))
    return side


def _rows(name: str, sides: Mapping[str, Side], rounds: int, say: Callable[[str], None]) -> list[dict[str, Any]]:
    """Round by round each side in turn; a first round that is not counted fills the caches."""
    least: dict[str, dict[str, float]] = {}
    for number in range(rounds + 1):
        numpy, _ = _run([sys.executable, "-c", "import numpy"], Path.cwd(), os.environ)
        for side, one in sides.items():
            for row, seconds in one.seconds(name).items():
                if number:
                    found = least.setdefault(row, {})
                    for column, value in ((side, seconds), ("numpy", numpy)):
                        found[column] = min(value, found.get(column, value))
    say(f"{name}: {least[name]['plogic']:.2f} s")
    return [_row(row, found) for row, found in least.items()]


def _row(name: str, found: Mapping[str, float]) -> dict[str, Any]:
    row: dict[str, Any] = {"command": name, **{column: round(value, 3) for column, value in found.items()}}
    return row | ({"of peer's": round(found["plogic"] / found["peer"], 2)} if "peer" in found else {})


def claims(rows: Sequence[Mapping[str, Any]]) -> list[Claim]:
    """``--help`` answers at once; beside a peer: the way to ``perceive`` is shorter, and nothing has become slow."""
    by_name = {row["command"]: row for row in rows}
    made = [Claim("plogic --help: seconds of the processor", "<=", HELP, by_name["--help"]["plogic"])]
    if "peer" in by_name["--help"]:
        made.append(Claim(f"{ASIDE}: of the peer's", "<=", ASIDE_SHARE, by_name[ASIDE]["of peer's"]))
        made += [
            Claim(f"{name}: of the peer's", "<=", KEPT, by_name[name]["of peer's"]) for name in ("worlds", "query")
        ]
    return made
