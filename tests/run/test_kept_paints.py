"""Paints kept between runs: the same, made anew whenever anything that decides them has changed."""

from dataclasses import replace

import cv2
import numpy as np
import pytest
from made_meshes import write_painted

from geometry.files.remembered import ROOT, sources, sources_in
from kb.files.folder import shipped
from kb.files.kept_surfaces import read_by
from kb.files.read import read_kb
from plogic.run import painted
from plogic.run.painted import SOURCES, paint_assets


@pytest.fixture
def crate(tmp_path, monkeypatch):
    """A painted type in a folder of its own; paints are kept beside it."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    kind = read_kb(shipped("first")).types[0]
    return replace(kind, mesh_file=write_painted(tmp_path), mesh_scale=0.01)


def paint_of(kind):
    """As another process would find it."""
    painted._paint.cache_clear()
    read_by.cache_clear()
    return paint_assets({"crate": kind})


def kept(folder):
    return sorted(path.name for path in (folder / "cache" / "plogic" / "paints").iterdir())


def test_the_second_run_reads_no_mesh(crate, tmp_path, monkeypatch):
    made = paint_of(crate)
    assert set(made["paints"]["crate"]) == {"vertices", "triangles", "uv", "picture"}
    assert len(kept(tmp_path)) == 1
    monkeypatch.setattr(painted, "painted_mesh", None)
    assert paint_of(crate) == made


def test_a_mesh_without_paint_is_not_read_twice_either(crate, tmp_path, monkeypatch):
    plain = replace(crate, mesh_file=shipped("first") / "objects" / "box" / "mesh.obj")
    assert paint_of(plain) == {}
    monkeypatch.setattr(painted, "painted_mesh", None)
    assert paint_of(plain) == {}


@pytest.mark.parametrize("changed", ["picture", "scale", "code", "library", "mesh"])
def test_what_decides_a_paint_is_in_its_key(crate, tmp_path, monkeypatch, changed):
    made = paint_of(crate)
    if changed == "picture":
        cv2.imwrite(str(tmp_path / "paint.png"), np.full((4, 4, 3), 77, np.uint8))
        assert paint_of(crate)["paints"]["crate"]["picture"] != made["paints"]["crate"]["picture"]
    elif changed == "scale":
        assert (
            paint_of(replace(crate, mesh_scale=0.02))["paints"]["crate"]["vertices"]
            != made["paints"]["crate"]["vertices"]
        )
    elif changed == "mesh":
        crate.mesh_file.write_bytes(crate.mesh_file.read_bytes() + b"# more\n")
        assert paint_of(crate) == made
    else:
        name, other = {"code": ("source_digest", b"other"), "library": ("version", "0")}[changed]
        monkeypatch.setattr(f"kb.files.kept_surfaces.{name}", lambda *_: other)
        assert paint_of(crate) == made
    assert len(kept(tmp_path)) == 2


def test_a_mesh_that_is_gone_has_no_paint(crate):
    crate.mesh_file.unlink()
    assert paint_of(crate) == {}


def test_all_code_that_reads_a_painted_mesh_is_among_what_is_hashed():
    first = "sensing/simulated/body.py"
    reading = sources(ROOT, first)
    assert first in reading
    assert reading <= sources_in(ROOT, SOURCES)
