"""The wheel, in an environment and a folder of its own: Python, the type checker, the notebook and the demo."""

from __future__ import annotations

import json
import shutil
import subprocess
import sys
import sysconfig
import venv
import zipfile
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[3]
CHECKED = """from plogic import KnowledgeBase, perceive

scene = perceive("gamma.json", KnowledgeBase.load("first"), reading="posterior")
reveal_type(scene.hypotheses[0].probability)
perceive("gamma.json", "first", reading="other")
"""


def run(*command, cwd, status=0):
    """A finished process; fails where it ends with another status."""
    done = subprocess.run([*map(str, command)], cwd=cwd, capture_output=True, text=True, check=False, timeout=300)
    assert done.returncode == status, done.stdout + done.stderr
    return done.stdout


@pytest.fixture(scope="module")
def wheel(tmp_path_factory):
    """The wheel's file, built without the network."""
    source, folder = tmp_path_factory.mktemp("source"), tmp_path_factory.mktemp("wheel")
    for name in ("plogic", "geometry", "kb", "sensing"):
        shutil.copytree(ROOT / name, source / name, ignore=shutil.ignore_patterns("__pycache__"))
    for name in ("cli.py", "pyproject.toml", "README.md", "LICENSE"):
        shutil.copy(ROOT / name, source / name)
    run(
        sys.executable,
        "-m",
        "pip",
        "wheel",
        "-q",
        "--no-deps",
        "--no-build-isolation",
        "-w",
        folder,
        source,
        cwd=folder,
    )
    (file,) = folder.glob("plogic-*.whl")
    return file


@pytest.fixture(scope="module")
def installed(wheel, tmp_path_factory):
    """The bin folder of a fresh environment that has the wheel; its dependencies are those of this one."""
    home = tmp_path_factory.mktemp("environment")
    venv.create(home, with_pip=False, symlinks=True)
    (place,) = home.glob("lib/python*/site-packages")
    with zipfile.ZipFile(wheel) as archive:
        archive.extractall(place)
    (place / "others.pth").write_text(sysconfig.get_paths()["purelib"] + "\n")
    return home / "bin"


@pytest.fixture
def python(installed):
    """Its interpreter."""
    return installed / "python"


def test_the_wheel_says_that_it_is_typed(wheel):
    names = set(zipfile.ZipFile(wheel).namelist())
    assert {f"{top}/py.typed" for top in ("plogic", "geometry", "kb", "sensing")} <= names
    assert not [name for name in names if name.split("/")[0] in ("benchmarks", "tests", "docs")]


def test_python_finds_its_names_in_an_empty_folder(python, tmp_path):
    told = run(python, "-c", "import plogic; from plogic import perceive; print(plogic.__file__)", cwd=tmp_path)
    assert Path(told.strip()).is_relative_to(python.parents[1])


def test_the_type_checker_sees_its_types(python, tmp_path):
    (tmp_path / "mine.py").write_text(CHECKED)
    told = run(
        sys.executable, "-m", "mypy", "--python-executable", python, "--cache-dir", "/dev/null", "mine.py",
        cwd=tmp_path, status=1,
    )  # fmt: skip
    assert 'mine.py:4: note: Revealed type is "float"' in told.replace("builtins.", "")
    assert "mine.py:5: error" in told
    assert "Found 1 error in 1 file" in told


def test_the_notebook_runs(python, tmp_path):
    cells = json.loads((ROOT / "examples" / "quickstart.ipynb").read_text(encoding="utf-8"))["cells"]
    code = ["".join(cell["source"]) for cell in cells if cell["cell_type"] == "code"]
    for name in ("first_gamma.json", "alarm.pl"):
        shutil.copy(ROOT / "examples" / name, tmp_path / name)
    assert len(code) == 10
    run(python, "-c", "\n".join(code), cwd=tmp_path)


def test_the_demo_runs(python, tmp_path):
    code = "from plogic.face.commands.started import main; main()"
    run(python, "-c", code, "demo", "-o", tmp_path / "out", cwd=tmp_path)
    assert (tmp_path / "out" / "page.html").stat().st_size > 10_000
