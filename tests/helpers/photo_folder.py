"""Small datasets of photos as ``plogic bench photos`` reads them, of painted cubes, beside what was learned of them.

And such a benchmark, run on them.
"""

from __future__ import annotations

import json

import cv2
from bop_folders import put
from console import plogic
from painted_cube import CAMERA, CORNER, SIDE, cloud, cube, picture, pose_towards, seen, write_knowledge

MM = 1000.0
POSES = {1: pose_towards(CORNER, 0.6), 2: pose_towards(CORNER, 0.8, roll=0.4, aside=(0.05, 0.0))}
"""camera_from_cube by photo."""


def models(folder, named):
    """``obj_000001.ply`` and so on, painted cubes, mm; ``named``: BOP numbers by name."""
    mesh = cube()
    rows = [f"{x * MM} {y * MM} {z * MM} {u} {v}" for (x, y, z), (u, v) in zip(mesh.vertices, mesh.uv, strict=True)]
    faces = [f"3 {a} {b} {c}" for a, b, c in mesh.triangles]
    places = "".join(f"property float {name}\n" for name in ("x", "y", "z", "texture_u", "texture_v"))
    for number in named.values():
        head = f"ply\nformat ascii 1.0\ncomment TextureFile obj_{number:06d}.png\nelement vertex {len(rows)}\n{places}"
        head += f"element face {len(faces)}\nproperty list uchar int vertex_indices\nend_header\n"
        put(folder / f"obj_{number:06d}.ply", head + "\n".join([*rows, *faces]) + "\n")
        cv2.imwrite(str(folder / f"obj_{number:06d}.png"), mesh.texture)
    info = {str(number): {"diameter": SIDE * 3**0.5 * MM, "name": name} for name, number in named.items()}
    put(folder / "models_info.json", info)


def photos(folder, named):
    """``photos/ycb`` with two photos of the first of these types, and ``kbs/ycb``, where all are learned alike."""
    models(folder / "photos/ycb/models", named)
    scene, number = folder / "photos/ycb/test/000001", min(named.values())
    truths = {
        str(i): [{"obj_id": number, "cam_R_m2c": [*pose[:3, :3].ravel()], "cam_t_m2c": [*(pose[:3, 3] * MM)]}]
        for i, pose in POSES.items()
    }
    put(scene / "scene_gt.json", truths)
    put(scene / "scene_camera.json", {i: {"cam_K": [*CAMERA.K.ravel()], "depth_scale": 1.0} for i in truths})
    (scene / "rgb").mkdir()
    for i, pose in POSES.items():
        cv2.imwrite(str(scene / f"rgb/{i:06d}.png"), picture([pose], seed=i))
    (folder / "kbs/ycb").mkdir(parents=True)
    write_knowledge(folder / "kbs/ycb", dict.fromkeys(named, cloud(seen())))
    return folder


def ran(folder, bench, *more):
    """The JSON of ``plogic bench NAME --quick`` on such a folder, and the process."""
    done = plogic("bench", bench, "--quick", "--json", "--kb", "kbs", *more, cwd=folder, PLOGIC_PHOTOS="photos")
    assert "Traceback" not in done.stderr
    return json.loads(done.stdout), done
