"""Importing a library does nothing, no library prints, and an ``__init__`` hands names on.

What imports what is held by test_floors.py.
"""

from __future__ import annotations

import ast
import subprocess
import sys

import pytest
from architecture import ROOT, modules


def test_no_library_prints():
    calls = [
        f"{path.relative_to(ROOT)}:{node.lineno}"
        for path in modules().values()
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8")))
        if isinstance(node, ast.Call)
        and isinstance(node.func, ast.Name)
        and node.func.id in ("print", "pprint", "breakpoint")
    ]
    assert calls == []


def test_an_init_hands_names_on_and_does_nothing_else():
    found = [p for p in modules().values() if p.name == "__init__.py" and p.parent.name != "plogic"]
    assert len(found) > 1
    for path in found:
        statements_of = ast.parse(path.read_text(encoding="utf-8")).body
        allowed = all(
            isinstance(s, (ast.Import, ast.ImportFrom))
            or (isinstance(s, ast.Expr) and isinstance(s.value, ast.Constant))
            or _is_all(s)
            for s in statements_of
        )
        assert allowed, path


def test_the_init_of_plogic_holds_a_table_of_names_that_load_when_they_are_used():
    statements_of = ast.parse(modules()["plogic"].read_text(encoding="utf-8")).body
    text, flag, listed, branch = statements_of
    assert isinstance(text.value, ast.Constant)
    assert ast.unparse(flag) == "TYPE_CHECKING = False"
    assert _is_all(listed)
    assert ast.unparse(branch.test) == "TYPE_CHECKING"
    assert {type(s) for s in branch.body} == {ast.ImportFrom}
    table, *functions = branch.orelse
    assert [target.id for target in table.targets] == ["_PLACES"]
    assert [function.name for function in functions] == ["__getattr__", "__dir__"]


def _is_all(statement):
    return isinstance(statement, ast.Assign) and [ast.unparse(target) for target in statement.targets] == ["__all__"]


SCRIPT = """
import importlib, os, random, sys, threading
def state():
    variables = {k: v for k, v in os.environ.items() if k != 'LD_LIBRARY_PATH'}  # OpenCV's own doing
    return os.getcwd(), variables, random.getstate(), sorted(os.listdir()), threading.active_count()
before = state()
importlib.import_module(sys.argv[1])
assert state() == before, [i for i, (x, y) in enumerate(zip(before, state())) if x != y]
"""


@pytest.mark.parametrize(
    "module",
    [
        "geometry.camera",
        "kb.files.read",
        "sensing.detectors.detector",
        "plogic.run.perceive",
        "plogic.scene.asking.query",
        "cli",
    ],
)
def test_an_import_has_no_side_effects(module, tmp_path):
    run = subprocess.run(
        [sys.executable, "-c", SCRIPT, module], capture_output=True, text=True, check=False, cwd=tmp_path, timeout=60
    )
    assert (run.returncode, run.stdout, run.stderr) == (0, "", "")
    assert list(tmp_path.iterdir()) == []
