"""The demo, run once, and an interpretation in doubt: what every command is tried on."""

from __future__ import annotations

import json
import shutil
import subprocess

import pytest


@pytest.fixture(scope="session")
def demo_run(tmp_path_factory):
    """The finished process of ``plogic demo -o FOLDER``, and the folder; tests only read there."""
    from console import plogic
    from shared_folder import shared

    def make(place):
        run = plogic("demo", "-o", place / "new" / "demo")
        (place / "run.json").write_text(json.dumps([run.args, run.returncode, run.stdout, run.stderr]))

    place = shared(tmp_path_factory, "demo", make)
    return subprocess.CompletedProcess(*json.loads((place / "run.json").read_text())), place / "new" / "demo"


@pytest.fixture(scope="session")
def demo(demo_run):
    """The demo's folder."""
    run, folder = demo_run
    assert run.returncode == 0, run.stderr
    return folder


@pytest.fixture(scope="session")
def gamma(demo):
    """The demo's Γ as a document."""
    return json.loads((demo / "gamma.json").read_text())


@pytest.fixture
def inputs(demo, tmp_path):
    """A folder with the demo's image, camera and interpretation, and several files that are none."""
    for name in ("image.png", "camera.json", "interpretation.json"):
        shutil.copy(demo / name, tmp_path)
    (tmp_path / "alone").mkdir()
    shutil.copy(demo / "image.png", tmp_path / "alone")
    camera = json.loads((demo / "camera.json").read_text())
    (tmp_path / "small.json").write_text(json.dumps({**camera, "width": 320}))
    for name in ("empty.png", "empty.json"):
        (tmp_path / name).touch()
    (tmp_path / "text.png").write_text("this is no image " * 99)
    (tmp_path / "cut.png").write_bytes((demo / "image.png").read_bytes()[:5000])
    (tmp_path / "cut.json").write_bytes((demo / "interpretation.json").read_bytes()[:5000])
    for name in ("folder.png", "folder.json", "folder.pl"):
        (tmp_path / name).mkdir()
    (tmp_path / "hostile.pl").write_text(":- use_module('x.py').\n0.5::a.\nquery(a).\n")
    (tmp_path / "syntax.pl").write_text("0.5::a.\nb :- .\n")
    (tmp_path / "x.py").write_text("from pathlib import Path\nPath('pwned').touch()\n")
    return tmp_path
