"""The doors through which a program comes: a file, a goal, evidence, rules, a knowledge base, a line of the shell.

``words_of(program, folder, way)`` are the words of the command; the files that it needs are in the folder then.
"""

from __future__ import annotations

import json
import shutil
from typing import TYPE_CHECKING

from benchmarks.fuzz import seeds

if TYPE_CHECKING:
    from pathlib import Path

    from benchmarks.fuzz.hostile.program import Hostile

DEADLINES = {True: 2.0, False: 20.0}
"""Seconds that a bomb is given, and what is none and is to come as far as it can, where a command takes a deadline."""
DEFAULT = 60.0
"""Seconds of an inference where it takes none (``plogic.logic.served.engine.Limits``)."""
BASE = "0.5::a.\nb.\nquery(a).\n"
"""A harmless program, beside which goals, evidence and rules come."""
SHOWN = ("--deadline", "{deadline}")
DOORS: dict[str, tuple[str, ...]] = {
    "query": ("query", "p.pl", *SHOWN),
    "asked": ("query", "p.pl", "{goal}", *SHOWN),
    "worlds": ("worlds", "p.pl", "-n", "3", *SHOWN),
    "json": ("query", "p.pl", "--json", *SHOWN),
    "explain": ("explain", "p.pl", "{goal}"),
    "asked in the shell": ("shell", "p.pl"),
    "goal": ("query", "base.pl", "{text}", *SHOWN),
    "scene goal": ("query", "interpretation.json", "{text}", *SHOWN),
    "given": ("query", "base.pl", "a", "--given", "{text}", *SHOWN),
    "scene given": ("worlds", "interpretation.json", "--given", "{text}", *SHOWN),
    "rules": ("query", "base.pl", "a", "--rules", "p.pl", *SHOWN),
    "scene rules": ("query", "interpretation.json", "{goal}", "--rules", "p.pl", *SHOWN),
    "interpretation": ("query", "interpretation.json", "{goal}", *SHOWN),
    "kb": ("kb", "check", "kb"),
    "perceive": ("perceive", "gamma.json", "--kb", "kb", "-o", "-", *SHOWN),
    "shell": ("shell", "base.pl"),
    "trusted": ("query", "p.pl", "--trust", *SHOWN),
}
"""Door → the words of its command. By the last, which no program takes, a test sees that misdeeds are seen."""
HARMLESS = {
    **dict.fromkeys(("query", "asked", "worlds", "json", "explain", "asked in the shell", "trusted"), BASE),
    "goal": "b, a", "scene goal": "present(h1)", "given": "b", "scene given": "present(h1)", "rules": "c :- b. evidence(c).",
    "scene rules": "constraint(x) :- present(_), fail.", "interpretation": "constraint(x) :- present(_), fail.",
    "kb": "constraint(x) :- present(_), fail.", "perceive": "constraint(x) :- present(_), fail.", "shell": "ask b\nworlds\n",
}  # fmt: skip
"""Door → what is harmless there: how long its command takes to start, and which files it opens."""
SLOW_DOORS = {"explain": DEFAULT, "asked in the shell": 3 * DEFAULT, "kb": DEFAULT}


def door_of(program: Hostile, number: int) -> str:
    """Which door a program comes through; the ways of a file are taken in turn, a bomb's by those with a deadline."""
    if program.door != "program":
        return program.door
    ways = (
        ("query", "asked", "worlds", "json")
        if program.bomb
        else ("query", "asked", "worlds", "json", "explain", "asked in the shell")
    )
    return ways[number % len(ways)]


def limit_of(door: str, text: str, *, bomb: bool) -> float:
    """Seconds that its inferences may take together."""
    return DEFAULT * len(text.splitlines()) if door == "shell" else SLOW_DOORS.get(door, DEADLINES[bomb])


def goal_of(program: Hostile) -> str:
    """What is asked: a file's own last query, where it has one."""
    start = program.text.rfind("query(")
    end = program.text.find(").", start)
    return program.text[start + 6 : end] if program.door == "program" and 0 <= start < end else program.asked


def prepare(folder: Path, door: str, text: str, goal: str, limit: float) -> list[str]:
    """Write what a command needs, and return its words."""
    words = DOORS[door]
    (folder / "base.pl").write_text(BASE)
    (folder / "p.pl").write_text(text, encoding="utf-8", newline="")
    document = json.loads(seeds.example("interpretation.json")[0])
    if door == "interpretation":
        document["rules"] = text
    (folder / "interpretation.json").write_text(json.dumps(document))
    if "kb" in words:
        (folder / "gamma.json").write_bytes((seeds.EXAMPLES / "first_gamma.json").read_bytes())
        shutil.copytree(seeds.ROOT / "kb" / "first", folder / "kb")
        (folder / "kb" / "rules.pl").write_text(text, encoding="utf-8")
    lines = {"shell": text, "asked in the shell": f"ask {goal}\nworlds 3\nwhy {goal}\n"}
    (folder / ".in").write_text(lines.get(door, ""), encoding="utf-8")
    said = {"{text}": text, "{goal}": goal, "{deadline}": f"{limit:g}"}
    return [said.get(word, word) for word in words]
