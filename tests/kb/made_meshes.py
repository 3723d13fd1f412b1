"""Small meshes as files, for tests of the intake."""

from __future__ import annotations

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
    """The cube with every face's corners its own, as texture seams split them: 24 vertices, 12 triangles, uv (24, 2)."""
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
