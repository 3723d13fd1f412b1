"""Meshes' textures reach the simulated camera without Pillow, and faults are told in one line."""

import sys

import cv2
import numpy as np
import pytest
from made_meshes import glb_bytes, obj_text, split_box, write_painted

from kb.intake.source import read_source
from sensing.errors import ImageError, SceneError
from sensing.simulated.body import read_mesh

PAINT = (np.arange(48).reshape(4, 4, 3) * 5).astype(np.uint8)
PNG, JPEG = (cv2.imencode(kind, PAINT)[1].tobytes() for kind in (".png", ".jpg"))


@pytest.fixture(autouse=True)
def _no_pillow(monkeypatch):
    """Pillow is no dependency of ours: nothing here may need it, nor change where it is."""
    monkeypatch.setitem(sys.modules, "PIL", None)
    monkeypatch.setitem(sys.modules, "PIL.Image", None)


@pytest.mark.parametrize("picture", [PNG, JPEG], ids=["png", "jpg"])
def test_a_glb_carries_its_texture(tmp_path, picture):
    (tmp_path / "a.glb").write_bytes(glb_bytes([picture], [0]))
    mesh = read_mesh(tmp_path / "a.glb", 0.5)
    assert np.array_equal(mesh.texture, cv2.imdecode(np.frombuffer(picture, np.uint8), cv2.IMREAD_COLOR))
    assert np.allclose(mesh.uv, split_box()[2])
    assert np.ptp(mesh.vertices, axis=0).tolist() == [0.5, 0.5, 0.5]


def test_pieces_that_share_one_picture_are_one_mesh(tmp_path):
    (tmp_path / "a.glb").write_bytes(glb_bytes([PNG], [0, 0]))
    mesh = read_mesh(tmp_path / "a.glb")
    assert (mesh.texture.shape, len(mesh.triangles), len(mesh.uv)) == ((4, 4, 3), 12, len(mesh.vertices))


@pytest.mark.parametrize("materials", [["zork"], ["paint", "zork"]], ids=" ".join)
def test_an_obj_of_unknown_materials_is_painted_by_its_one_picture(tmp_path, materials):
    path = write_painted(tmp_path)
    text = path.read_text().replace("usemtl paint", f"usemtl {materials[0]}")
    path.write_text(text.replace("\nf 13", f"\nusemtl {materials[-1]}\nf 13", 1))
    mesh = read_mesh(path)
    assert np.array_equal(mesh.texture, cv2.imread(str(tmp_path / "paint.png")))
    assert len(mesh.triangles) == 12


def test_a_ply_names_its_texture(tmp_path):
    vertices, triangles, uv = split_box()
    cv2.imwrite(str(tmp_path / "p.png"), PAINT)
    rows = "".join(f"{x} {y} {z} {u} {v}\n" for (x, y, z), (u, v) in zip(vertices.tolist(), uv.tolist(), strict=True))
    names = "".join(f"property float {name}\n" for name in ("x", "y", "z", "texture_u", "texture_v"))
    faces = "".join(f"3 {a} {b} {c}\n" for a, b, c in triangles.tolist())
    head = f"ply\nformat ascii 1.0\ncomment TextureFile p.png\nelement vertex 24\n{names}element face 12\nproperty list uchar int vertex_indices\n"
    (tmp_path / "a.ply").write_text(f"{head}end_header\n{rows}{faces}")
    assert np.array_equal(read_mesh(tmp_path / "a.ply").texture, PAINT)


CANNOT = {
    "two pictures": (
        glb_bytes([PNG, JPEG], [0, 1]),
        SceneError,
        "has 2 textures; a mesh that is rendered has one picture.*: plogic kb add",
    ),
    "half painted": (glb_bytes([PNG], [0, None]), SceneError, "only 1 of its 2 pieces have a texture"),
    "no picture": (glb_bytes([b"\x89PNG\r\n"], [0]), ImageError, "the texture of material 'm0': "),
    "an empty picture": (glb_bytes([b""], [0]), SceneError, "the texture of material 'm0' is missing"),
}


@pytest.mark.parametrize("case", CANNOT)
def test_what_cannot_be_rendered_is_one_line(tmp_path, case):
    data, error, said = CANNOT[case]
    (tmp_path / "a.glb").write_bytes(data)
    with pytest.raises(error, match=rf"^{tmp_path}/a\.glb: {said}") as caught:
        read_mesh(tmp_path / "a.glb")
    assert len(str(caught.value).splitlines()) == 1


def test_what_cannot_be_rendered_can_be_added(tmp_path):
    (tmp_path / "a.glb").write_bytes(glb_bytes([PNG, JPEG], [0, 1]))
    source = read_source(tmp_path / "a.glb")
    assert [piece.picture.suffix for piece in source.pieces] == ["png", "jpg"]


def test_a_mesh_without_paint_is_grey(tmp_path):
    vertices, triangles, _ = split_box()
    (tmp_path / "a.obj").write_text(obj_text(vertices, triangles))
    assert (read_mesh(tmp_path / "a.obj").texture, read_mesh(tmp_path / "a.obj").uv) == (None, None)
