"""A file of a user's own that has the name of a package of ours is told in one sentence that names it."""

from __future__ import annotations

import os
import subprocess
import sys

import pytest

from plogic.base.hidden import hidden

COMMAND = "from plogic.face.commands.started import main; main()"


def run(folder, code):
    """Python in a folder that comes first in its path, as that of a script does."""
    (folder / "script.py").write_text(code)
    return subprocess.run(
        [sys.executable, str(folder / "script.py")], cwd=folder, capture_output=True, text=True, check=False, timeout=60
    )


def test_nothing_is_hidden_here():
    assert hidden(("geometry", "kb", "sensing", "cli")) is None


@pytest.mark.parametrize("name", ["geometry", "kb", "sensing"])
def test_python_is_told_in_one_sentence(name, tmp_path):
    (tmp_path / f"{name}.py").write_text("")
    last = run(tmp_path, "from plogic import perceive").stderr.strip().splitlines()[-1]
    assert last == (
        f"ImportError: {tmp_path}/{name}.py: hides the package {name!r} that plogic brings; "
        "rename it, or move it out of sys.path"
    )


def test_a_package_hides_as_a_module_does_and_a_bare_folder_hides_nothing(tmp_path):
    (tmp_path / "geometry").mkdir()
    assert run(tmp_path, "from plogic import Error").returncode == 0
    (tmp_path / "geometry" / "__init__.py").write_text("")
    assert f"{tmp_path}/geometry/__init__.py: hides" in run(tmp_path, "from plogic import Error").stderr


@pytest.mark.parametrize("name", ["geometry", "cli"])
def test_the_command_is_told_in_one_sentence(name, tmp_path):
    (tmp_path / f"{name}.py").write_text("")
    done = run(tmp_path, COMMAND)
    kind = "module" if name == "cli" else "package"
    assert (done.returncode, done.stdout) == (1, "")
    assert done.stderr == (
        f"plogic: {tmp_path}/{name}.py: hides the {kind} {name!r} that plogic brings; "
        "rename it, or move it out of sys.path\n"
    )


def test_the_command_runs_where_nothing_is_hidden(tmp_path):
    (tmp_path / "script.py").write_text(COMMAND)
    command = [sys.executable, str(tmp_path / "script.py"), "--version"]
    done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=60, env=dict(os.environ))
    assert done.returncode == 0
    assert "version" in done.stdout
