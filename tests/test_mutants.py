"""The mutants: what mistakes are made of a line, and that each can be told from the code."""

from __future__ import annotations

import ast
import shutil
from pathlib import Path

import mutants
import pytest

HEAD = "def f(x, y):\n    "


@pytest.mark.parametrize(
    ("line", "made"),
    [
        ("return x < y", ["return None", "return x <= y"]),
        ("return x is None", ["return None", "return x is not None"]),
        ("x = y + 2", ["pass", "x = (y - 2)", "x = y + 3"]),
        ("x += 0.5", ["pass", "x += 1.0"]),
        ("f(x, y)", ["pass"]),
        ("if not x: pass", ["if (x): pass"]),
        ("if x and y: pass", ["if (x or y): pass"]),
        ("x: int = True", ["x: int = False"]),
        ("return None", []),
        ("'words'", []),
    ],
)
def test_a_line_and_the_mistakes_in_it(line, made):
    source = f"{HEAD}{line}\n".encode()
    assert [m.applied(source).decode().removeprefix(HEAD).strip() for m in mutants.mutants_of(source, "f.py")] == made


def test_places_are_counted_in_bytes():
    (mutant,) = mutants.mutants_of("'Σ', 'Γ', x > y\n".encode(), "f.py")
    assert mutant.applied("'Σ', 'Γ', x > y\n".encode()).decode() == "'Σ', 'Γ', x >= y\n"


PART = "geometry", "plogic/face/authoring", "plogic/face/commands", "plogic/scene"


def test_the_same_seed_draws_the_same_and_none_of_a_command(tmp_path):
    for folder in PART:
        shutil.copytree(mutants.ROOT / folder, tmp_path / folder, ignore=shutil.ignore_patterns("__pycache__"))
    first, second, other = (mutants.drawn(tmp_path, seed, 60) for seed in (1, 1, 2))
    assert first == second != other
    assert len(set(first)) == 60
    assert not any(mutant.file.startswith(mutants.LEFT_OUT) for mutant in first)
    for mutant in first:
        source = Path(mutants.ROOT, mutant.file).read_bytes()
        assert ast.dump(ast.parse(mutant.applied(source))) != ast.dump(ast.parse(source)), mutant


def test_every_test_is_in_one_stage_and_the_room_comes_before_the_rest():
    stages = list(mutants.stages(mutants.ROOT, "plogic/match/learned/sides.py"))
    every = [path for stage in stages for path in stage]
    assert sorted(every) == sorted(Path(mutants.ROOT, "tests").rglob("test_*.py"))
    assert len(set(every)) == len(every)
    assert all("match" in path.parts for path in stages[1])
