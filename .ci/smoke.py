"""A user's first commands, on one Python beside another.

``smoke.py inputs DIR`` writes a textured mesh and a Γ. ``smoke.py answers INPUTS OUT`` runs the commands with the
plogic beside this Python, ``asked INPUTS OUT`` those alone that answer from the Γ. ``smoke.py compare A B`` holds the
answers of two such runs against each other.
"""
# ruff: noqa: INP001, T201, S603 - a script of our own, no package

from __future__ import annotations

import json
import platform
import shutil
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
PLOGIC = Path(sys.executable).parent / "plogic"
SAME = 1e-6
"""Probabilities are compared to this: other versions of numpy round otherwise."""
ASKED = {
    "worlds.json": ["worlds", "box.json", "--json"],
    "present.json": ["query", "box.json", "present(X)", "--json"],
    "missed.json": ["query", "box.json", "case(h1, F, c)", "--json"],
}


def inputs(folder: Path) -> None:
    """A painted cube as a mesh with its texture, and the Γ of examples/."""
    sys.path[:0] = [str(ROOT), str(ROOT / "tests" / "helpers")]
    from painted_cube import write_cube

    folder.mkdir(parents=True)
    write_cube(folder, units_per_metre=10.0)  # a metre wide: scenes are that large
    shutil.copy(ROOT / "examples" / "first_gamma.json", folder / "gamma.json")


def asked(given: Path, out: Path) -> None:
    """Perceive the Γ and ask about it."""
    out.mkdir(parents=True, exist_ok=True)
    plogic(out, "perceive", str(given.resolve() / "gamma.json"), "--kb", "first", "-o", "box.json")
    for name, command in ASKED.items():
        (out / name).write_text(plogic(out, *command), encoding="utf-8")


def answers(given: Path, out: Path) -> None:
    """Run demo, kb add, kb learn, simulate and perceive too."""
    asked(given, out)
    plogic(out, "demo", "-o", "demo")
    plogic(out, "kb", "add", "cube", "--mesh", str(given.resolve() / "cube.obj"), "--units", "m", "--kb", "kb")
    plogic(out, "kb", "learn", "--kb", "kb", "--detector", "orb")
    plogic(out, "simulate", "--kb", "kb", "--objects", "1", "-o", "scene")
    plogic(out, "perceive", "scene/image.png", "--kb", "kb", "--camera", "scene/camera.json", "-o", "scene.json")
    found = [h["type"] for h in json.loads((out / "scene.json").read_text())["hypotheses"] if h["status"] == "accepted"]
    print(
        f"Python {platform.python_version()}, {out.name}: demo, kb, simulate, perceive, worlds and query work; seen: {found}"
    )


def plogic(folder: Path, *args: str) -> str:
    """Run the command in a folder and return what it prints; exits where it fails."""
    done = subprocess.run([str(PLOGIC), *args], cwd=folder, capture_output=True, text=True, check=False)
    if done.returncode:
        sys.exit(
            f"plogic {' '.join(args)}: exit {done.returncode} on Python {platform.python_version()}\n{done.stderr}"
        )
    return done.stdout


def compare(one: Path, other: Path) -> None:
    """Exit with what differs between two runs' answers for the same Γ."""
    wrong = [
        name for name in ASKED if not same(json.loads((one / name).read_text()), json.loads((other / name).read_text()))
    ]
    if wrong:
        sys.exit(f"{other.name}: not the answers of the first Python: {', '.join(wrong)}")
    print(f"{other.name}: the answers of the first Python")


def same(one: object, other: object) -> bool:
    """Whether two JSON values are the same, numbers to ``SAME``."""
    if isinstance(one, float) and isinstance(other, float):
        return abs(one - other) <= SAME
    if isinstance(one, dict) and isinstance(other, dict):
        return one.keys() == other.keys() and all(same(one[key], other[key]) for key in one)
    if isinstance(one, list) and isinstance(other, list):
        return len(one) == len(other) and all(map(same, one, other))
    return one == other


if __name__ == "__main__":
    {"inputs": inputs, "answers": answers, "asked": asked, "compare": compare}[sys.argv[1]](*map(Path, sys.argv[2:]))
