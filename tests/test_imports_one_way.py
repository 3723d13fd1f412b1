"""Imports run one way: geometry ← kb ← sensing ← plogic ← cli; no library prints, and importing one does nothing."""

from __future__ import annotations

import ast
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
ORDER = ("geometry", "kb", "sensing", "plogic", "cli")
FILES = [ROOT / "cli.py", *sorted(path for layer in ORDER[:-1] for path in (ROOT / layer).rglob("*.py"))]
NAMES_ONLY = frozenset({"kb.errors"})
"""What of the KB ``sensing`` may know: type names come as plain strings, so that no more than this is ever needed."""


def layer_of(path):
    return path.relative_to(ROOT).parts[0].removesuffix(".py")


def imports(path):
    """Every module that a file names in an import, wherever it stands: at the top, in a function, for the type checker alone."""
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.Import):
            yield from ((alias.name, node.lineno) for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            assert not node.level, f"{path}:{node.lineno}: a relative import"
            yield node.module, node.lineno


def ours():
    """(file, line, its layer, the module, the module's layer) of every import of our own packages."""
    for path in FILES:
        for module, line in imports(path):
            if module.split(".")[0] in ORDER:
                yield path.relative_to(ROOT), line, layer_of(path), module, module.split(".")[0]


def test_imports_run_one_way():
    found = list(ours())
    assert len(found) > 200, "the files have been read"
    assert [
        f"{file}:{line}: {module}"
        for file, line, here, module, there in found
        if ORDER.index(there) > ORDER.index(here)
    ] == []


def test_every_layer_is_looked_at():
    assert {layer_of(path) for path in FILES} == set(ORDER)


def test_evidence_is_blind_to_object_types():
    """``sensing`` may know the KB's type names, never its object types (the house's rule)."""
    found = [
        f"{file}:{line}: {module}" for file, line, here, module, there in ours() if (here, there) == ("sensing", "kb")
    ]
    assert [place for place in found if place.split(": ")[1] not in NAMES_ONLY] == []


def test_geometry_knows_no_packages_of_ours():
    assert {there for _, _, here, _, there in ours() if here == "geometry"} == {"geometry"}


def test_no_library_prints():
    calls = [
        f"{path.relative_to(ROOT)}:{node.lineno}"
        for path in FILES
        for node in ast.walk(ast.parse(path.read_text()))
        if isinstance(node, ast.Call)
        and isinstance(node.func, ast.Name)
        and node.func.id in ("print", "pprint", "breakpoint")
    ]
    assert calls == []


def test_an_init_hands_names_on_and_does_nothing_else():
    for path in (p for p in FILES if p.name == "__init__.py"):
        statements = ast.parse(path.read_text()).body
        allowed = all(
            isinstance(s, (ast.Import, ast.ImportFrom))
            or (isinstance(s, ast.Expr) and isinstance(s.value, ast.Constant))
            or _is_all(s)
            for s in statements
        )
        assert allowed, path


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
