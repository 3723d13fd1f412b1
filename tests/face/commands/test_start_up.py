"""``plogic --help`` answers at once: no heavy package is imported for it."""

from __future__ import annotations

import re
import subprocess
import sys

import pytest
from console import BIN, good

HEAVY = {
    "numpy",
    "cv2",
    "problog",
    "trimesh",
    "pybullet",
    "pydantic",
    "scipy",
    "networkx",
    "shapely",
    "rich",
    "ruamel",
    "manifold3d",
    "embreex",
}


def imported(*args):
    """The top-level packages that a run of the script imports."""
    command = [sys.executable, "-X", "importtime", str(BIN / "plogic"), *map(str, args)]
    run = subprocess.run(command, capture_output=True, text=True, check=False, timeout=60)
    assert run.returncode == 0
    return {name.split(".")[0] for name in re.findall(r"^import time:.*\| +(\S+)$", run.stderr, re.MULTILINE)}


@pytest.mark.parametrize(
    "args", [["--help"], ["--version"], ["perceive", "--help"], ["kb", "check", "--help"]], ids=" ".join
)
def test_help_imports_nothing_heavy(args):
    found = imported(*args)
    assert {"plogic", "click"} <= found, "the list is that of this run"
    assert not found & HEAVY


def test_a_command_that_reads_a_kb_imports_no_simulator_and_no_image_library():
    found = imported("kb", "check", "towers")
    assert "pydantic" in found
    assert not found & {"pybullet", "cv2"}


@pytest.mark.parametrize("what", ["image.png", "gamma.json"])
def test_perceiving_what_was_written_by_hand_imports_no_compiler_and_reads_no_mesh_twice(demo, tmp_path, what):
    camera = ("--camera", demo / "camera.json") if what == "image.png" else ()
    good("perceive", demo / what, "--kb", "towers", *camera, "-o", tmp_path / "first.json")
    found = imported("perceive", demo / what, "--kb", "towers", *camera, "-o", tmp_path / "i.json")
    assert "numpy" in found, "the list is that of this run"
    assert not found & {"numba", "trimesh", "scipy", "problog", "pybullet", "networkx", "pydantic", "ruamel"}
    assert (tmp_path / "first.json").read_bytes() == (tmp_path / "i.json").read_bytes()


def test_a_scene_that_is_drawn_again_reads_no_mesh(tmp_path):
    good("simulate", "--kb", "towers", "-o", tmp_path / "first")
    found = imported("simulate", "--kb", "towers", "-o", tmp_path / "again")
    assert "cv2" in found, "the list is that of this run"
    assert not found & {"trimesh", "networkx", "pydantic", "ruamel", "numba"}
    assert (tmp_path / "first/image.png").read_bytes() == (tmp_path / "again/image.png").read_bytes()


def test_a_page_needs_no_compiler(demo, tmp_path):
    found = imported("report", demo / "interpretation.json", "-o", tmp_path / "page.html")
    assert "cv2" in found, "the list is that of this run"
    assert not found & {"numba", "trimesh", "scipy", "pydantic"}


def test_every_command_is_in_the_help_and_has_a_help_of_its_own():
    names = re.findall(r"^  ([a-z-]+) {2,}\S", good("--help").split("Commands:")[1], re.MULTILINE)
    assert set(names) >= {
        "demo",
        "perceive",
        "worlds",
        "query",
        "explain",
        "program",
        "report",
        "kb",
        "simulate",
        "bench",
    }
    for name in names:
        assert good(name, "--help").startswith(f"Usage: plogic {name}")
