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


def test_a_variable_that_numba_cannot_use_is_told():
    code = "from geometry.errors import PlogicError\ntry:\n    import sensing.compiled\nexcept PlogicError as error:\n    print(error)"
    run = subprocess.run(
        [sys.executable, "-c", code],
        capture_output=True,
        text=True,
        timeout=120,
        check=True,
        env=os.environ | {"NUMBA_NUM_THREADS": "0", "PYTHONPATH": ":".join(sys.path)},
    )
    said = "a variable NUMBA_... of the environment keeps numba from being loaded: Number of threads"
    assert run.stdout.startswith(said)


def test_what_is_not_compiled_is_as_it_was(monkeypatch):
    monkeypatch.setattr("numba.core.config.DISABLE_JIT", True)
    for signature in (None, "i8(i8)"):
        assert sensing.compiled.compiled(signature)(called) is called


def test_where_no_folder_takes_it_each_process_compiles(tmp_path):
    for name in ("__pycache__", "home"):  # files where there should be folders
        (tmp_path / name).touch()
    (tmp_path / "adding.py").write_text(SOURCE.format(""))
    code = "from adding import added\nfrom sensing.compiled import UNKEPT\nprint(added(2, 3), UNKEPT)"
    home = str(tmp_path / "home")
    paths = ":".join([str(tmp_path), *sys.path])
    run = subprocess.run(
        [sys.executable, "-c", code],
        capture_output=True,
        text=True,
        timeout=120,
        check=True,
        env=os.environ | {"HOME": home, "XDG_CACHE_HOME": home, "PYTHONPATH": paths},
    )
    assert run.stdout == "5 ['added']\n"
