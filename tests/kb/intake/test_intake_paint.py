"""What paints a mesh: pictures named by OBJ, PLY and GLB, colours of vertices, several at once, none."""

import json
import struct

import cv2
import numpy as np
import pytest
import trimesh
from made_meshes import CORNERS, box_triangles, split_box, write_painted

from kb.errors import IntakeError
from kb.intake.source import painted_files, pixels, read_source


def read_back(tmp_path, files):
    """The uv and the picture of painted files, as the renderer would read them."""
    for name, data in files.items():
        (tmp_path / name).write_bytes(data)
    (picture,) = [name for name in files if name.startswith("texture.")]
    assert f"map_Kd {picture}" in files["textured.mtl"].decode()
    mesh = trimesh.load(tmp_path / "textured.obj", process=False)
    return mesh, cv2.imread(str(tmp_path / picture))


def colours_at_corners(mesh, image):
    """Blue, green, red (T, 3, 3) of the picture at each triangle's corners."""
    high, wide = image.shape[:2]
    uv = mesh.visual.uv[mesh.faces]
    rows = np.clip(((1 - uv[..., 1]) * high).astype(int), 0, high - 1)
    return image[rows, np.clip((uv[..., 0] * wide).astype(int), 0, wide - 1)]


def test_a_picture_travels_as_it_is(tmp_path):
    path = write_painted(tmp_path)
    files, word = painted_files(read_source(path), 0.01)
    assert files["texture.png"] == (tmp_path / "paint.png").read_bytes()
    assert "as it is" in word
    new = tmp_path / "new"
    new.mkdir()
    mesh, _ = read_back(new, files)
    assert np.ptp(mesh.vertices, axis=0) == pytest.approx([0.1, 0.1, 0.1])
    assert mesh.visual.uv.max() == 1


def test_a_missing_picture_is_noted_and_no_more(tmp_path):
    source = read_source(write_painted(tmp_path, picture=False))
    assert source.notes == ("the texture 'paint.png' is missing or no picture: going on without",)
    assert painted_files(source, 1.0) == ({}, "none")
    (tmp_path / "paint.png").write_bytes(b"\x89PNG but not much more")
    assert read_source(tmp_path / "box.obj").notes == source.notes


def test_colours_of_vertices_become_a_picture(tmp_path):
    mesh = trimesh.Trimesh(CORNERS, box_triangles(), process=False)
    mesh.visual.vertex_colors = np.column_stack([CORNERS * 200 + 20, np.full(8, 255)]).astype(np.uint8)
    mesh.export(tmp_path / "box.ply")
    files, word = painted_files(read_source(tmp_path / "box.ply"), 1.0)
    assert "the vertices' colours" in word
    back, image = read_back(tmp_path, files)
    wanted = np.asarray(back.vertices)[back.faces] * 200 + 20
    assert colours_at_corners(back, image)[..., ::-1].astype(float) == pytest.approx(wanted, abs=1)


def test_a_ply_names_its_picture(tmp_path):
    vertices, triangles, uv = split_box()
    rows = [f"{x} {y} {z} {u} {v}" for (x, y, z), (u, v) in zip(vertices, uv, strict=True)]
    head = ["ply", "format ascii 1.0", "comment TextureFile box.png", f"element vertex {len(rows)}"]
    head += [f"property float {name}" for name in ("x", "y", "z", "texture_u", "texture_v")]
    head += [f"element face {len(triangles)}", "property list uchar int vertex_indices", "end_header"]
    (tmp_path / "box.ply").write_text("\n".join([*head, *rows, *(f"3 {a} {b} {c}" for a, b, c in triangles)]) + "\n")
    cv2.imwrite(str(tmp_path / "box.png"), np.zeros((4, 4, 3), dtype=np.uint8))
    files, _ = painted_files(read_source(tmp_path / "box.ply"), 1.0)
    assert files["texture.png"] == (tmp_path / "box.png").read_bytes()


