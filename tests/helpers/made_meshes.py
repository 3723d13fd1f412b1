"""Small meshes as files, for tests of the intake."""

from __future__ import annotations

import json
import struct

import numpy as np

CORNERS = np.array([[x, y, z] for x in (0.0, 1) for y in (0.0, 1) for z in (0.0, 1)])
QUADS = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]


def box_triangles():
    """The twelve outward triangles of the unit cube ``CORNERS``."""
    return np.array([t for a, b, c, d in QUADS for t in ((a, b, c), (a, c, d))])


def obj_text(vertices, triangles, uv=None, library=None):
    """Wavefront OBJ; with ``uv``, one for each vertex, and a material library."""
    lines = [f"mtllib {library}", "usemtl paint"] if library else []
    lines += [f"v {x!r} {y!r} {z!r}" for x, y, z in np.asarray(vertices, dtype=float).tolist()]
    lines += [f"vt {u!r} {v!r}" for u, v in np.asarray(uv, dtype=float).tolist()] if uv is not None else []
    slot = (lambda i: f"{i + 1}/{i + 1}") if uv is not None else (lambda i: str(i + 1))
    lines += ["f " + " ".join(slot(i) for i in triangle) for triangle in np.asarray(triangles).tolist()]
    return "\n".join(lines) + "\n"


def write_box(path, sides=(1, 1, 1), triangles=None):
    """A cuboid of these sides, in whatever unit; ``triangles`` other than its own make it an open or a bad one."""
    path.write_text(obj_text(CORNERS * sides, box_triangles() if triangles is None else triangles))
    return path


def split_box():
    """The cube with every face's corners its own, as texture seams split them.

    24 vertices, 12 triangles, uv (24, 2).
    """
    vertices = np.concatenate([CORNERS[list(quad)] for quad in QUADS])
    triangles = np.array([t for i in range(0, 24, 4) for t in ((i, i + 1, i + 2), (i, i + 2, i + 3))])
    return vertices, triangles, np.tile([[0.0, 0], [1, 0], [1, 1], [0, 1]], (6, 1))


def write_painted(folder, *, picture=True):
    """``box.obj`` 10 units wide with its MTL and a 4x4 texture ``paint.png``, unless it is to be missing."""
    import cv2

    vertices, triangles, uv = split_box()
    (folder / "box.obj").write_text(obj_text(vertices * 10, triangles, uv, "box.mtl"))
    (folder / "box.mtl").write_text("newmtl paint\nKd 1 1 1\nmap_Kd -s 1 1 1 paint.png\n")
    if picture:
        cv2.imwrite(str(folder / "paint.png"), np.arange(48, dtype=np.uint8).reshape(4, 4, 3) * 5)
    return folder / "box.obj"


NUMBERS = CORNERS.astype("<f4").tobytes() + box_triangles().astype("<u4").tobytes()
"""The unit cube's vertices and triangles as a buffer of glTF."""


def gltf_text(uri, image=None):
    """The unit cube as glTF, its numbers ``NUMBERS`` in the buffer ``uri``, painted with ``image``."""
    views = [(0, 96), (96, 144)]
    tree = {
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1, "material": 0}]}],
        "buffers": [{"uri": uri, "byteLength": len(NUMBERS)}],
        "bufferViews": [{"buffer": 0, "byteOffset": start, "byteLength": length} for start, length in views],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": 8, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 1]},
            {"bufferView": 1, "componentType": 5125, "count": 36, "type": "SCALAR"},
        ],
        "materials": [{"name": "paint", "pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}],
        "textures": [{"source": 0}],
        "images": [{"uri": image or "data:image/png;base64,aGVsbG8="}],
    }
    return json.dumps(tree)


def glb_bytes(pictures, materials):
    """The split cube as GLB: its triangles shared by ``materials``.

    Each is the number of its one of ``pictures`` (image files' bytes) or None.
    """
    vertices, triangles, uv = split_box()
    chunks = [vertices.astype("<f4").tobytes(), np.stack([uv[:, 0], 1 - uv[:, 1]], axis=1).astype("<f4").tobytes()]
    chunks += [part.astype("<u4").tobytes() for part in np.split(triangles, len(materials))]
    chunks, views, blob = [*chunks, *pictures], [], b""
    for chunk in chunks:
        views.append({"buffer": 0, "byteOffset": len(blob), "byteLength": len(chunk)})
        blob += chunk + b"\0" * (-len(chunk) % 4)
    places = {"min": vertices.min(axis=0).tolist(), "max": vertices.max(axis=0).tolist()}
    accessors = [{"bufferView": 0, "componentType": 5126, "count": 24, "type": "VEC3"} | places]
    accessors += [{"bufferView": 1, "componentType": 5126, "count": 24, "type": "VEC2"}]
    accessors += [
        {"bufferView": 2 + i, "componentType": 5125, "count": 36 // len(materials), "type": "SCALAR"}
        for i in range(len(materials))
    ]
    named = [
        {"pbrMetallicRoughness": {} if m is None else {"baseColorTexture": {"index": m}}, "name": f"m{i}"}
        for i, m in enumerate(materials)
    ]
    corners = {"POSITION": 0, "TEXCOORD_0": 1}
    tree = {
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0}],
        "meshes": [
            {"primitives": [{"attributes": corners, "indices": 2 + i, "material": i} for i in range(len(materials))]}
        ],
        "materials": named,
        "textures": [{"source": i} for i in range(len(pictures))],
        "images": [{"bufferView": 2 + len(materials) + i, "mimeType": "image/png"} for i in range(len(pictures))],
        "accessors": accessors,
        "bufferViews": views,
        "buffers": [{"byteLength": len(blob)}],
    }
    text = json.dumps(tree).encode()
    text += b" " * (-len(text) % 4)
    head = struct.pack("<4sIII4s", b"glTF", 2, 28 + len(text) + len(blob), len(text), b"JSON")
    return head + text + struct.pack("<I4s", len(blob), b"BIN\0") + blob
