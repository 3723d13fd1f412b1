"""Simulated scenes as a BOP dataset: one scene folder ``test/000001``, an image of each simulated scene, and the models.

::

    camera.json  ids.json (the objects' numbers by type, for `plogic bop --ids`)  test_targets_bop19.json
    models/      models_info.json  obj_000001.ply  obj_000001.png
    test/000001/ rgb/  depth/  mask/  mask_visib/  scene_camera.json  scene_gt.json  scene_gt_info.json
"""

from __future__ import annotations

from collections import Counter
from typing import TYPE_CHECKING, Any

import numpy as np

from geometry.visibility.rays import RayMesh
from plogic.base.errors import InputError
from plogic.run.bop.gt_info import gt_info, silhouette
from plogic.run.bop.json_files import MM
from plogic.run.bop.matching import VISIBLE
from plogic.run.bop.model_files import Kind, model_info, ply
from sensing.files.whole_files import new_folder
from sensing.simulated.scene import json_bytes, png

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping, Sequence
    from pathlib import Path

    from numpy.typing import NDArray

    from geometry.camera import Camera
    from sensing.simulated.camera import Rendering
    from sensing.simulated.scene import Scene

SCENE = "test/000001"
FINE, COARSE = 0.1, 1.0
"""``depth_scale``, mm: the coarse one where a body is farther than 16 bits of the fine one reach, 6.5 m."""
FARTHEST = 65535

Entry = dict[str, Any]


def write_dataset(scenes: Iterable[Scene], kinds: Sequence[Kind], folder: Path, supersample: int = 3) -> None:
    """Photograph the scenes into a new dataset, whole or not at all; the same scenes give the same bytes.

    The object of ``kinds[i]`` has the number i + 1. Bodies without a label are in the pictures and in no annotation.
    Metres become millimetres; a pixel without a thing, or beyond the depth's reach, has depth 0.

    Raises:
        InputError: There is no scene, or a body's label is no kind's.
        SceneError, SensingError: A picture cannot be made; the folder cannot be written.
    """
    numbers = {kind.label: i for i, kind in enumerate(kinds, 1)}
    shapes = {kind.label: RayMesh(kind.mesh.vertices, kind.mesh.triangles) for kind in kinds}
    cameras, truths, infos = {}, {}, {}
    camera: Camera | None = None
    with new_folder(folder) as place:
        for im_id, scene in enumerate(scenes):
            _check_labels(scene, numbers)
            picture, camera = scene.photograph(supersample), scene.camera
            scale = _scale(picture)
            depth = _depth(picture, scale)
            truths[im_id], infos[im_id] = _annotated(place / SCENE, im_id, scene, picture, depth, numbers, shapes)
            cameras[im_id] = _camera_entry(camera, scale)
            _put(place / SCENE / f"rgb/{im_id:06d}.png", png(picture.image))
            _put(place / SCENE / f"depth/{im_id:06d}.png", png(depth))
        if camera is None:
            raise InputError(f"{folder}: a dataset needs a scene")
        for name, document in (("scene_camera", cameras), ("scene_gt", truths), ("scene_gt_info", infos)):
            _put_json(place / SCENE / f"{name}.json", document)
        _put_json(place / "test_targets_bop19.json", _targets(truths, infos))
        _put_json(place / "camera.json", _sensor(camera))
        _put_json(place / "ids.json", numbers)
        _put_models(place / "models", kinds)


def _check_labels(scene: Scene, numbers: Mapping[str, int]) -> None:
    for body in scene.bodies:
        if body.label is not None and body.label not in numbers:
            raise InputError(f"body {body.label!r}: is none of the dataset's models: {', '.join(numbers)}")


def _annotated(
    place: Path,
    im_id: int,
    scene: Scene,
    picture: Rendering,
    depth: NDArray[Any],
    numbers: Mapping[str, int],
    shapes: Mapping[str, RayMesh],
) -> tuple[list[Entry], list[Entry]]:
    """The entries of one image, its masks being written on the way."""
    truths: list[Entry] = []
    infos: list[Entry] = []
    for i, (body, pose) in enumerate(zip(scene.bodies, scene.camera_from_bodies, strict=True)):
        if body.label is None:
            continue
        whole, visible = silhouette(shapes[body.label], pose, scene.camera), picture.segmentation == i
        name = f"{im_id:06d}_{len(truths):06d}.png"
        _put(place / "mask" / name, png(((whole.mask | visible) * 255).astype(np.uint8)))
        _put(place / "mask_visib" / name, png((visible * 255).astype(np.uint8)))
        R, t = pose[:3, :3].ravel().tolist(), (pose[:3, 3] * MM).tolist()
        truths.append({"cam_R_m2c": R, "cam_t_m2c": t, "obj_id": numbers[body.label]})
        infos.append(gt_info(whole, visible, depth > 0))
    return truths, infos


def _scale(picture: Rendering) -> float:
    """The ``depth_scale``, mm, that all bodies of a picture can be written with."""
    depths = picture.depth[picture.segmentation >= 0]
    return FINE if not len(depths) or float(depths.max()) * MM / FINE <= FARTHEST else COARSE


def _depth(picture: Rendering, scale: float) -> NDArray[Any]:
    """(H, W) uint16 steps of ``scale`` mm; 0 where nothing is, or too far."""
    steps = np.rint(np.where(np.isfinite(picture.depth), picture.depth, 0.0) * (MM / scale))
    return np.where(steps <= FARTHEST, steps, 0).astype(np.uint16)


def _camera_entry(camera: Camera, scale: float) -> Entry:
    entry: Entry = {"cam_K": camera.K.ravel().tolist(), "depth_scale": scale}
    if camera.camera_from_world is not None:
        entry |= {
            "cam_R_w2c": camera.camera_from_world[:3, :3].ravel().tolist(),
            "cam_t_w2c": (camera.camera_from_world[:3, 3] * MM).tolist(),
        }
    return entry


def _sensor(camera: Camera) -> Entry:
    K = camera.K
    focal = {"fx": float(K[0, 0]), "fy": float(K[1, 1]), "cx": float(K[0, 2]), "cy": float(K[1, 2])}
    return focal | {"width": camera.width, "height": camera.height, "depth_scale": FINE}


def _targets(truths: Mapping[int, list[Entry]], infos: Mapping[int, list[Entry]]) -> list[Entry]:
    """How many instances of which object are to be found in each image: those of which a tenth is visible."""
    rows = []
    for im_id, entries in truths.items():
        visible = zip(entries, infos[im_id], strict=True)
        counts = Counter(truth["obj_id"] for truth, info in visible if info["visib_fract"] >= VISIBLE)
        rows += [{"im_id": im_id, "inst_count": counts[n], "obj_id": n, "scene_id": 1} for n in sorted(counts)]
    return rows


def _put_models(place: Path, kinds: Sequence[Kind]) -> None:
    for i, kind in enumerate(kinds, 1):
        paint = None if kind.mesh.uv is None else kind.mesh.texture
        _put(place / f"obj_{i:06d}.ply", ply(kind.mesh, None if paint is None else f"obj_{i:06d}.png"))
        if paint is not None:
            _put(place / f"obj_{i:06d}.png", png(paint))
    _put_json(place / "models_info.json", {i: model_info(kind) for i, kind in enumerate(kinds, 1)})


def _put_json(path: Path, document: object) -> None:
    _put(path, json_bytes(document))


def _put(path: Path, data: bytes) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(data)