def glb(picture):
    """A GLB of the split cube with its picture inside; ``nodes`` scale it by 2."""
    vertices, triangles, uv = split_box()
    parts = [vertices.astype("<f4").tobytes(), uv.astype("<f4").tobytes(), triangles.astype("<u4").tobytes(), picture]
    starts = np.cumsum([0] + [len(part) + -len(part) % 4 for part in parts])
    binary = b"".join(part + b"\0" * (-len(part) % 4) for part in parts)
    views = [{"buffer": 0, "byteOffset": int(s), "byteLength": len(p)} for s, p in zip(starts, parts, strict=False)]
    kinds = [(5126, 24, "VEC3"), (5126, 24, "VEC2"), (5125, 36, "SCALAR")]
    tree = {
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0, "scale": [2, 2, 2]}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0, "TEXCOORD_0": 1}, "indices": 2, "material": 0}]}],
        "materials": [{"name": "paint", "pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}],
        "textures": [{"source": 0}],
        "images": [{"bufferView": 3, "mimeType": "image/png"}],
        "bufferViews": views,
        "accessors": [
            {"bufferView": i, "componentType": c, "count": n, "type": t} for i, (c, n, t) in enumerate(kinds)
        ],
        "buffers": [{"byteLength": len(binary)}],
    }
    text = json.dumps(tree).encode()
    text += b" " * (-len(text) % 4)
    body = struct.pack("<I4s", len(text), b"JSON") + text + struct.pack("<I4s", len(binary), b"BIN\0") + binary
    return struct.pack("<4sII", b"glTF", 2, 12 + len(body)) + body


def test_a_glb_carries_its_picture(tmp_path):
    picture = cv2.imencode(".png", np.full((4, 4, 3), 77, dtype=np.uint8))[1].tobytes()
    (tmp_path / "box.glb").write_bytes(glb(picture))
    source = read_source(tmp_path / "box.glb")
    assert np.ptp(source.whole[0], axis=0) == pytest.approx([2, 2, 2])
    assert painted_files(source, 1.0)[0]["texture.png"] == picture


def test_several_pictures_become_one_atlas(tmp_path):
    vertices, triangles, uv = split_box()
    half = len(triangles) // 2
    lines = ["mtllib two.mtl"]
    lines += [f"v {x} {y} {z}" for x, y, z in vertices] + [f"vt {u * 0.5 + 0.25} {v * 0.5 + 0.25}" for u, v in uv]
    facets = [" ".join(f"{i + 1}/{i + 1}" for i in t) for t in triangles.tolist()]
    lines += ["usemtl a", *(f"f {f}" for f in facets[:half]), "usemtl b", *(f"f {f}" for f in facets[half:])]
    (tmp_path / "two.obj").write_text("\n".join(lines) + "\n")
    (tmp_path / "two.mtl").write_text("newmtl a\nmap_Kd a.png\nnewmtl b\nmap_Kd b.png\n")
    cv2.imwrite(str(tmp_path / "a.png"), np.full((8, 8, 3), (250, 0, 0), dtype=np.uint8))
    cv2.imwrite(str(tmp_path / "b.png"), np.full((16, 16, 3), (0, 250, 0), dtype=np.uint8))
    files, word = painted_files(read_source(tmp_path / "two.obj"), 1.0)
    assert "2 pictures" in word
    back, image = read_back(tmp_path, files)
    seen = colours_at_corners(back, image)
    first = {vertices[t].mean(axis=0).round(3).tobytes() for t in triangles[:half]}
    middles = np.asarray(back.vertices)[back.faces].mean(axis=1).round(3)
    wanted = [[[250, 0, 0] if middle.tobytes() in first else [0, 250, 0]] * 3 for middle in middles]
    assert np.array_equal(seen, wanted)


def test_bytes_that_are_no_picture():
    assert pixels(b"nonsense") is None
    assert pixels(b"") is None


@pytest.mark.parametrize(
    ("name", "content", "said"),
    [
        ("a.obj", "", "holds no triangles"),
        ("a.obj", "v 0 0 0\nv 1 0 0\n", "holds no triangles"),
        ("a.obj", "v 0 0 0\nv 1 0 0\nv 0 nan 0\nf 1 2 3\n", "1 vertices have coordinates that are not finite"),
        ("a.obj", "v 0 0 0\nv 1 0 0\nv 0 inf 0\nf 1 2 3\n", "not finite"),
        ("a.obj", "v 0 0 0\nv 1 0 0\nf 1 2 9\n", "no mesh that can be read"),
        ("a.ply", "garbage", "no mesh that can be read"),
        ("a.glb", "garbage", "no mesh that can be read"),
        ("a.txt", "v 0 0 0", "these can: obj, ply"),
    ],
)
def test_what_is_no_mesh(tmp_path, name, content, said):
    (tmp_path / name).write_text(content)
    with pytest.raises(IntakeError, match=said):
        read_source(tmp_path / name)


def test_limits_are_held(tmp_path, monkeypatch):
    with (tmp_path / "large.stl").open("wb") as file:
        file.truncate(200_000_001)
    with pytest.raises(IntakeError, match="more than the 200000000"):
        read_source(tmp_path / "large.stl")
    with pytest.raises(IntakeError, match="no such mesh file"):
        read_source(tmp_path / "gone.stl")
    monkeypatch.setattr("kb.intake.source.MAX_TRIANGLES", 11)
    with pytest.raises(IntakeError, match="12 triangles, more than the 11"):
        read_source(write_painted(tmp_path))
