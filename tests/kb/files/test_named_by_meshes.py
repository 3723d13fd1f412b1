"""What the meshes of a knowledge base name is read inside of it alone, and is part of its digest."""

import pytest
from small_kb import MESH, write_small

from kb.errors import KBErrors
from kb.files.read import read_kb


def mistakes(folder):
    with pytest.raises(KBErrors) as caught:
        read_kb(folder)
    return str(caught.value).splitlines()


@pytest.fixture
def painted(tmp_path):
    """A knowledge base whose mesh names materials and pictures, here and there."""
    write_small(tmp_path / "above/kb", mesh="mtllib mesh.mtl\n" + MESH)
    tent = tmp_path / "above/kb/objects/tent"
    (tmp_path / "above/kb/textures").mkdir()
    for file in ("a.png", "../../textures/b.png", "unnamed.png", "../../../outside.png", "../../../../outside.png"):
        (tent / file).write_bytes(b"paint")
    (tent / "mesh.mtl").write_text("newmtl a\nmap_Kd a.png\nmap_Kd ../../textures/b.png\nmap_Kd C:\\missing.png\n")
    return tent


@pytest.mark.parametrize("name", ["mesh.mtl", "a.png", "../../textures/b.png"])
def test_what_the_mesh_names_is_part_of_the_digest(painted, name):
    before = read_kb(painted.parents[1]).digest
    (painted / "unnamed.png").write_bytes(b"other paint")
    assert read_kb(painted.parents[1]).digest == before
    with (painted / name).open("a") as file:
        file.write("#")
    assert read_kb(painted.parents[1]).digest != before


@pytest.mark.parametrize("name", ["../../../outside.png", "../../../../outside.png", "link.png"])
def test_a_picture_outside_of_the_knowledge_base_is_a_mistake(painted, name):
    (painted / "link.png").symlink_to(painted / "../../../outside.png")
    (painted / "mesh.mtl").write_text(f"newmtl a\nmap_Kd {name}\n")
    (line,) = mistakes(painted.parents[1])
    assert line == f"objects/tent/mesh.obj: the picture {name!r} leads out of the mesh file's folder"


def test_a_picture_that_a_mesh_elsewhere_might_name_is_a_mistake(painted):
    """Two folders above a mesh that lies in the first folder of the knowledge base."""
    root = painted.parents[1]
    (root / "mesh.obj").write_bytes((painted / "mesh.obj").read_bytes())
    (root / "mesh.mtl").write_text("newmtl a\nmap_Kd ../outside.png\n")
    file = root / "objects/tent/object.yaml"
    file.write_text(file.read_text().replace("file: mesh.obj", "file: ../../mesh.obj"))
    assert mistakes(root) == ["mesh.obj: the picture '../outside.png' leads out of the knowledge base's folder"]
