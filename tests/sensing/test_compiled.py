"""Compiled loops that are kept on disk: what is torn there is made anew, without a word."""

from __future__ import annotations

import os
import pickle
import subprocess
import sys
from importlib.util import module_from_spec, spec_from_file_location

import pytest

import sensing.compiled

SOURCE = """\
from sensing.compiled import compiled

@compiled({})
def added(a, b):
    return a + b
"""
SIZES = """\
import cv2, numba

def sizes():
    rows = dict(line.split(":", 1) for line in open("/proc/self/status"))
    return [int(rows[name].split()[0]) << 10 for name in ("VmSize", "VmData")]

first = sizes()
import sensing.views.loops, sensing.pixels.loops, sensing.pixels.painting, sensing.detectors.edge_loops
print(*(now - before for now, before in zip(sizes(), first)))
"""
"""Prints bytes of address space and of memory that our loops take."""
CUT = {
    "empty": lambda _: b"",
    "cut": lambda data: data[:-20],
    "cut at its head": lambda data: data[:3],
    "of something else": lambda _: pickle.dumps(3),
}


def called(file):
    """What a fresh process would be told: the module is imported once more."""
    spec = spec_from_file_location("adding", file)
    module = module_from_spec(spec)
    sys.modules["adding"] = module
    spec.loader.exec_module(module)
    return module.added(2, 3), sum(module.added.stats.cache_hits.values())


@pytest.mark.parametrize("signature", ["", '"i8(i8, i8)"'], ids=["when called", "at once"])
@pytest.mark.parametrize("suffix", ["nbi", "nbc"])
def test_what_is_torn_is_made_anew(tmp_path, signature, suffix, monkeypatch):
    monkeypatch.delitem(sys.modules, "adding", raising=False)
    file = tmp_path / "adding.py"
    file.write_text(SOURCE.format(signature))
    assert called(file) == (5, 0)
    assert called(file) == (5, 1)
    for cut in CUT.values():
        (kept,) = (tmp_path / "__pycache__").glob(f"*.{suffix}")
        kept.write_bytes(cut(kept.read_bytes()))
        assert called(file) == (5, 0)
        assert called(file) == (5, 1)
    assert len(CUT) == 4


def printed(*lines, **environment):
    """What a fresh process prints."""
    paths = ":".join([environment.pop("beside", ""), *sys.path])
    return subprocess.run(
        [sys.executable, "-c", "\n".join(lines)],
        capture_output=True,
        text=True,
        timeout=300,
        check=True,
        env=os.environ | {"PYTHONPATH": paths} | environment,
    ).stdout


def test_a_variable_that_numba_cannot_use_is_told():
    code = (
        "from geometry.errors import PlogicError",
        "try: import sensing.compiled",
        "except PlogicError as e: print(e)",
    )
    said = "a variable NUMBA_... of the environment keeps numba from being loaded: Number of threads"
    assert printed(*code, NUMBA_NUM_THREADS="0").startswith(said)


def test_what_is_not_compiled_is_as_it_was(monkeypatch):
    monkeypatch.setattr("numba.core.config.DISABLE_JIT", True)
    for signature in (None, "i8(i8)"):
        assert sensing.compiled.compiled(signature)(called) is called


def test_where_no_folder_takes_it_each_process_compiles(tmp_path):
    for name in ("__pycache__", "home"):  # files where there should be folders
        (tmp_path / name).touch()
    (tmp_path / "adding.py").write_text(SOURCE.format(""))
    code = "from adding import added", "from sensing.compiled import UNKEPT", "print(added(2, 3), UNKEPT)"
    home = str(tmp_path / "home")
    assert printed(*code, beside=str(tmp_path), HOME=home, XDG_CACHE_HOME=home) == "5 ['added']\n"


def test_what_compiling_takes_is_asked_for(tmp_path):
    """All our loops with none kept; of those that are compiled when called, no more is known before."""
    reserved, memory = map(int, printed(SIZES, NUMBA_CACHE_DIR=str(tmp_path), OPENBLAS_NUM_THREADS="1").split())
    for wanted, found in zip(sensing.compiled.COMPILING, (memory, reserved), strict=True):
        assert found <= wanted < 2 * found
