"""Painted meshes kept between runs: the same to the bit as read anew."""

from dataclasses import replace

import numpy as np
import pytest

from kb.files.folder import shipped
from kb.files.read import read_kb
from plogic.base.errors import InputError
from plogic.run import kept_meshes
from plogic.run.kept_meshes import mesh_of
from sensing.errors import SceneError
from sensing.simulated.body import read_mesh


@pytest.fixture
def kept(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    return tmp_path / "plogic" / "meshes"


def said(mesh):
    arrays = (mesh.vertices, mesh.triangles, mesh.uv, mesh.texture)
    return [None if a is None else (a.dtype, a.shape, np.asarray(a).tobytes()) for a in arrays], mesh.colour


@pytest.mark.parametrize("name", ["towers", "paper"])
def test_the_second_run_reads_no_mesh(kept, monkeypatch, name):
    kinds = read_kb(shipped(name)).types
    fresh = [said(read_mesh(kind.mesh_file, kind.mesh_scale)) for kind in kinds]
    assert fresh
    assert [said(mesh_of(kind)) for kind in kinds] == fresh
    monkeypatch.setattr(kept_meshes, "read_mesh", None)
    assert [said(mesh_of(kind)) for kind in kinds] == fresh
    assert len(list(kept.iterdir())) == len(kinds)


def test_what_cannot_be_read_is_not_kept(kept, tmp_path):
    kind = read_kb(shipped("towers")).types[0]
    with pytest.raises(InputError, match="has no mesh"):
        mesh_of(replace(kind, mesh_file=None))
    with pytest.raises(SceneError, match="there is no such mesh file"):
        mesh_of(replace(kind, mesh_file=tmp_path / "none.obj"))
    (tmp_path / "none.obj").write_text("v 0 0 0\n")
    with pytest.raises(SceneError):
        mesh_of(replace(kind, mesh_file=tmp_path / "none.obj"))
    assert not kept.exists() or list(kept.iterdir()) == []
