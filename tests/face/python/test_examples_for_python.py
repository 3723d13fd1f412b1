"""The notebook and the test among the examples run as they are."""

from __future__ import annotations

import ast
import json
import subprocess
import sys
from pathlib import Path

EXAMPLES = Path(__file__).parents[3] / "examples"


def shown(source, names):
    """Run one cell; what a notebook shows of its last expression."""
    tree = ast.parse(source)
    last = tree.body.pop() if isinstance(tree.body[-1], ast.Expr) else None
    exec(compile(tree, "cell", "exec"), names)  # noqa: S102 - the cells of our own notebook
    if last is None:
        return None
    value = eval(compile(ast.Expression(last.value), "cell", "eval"), names)  # noqa: S307
    html, png = getattr(value, "_repr_html_", None), getattr(value, "_repr_png_", None)
    return html() if html else png() if png else repr(value)


def test_the_notebook_runs_and_every_cell_shows_something(monkeypatch):
    monkeypatch.chdir(EXAMPLES)
    notebook = json.loads((EXAMPLES / "quickstart.ipynb").read_text(encoding="utf-8"))
    names: dict[str, object] = {}
    cells = ["".join(cell["source"]) for cell in notebook["cells"] if cell["cell_type"] == "code"]
    found = [shown(cell, names) for cell in cells]
    assert len(found) == 10
    assert [cell for cell, value in zip(cells, found, strict=True) if not value] == []
    assert found[-1].startswith(b"\x89PNG")


def test_the_measures_are_compared_in_pytest(tmp_path):
    command = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", str(EXAMPLES / "test_measures.py")]
    run = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False, timeout=120)
    assert run.returncode == 0, run.stdout + run.stderr
    assert "..." in run.stdout
