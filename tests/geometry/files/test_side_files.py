"""What a mesh file names is found and read by us alone, inside its folder, whatever trimesh would read."""

import base64
import json
import os
import sys

import numpy as np
import pytest
from made_meshes import CORNERS, NUMBERS, box_triangles, gltf_text, obj_text, split_box, write_painted

from geometry.files import side_files as module
from geometry.files.mesh_files import meshes_of, reason, textures_in
from geometry.files.side_files import IS_MISSING, LEADS_OUT, NO_RELATIVE, homes, inside, side_files

LISTENING = []
"""The lists that each file is put into which is opened to be read."""


def heard(event, args):
    for names in LISTENING if event == "open" and str(args[1] or "r").startswith("r") else ():
        names.append(str(args[0]))


sys.addaudithook(heard)


@pytest.fixture
def opened(tmp_path):
    """Call it for the files that were opened, of the test's own and of the system's."""
    LISTENING.append(names := [])
    yield lambda: {name for name in names if name.startswith((str(tmp_path), "/etc", "/dev/zero"))}
    LISTENING.remove(names)


@pytest.fixture
def folder(tmp_path):
    """Where a stranger's mesh lies, ``secret.bin`` and ``secret.png`` three folders above it."""
    for name in ("secret.bin", "secret.png", "secret.mtl"):
        (tmp_path / name).write_bytes(NUMBERS)
    (tmp_path / "a/b/mesh/below").mkdir(parents=True)
    (tmp_path / "a/b/mesh/out.bin").symlink_to(tmp_path / "secret.bin")
    (tmp_path / "a/b/mesh/out.png").symlink_to(tmp_path / "secret.png")
    (tmp_path / "a/b/mesh/around").symlink_to(tmp_path)
    os.mkfifo(tmp_path / "a/b/mesh/pipe.bin")
    (tmp_path / "a/b/mesh/endless.bin").symlink_to("/dev/zero")
    return tmp_path / "a/b/mesh"


OUT = {
    "upwards": ("../../../secret.bin", LEADS_OUT),
    "down and upwards": ("below/../../../../secret.bin", LEADS_OUT),
    "absolute": ("{}/secret.bin", NO_RELATIVE),
    "/etc/passwd": ("/etc/passwd", NO_RELATIVE),
    "home": ("~/secret.bin", NO_RELATIVE),
    "escaped": ("%2e%2e/%2E%2E/..%2fsecret.bin", LEADS_OUT),
    "an address": ("file://{}/secret.bin", NO_RELATIVE),
    "another address": ("FILE:../../../secret.bin", NO_RELATIVE),
    "a link": ("out.bin", LEADS_OUT),
    "a folder that is a link": ("around/secret.bin", LEADS_OUT),
    "a pipe": ("pipe.bin", "is no plain file, but a pipe or a device"),
    "a device": ("endless.bin", LEADS_OUT),
    "no name": ("a\0b", NO_RELATIVE),
}


@pytest.mark.parametrize("case", OUT)
def test_no_buffer_is_read_from_elsewhere(folder, opened, case):
    uri, fault = OUT[case]
    uri = uri.format(folder.parents[2])
    path = folder / "a.gltf"
    path.write_text(gltf_text(uri))
    with pytest.raises(FileNotFoundError) as caught:
        meshes_of(path)
    assert opened() == {str(path)}
    assert reason(path, caught.value) == f"its buffer {uri!r:.100} {fault}"


@pytest.mark.parametrize("uri", ["four.bin", "below/four.bin", "my%20four.bin", "below/../four.bin", "four.bin "])
def test_a_buffer_beside_or_below_is_read(folder, uri):
    for name in ("four.bin", "below/four.bin", "my four.bin"):
        (folder / name).write_bytes(NUMBERS)
    (folder / "a.gltf").write_text(gltf_text(uri))
    ((mesh, _),) = meshes_of(folder / "a.gltf")
    assert sorted(np.asarray(mesh.vertices).tolist()) == sorted(CORNERS.tolist())


def test_embedded_data_is_no_file(folder):
    data = base64.b64encode(NUMBERS).decode()
    (folder / "a.gltf").write_text(gltf_text(f"data:application/octet-stream;base64,{data}"))
    ((mesh, _),) = meshes_of(folder / "a.gltf")
    assert len(mesh.faces) == 12
    assert side_files(folder / "a.gltf", (folder / "a.gltf").read_bytes()) == []
    assert [texture.data for texture in textures_in(folder / "a.gltf")[0]] == [b"hello"]


@pytest.mark.parametrize(
    ("change", "why"),
    [
        ({"extensionsRequired": ["KHR_draco_mesh_compression"]}, "compressed (KHR_draco_mesh_compression)"),
        ({"extensionsRequired": ["EXT_meshopt_compression"]}, "compressed (EXT_meshopt_compression)"),
        ({"accessors": [{"bufferView": 0, "normalized": True}]}, "POSITION are packed"),
        ({"meshes": "a"}, "no glTF 2.0"),
        ({"extensionsRequired": 1}, "no glTF 2.0"),
    ],
)
def test_packed_numbers_are_refused_rather_than_misread(folder, change, why):
    (folder / "four.bin").write_bytes(NUMBERS)
    (folder / "a.gltf").write_text(json.dumps(json.loads(gltf_text("four.bin")) | change))
    with pytest.raises((ValueError, TypeError)) as caught:
        meshes_of(folder / "a.gltf")
    assert why in reason(folder / "a.gltf", caught.value)


