"""The public names of ``plogic``: they load when they are used, and the type checker sees them."""

from __future__ import annotations

import ast
import subprocess
import sys
from pathlib import Path

import pytest

import plogic


def test_every_public_name_loads_and_is_listed():
    assert {"Camera", "Gamma", "Interpretation", "KnowledgeBase", "Program", "Session", "detect", "perceive"} <= set(
        plogic.__all__
    )
    assert [name for name in plogic.__all__ if getattr(plogic, name) is None] == []
    assert set(plogic.__all__) <= set(dir(plogic))


def test_the_type_checker_sees_the_names_that_load():
    tree = ast.parse(Path(plogic.__file__).read_text(encoding="utf-8"))
    (branch,) = (node for node in tree.body if isinstance(node, ast.If))
    shown = {alias.asname or alias.name: f"{node.module}:{alias.name}" for node in branch.body for alias in node.names}
    loaded = {name: place if ":" in place else f"{place}:{name}" for name, place in plogic._PLACES.items()}
    assert shown == loaded
    assert sorted(loaded) == sorted(plogic.__all__)


def test_an_unknown_name_is_an_attribute_error():
    with pytest.raises(AttributeError, match="has no attribute 'percieve'"):
        _ = plogic.percieve


def test_import_alone_loads_nothing():
    code = "import sys; before = set(sys.modules); import plogic; print(sorted(set(sys.modules) - before))"
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True, timeout=60)
    assert ast.literal_eval(run.stdout) == ["plogic"]


def test_import_alone_takes_no_time():
    code = "import time; t = time.perf_counter(); import plogic; print(time.perf_counter() - t)"
    times = [
        float(subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout)
        for _ in range(3)
    ]
    assert min(times) <= 0.05
