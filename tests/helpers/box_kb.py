"""A knowledge base of one type, a box with features written by hand, and which of these a camera would see."""

from __future__ import annotations

from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from learned_cube import CUBE

from geometry.camera import Camera
from geometry.frames import inverse, transform_points
from geometry.visibility.rays import behind
from kb.clouds.lobes import in_lobe
from kb.files.read import read_kb

CAMERA = Camera(640, 480, np.array([[600.0, 0, 319.5], [0, 600.0, 239.5], [0, 0, 1]]))
CORNERS = np.sign(CUBE.vertices)


def feature_row(name, look, at, axis, half_angle, indent="  "):
    """A line of ``object.yaml``: a feature of one appearance of its own name."""
    lobe = f"{{axis: {[float(a) for a in axis]}, half_angle: {half_angle} deg, range: [0.1 m, 9 m]}}"
    place = [float(a) for a in at]
    return f"{indent}- {{feature: {name}, type: {look}, at: {place}, appearances: [{{type: {look}, lobe: {lobe}}}]}}\n"


def corner_rows(half):
    """The eight corners of a box of these half lengths (3,), m."""
    return [feature_row(f"c{i}", "corner", corner * half, corner, 120) for i, corner in enumerate(CORNERS)]


def box_kb(name, half, rows):
    """The knowledge base; what rows look like it detects nine times of ten, a pixel off, with one of noise an image."""
    looks = sorted({row.split("type: ")[1].split(",")[0] for row in rows if "appearances" in row})
    each = ", ".join(looks)
    hit, noise = (", ".join(f"{look}: {rate}" for look in looks) for rate in (0.9, 1))
    mesh = "".join(f"v {x} {y} {z}\n" for x, y, z in CORNERS * half)
    mesh += "".join(f"f {a + 1} {b + 1} {c + 1}\n" for a, b, c in CUBE.triangles)
    with TemporaryDirectory() as place:
        folder = Path(place) / "objects" / name
        folder.mkdir(parents=True)
        (folder / "mesh.obj").write_text(mesh)
        head = f"object: {name}\nmesh: {{file: mesh.obj, units: m}}\nfeatures:\n"
        (folder / "object.yaml").write_text(head + "".join(rows))
        (Path(place) / "kb.yaml").write_text(
            f"name: {name}s\nappearance_types: [{each}]\nf_ref: 600\n"
            f"detector: {{hit: {{{hit}}}, clutter: {{{noise}}}, sigma: 1.0, match_tolerance: 4.0}}\npriors: {{{name}: 0.5}}\n"
        )
        return read_kb(place)


def seen(kb, pose, others=()):
    """(feature, pixel) of each that is in the image, in a lobe, and behind neither its own box nor others' at poses."""
    (kind,) = kb.types
    at = transform_points(pose, [f.at for f in kind.seen_features])
    uv, lobes = CAMERA.project(at), in_lobe(kind.lobes, inverse(pose)[:3, 3], CAMERA.f / kb.f_ref)[0]
    there = CAMERA.contains(uv) & np.isin(np.arange(len(at)), kind.lobes.feature[lobes])
    for other in (pose, *others):
        there &= ~behind(at, kind.surface.rays, other)
    return [(kind.seen_features[f], uv[f]) for f in np.flatnonzero(there)]