@pytest.mark.parametrize("name", ["../../../secret.png", "../../secret", "/etc/passwd", "out.png", "file:///etc/hosts"])
@pytest.mark.parametrize("kind", ["obj", "ply", "gltf"])
def test_no_picture_is_read_from_elsewhere(folder, opened, kind, name):
    (folder.parents[1] / "secret").write_bytes(b"secret")
    path = folder / f"a.{kind}"
    if kind == "obj":
        path = write_painted(folder)
        (folder / "box.mtl").write_text(f"newmtl paint\nmap_Kd -s 1 1 1 {name}\n")
    elif kind == "ply":
        head = f"ply\nformat ascii 1.0\ncomment TextureFile {name}\nelement vertex 8\n"
        axes = "".join(f"property float {axis}\n" for axis in "xyz")
        rows = "".join(f"{x} {y} {z}\n" for x, y, z in CORNERS) + "".join(
            f"3 {a} {b} {c}\n" for a, b, c in box_triangles()
        )
        path.write_text(f"{head}{axes}element face 12\nproperty list uchar int vertex_indices\nend_header\n{rows}")
    else:
        (folder / "four.bin").write_bytes(NUMBERS)
        path.write_text(gltf_text("four.bin", name))
    (texture,) = textures_in(path)[0]
    assert len(meshes_of(path)[0][0].faces) == 12
    beside = {"obj": {"box.mtl"}, "gltf": {"four.bin"}, "ply": set()}[kind]
    assert opened() == {str(folder / one) for one in {path.name, *beside}}
    assert (texture.data, texture.file) == (None, None)
    assert texture.fault in (LEADS_OUT, NO_RELATIVE)


@pytest.mark.parametrize("name", ["../../../secret.mtl", "/etc/passwd", "../box.mtl"])
def test_no_materials_are_read_from_elsewhere(folder, opened, name):
    vertices, triangles, uv = split_box()
    (folder / "a.obj").write_text(obj_text(vertices, triangles, uv, name))
    (folder.parent / "box.mtl").write_text("newmtl paint\nmap_Kd paint.png\n")
    found, (note,) = textures_in(folder / "a.obj")
    assert len(meshes_of(folder / "a.obj")[0][0].faces) == 12
    assert found == []
    assert opened() == {str(folder / "a.obj")}
    assert note.startswith(f"the material file {name!r} ")


@pytest.mark.parametrize("name", ["../textures/a.png", "../../textures/a.png", "..\\textures\\a.png"])
def test_a_picture_may_lie_two_folders_above(folder, name):
    for place in (folder.parent / "textures", folder.parents[1] / "textures"):
        place.mkdir()
        (place / "a.png").write_bytes(b"\x89PNG")
    write_painted(folder)
    (folder / "box.mtl").write_text(f"newmtl paint\nmap_Kd {name}\n")
    (texture,) = textures_in(folder / "box.obj")[0]
    assert (texture.data, texture.above, texture.material) == (b"\x89PNG", True, "paint")


def test_a_mesh_that_is_a_link_has_its_files_beside_itself_or_beside_what_it_leads_to(folder):
    """As a workspace is laid out that installs links."""
    (folder / "install").mkdir()
    write_painted(folder)
    for name in ("box.obj", "box.mtl", "paint.png"):
        (folder / "install" / name).symlink_to(folder / name)
    path = folder / "install/box.obj"
    assert [side.fault for side in side_files(path, path.read_bytes())] == [None, None]
    (folder / "box.mtl").rename(folder.parents[2] / "box.mtl")
    (folder / "install/box.mtl").unlink()
    (folder / "install/box.mtl").symlink_to(folder.parents[2] / "box.mtl")
    assert [side.fault for side in side_files(path, path.read_bytes())] == [LEADS_OUT]


def test_neither_the_root_nor_a_home_counts_as_a_folder_above(tmp_path, monkeypatch):
    monkeypatch.setenv("HOME", str(tmp_path))
    (tmp_path / "robot/meshes/visual").mkdir(parents=True)
    assert homes(tmp_path / "robot/meshes/visual/a.obj", 2) == {tmp_path / "robot"}
    assert homes(tmp_path / "robot/a.obj", 2) == {tmp_path / "robot"}
    monkeypatch.setenv("HOME", "/nowhere")
    assert {len(home.parts) for home in homes(tmp_path / "robot/a.obj", 100)} == {2}
    assert not inside(tmp_path.parents[-1] / "elsewhere", homes(tmp_path / "robot/a.obj", 100))


def test_files_are_limited_each_and_together(folder, monkeypatch):
    path = write_painted(folder)
    size = (folder / "paint.png").stat().st_size
    monkeypatch.setattr(module, "MOST_BYTES", size)
    material, picture = side_files(path, path.read_bytes())
    assert material.fault is None
    assert picture.fault == f"is, with what is named before it, larger than the {size} bytes that are read"
    monkeypatch.setitem(module.LIMITS, "picture", size - 1)
    (_, picture) = side_files(path, path.read_bytes())
    assert picture.fault == f"has {size} bytes, more than the {size - 1} that are read"
    path.write_text("".join(f"mtllib {i}.mtl\n" for i in range(2000)))
    found = side_files(path, path.read_bytes())
    assert (len(found), {side.fault for side in found}) == (module.MOST_FILES, {IS_MISSING})


def test_garbage_names_nothing(tmp_path):
    for name, content in {
        "a.gltf": b"[" * 100_000,
        "b.gltf": b'{"buffers": 3}',
        "c.glb": b"glTF",
        "d.stl": b"mtllib a\n",
    }.items():
        assert side_files(tmp_path / name, content) == []
    assert side_files(tmp_path / "e.gltf", b'{"buffers": [1, {"uri": 2}], "images": [{"uri": "x" }]}')[0].name == "x"
