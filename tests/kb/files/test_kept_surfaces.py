"""Surfaces kept between runs: the same to the bit, read anew whenever anything that decides them has changed."""

import sys
from pathlib import Path

import numpy as np
import pytest
from made_meshes import NUMBERS, gltf_text

from geometry.files.remembered import OURS, ROOT, sources_in
from kb.errors import SurfaceError
from kb.files import kept_surfaces
from kb.files.folder import shipped
from kb.files.kept_surfaces import SOURCES, kept_surface
from kb.files.read import read_kb
from kb.surfaces.surface import surface_from_mesh

CUBE = shipped("first") / "objects" / "box" / "mesh.obj"


def kept_in(folder):
    return sorted(path.name for path in folder.iterdir()) if folder.exists() else []


def again(path, folder, scale=1.0):
    return kept_surface(path, path.read_bytes(), scale, folder)


def same(one, other):
    return np.array_equal(one.vertices, other.vertices) and np.array_equal(one.triangles, other.triangles)


def test_the_first_run_keeps_it_and_the_second_reads_no_mesh(tmp_path, monkeypatch):
    read = surface_from_mesh(CUBE, 0.5)
    assert same(again(CUBE, tmp_path, 0.5), read)
    assert len(kept_in(tmp_path)) == 1
    monkeypatch.setattr(kept_surfaces, "surface_from_mesh", None)
    found = again(CUBE, tmp_path, 0.5)
    assert same(found, read)
    assert not found.vertices.flags.writeable
    assert found.vertices.dtype == read.vertices.dtype


@pytest.mark.parametrize("changed", ["scale", "content", "code", "library", "materials", "no materials"])
def test_what_decides_a_surface_is_in_its_key(tmp_path, monkeypatch, changed):
    mesh, folder = tmp_path / "mesh.obj", tmp_path / "kept"
    mesh.write_bytes(b"mtllib paint.mtl\n" + CUBE.read_bytes())
    (tmp_path / "paint.mtl").write_text("newmtl a\n")
    again(mesh, folder)
    kept_surfaces.read_by.cache_clear()
    if changed == "content":
        mesh.write_bytes(mesh.read_bytes() + b"# more\n")
    if changed == "materials":
        (tmp_path / "paint.mtl").write_text("newmtl b\n")
    if changed == "no materials":
        (tmp_path / "paint.mtl").unlink()
    if changed == "code":
        monkeypatch.setattr(kept_surfaces, "source_digest", lambda *_: b"other code")
    if changed == "library":
        monkeypatch.setattr(kept_surfaces, "version", lambda _: "0.0")
    again(mesh, folder, 2.0 if changed == "scale" else 1.0)
    monkeypatch.undo()
    kept_surfaces.read_by.cache_clear()
    assert len(kept_in(folder)) == 2


def test_a_damaged_one_is_read_anew(tmp_path):
    again(CUBE, tmp_path)
    (place,) = tmp_path.iterdir()
    content = bytearray((place / "vertices.npy").read_bytes())
    content[-1] ^= 1
    (place / "vertices.npy").write_bytes(content)
    assert same(again(CUBE, tmp_path), surface_from_mesh(CUBE))
    assert same(again(CUBE, tmp_path), surface_from_mesh(CUBE))


def test_a_buffer_that_a_mesh_names_is_in_its_key(tmp_path):
    folder, path, buffer = tmp_path / "kept", tmp_path / "box.gltf", tmp_path / "box.bin"
    path.write_text(gltf_text("box.bin"))
    buffer.write_bytes(NUMBERS)
    box = again(path, folder)
    assert same(again(path, folder), box)
    assert len(kept_in(folder)) == 1
    buffer.write_bytes(NUMBERS.replace(np.float32(1).tobytes(), np.float32(2).tobytes()))
    assert again(path, folder).diameter > box.diameter
    assert len(kept_in(folder)) == 2


def test_a_file_that_is_no_mesh_is_not_kept(tmp_path):
    folder, none = tmp_path / "kept", tmp_path / "none.obj"
    none.write_text("v 0 0 0\n")
    with pytest.raises(SurfaceError):
        again(none, folder)
    assert kept_in(folder) == []
    other = tmp_path / "cube.gltf"
    with pytest.raises(SurfaceError):
        kept_surface(other, b"{}", 1.0, folder)
    assert kept_in(folder) == []


def test_a_knowledge_base_reads_the_same_and_keeps_nothing_unless_told_where(tmp_path):
    folder = shipped("towers")
    plain, first, second = read_kb(folder), read_kb(folder, tmp_path), read_kb(folder, tmp_path)
    assert len(kept_in(tmp_path)) == 2
    for kind in plain.types:
        for other in (first, second):
            (one,) = (each for each in other.types if each.name == kind.name)
            assert same(one.surface, kind.surface)
    assert plain.digest == first.digest == second.digest


def test_every_source_file_that_runs_while_a_mesh_is_read_is_hashed():
    ran, former = set(), sys.getprofile()
    sys.setprofile(lambda frame, *_: ran.add(frame.f_code.co_filename))
    try:
        surface_from_mesh(CUBE)
    finally:
        sys.setprofile(former)
    packages = [ROOT / name for name in OURS]
    ours = {Path(name).relative_to(ROOT).as_posix() for name in ran if any(map(Path(name).is_relative_to, packages))}
    assert {"kb/surfaces/surface.py", "geometry/files/mesh_files.py"} <= ours <= sources_in(ROOT, SOURCES)
