"""Simulated scenes as a BOP dataset.

One scene folder ``test/000001``, an image of each simulated scene, and the models.

::

    camera.json  ids.json (the objects' numbers by type, which `plogic bop` reads)  test_targets_bop19.json
    models/      models_info.json  obj_000001.ply  obj_000001.png
    test/000001/ rgb/  depth/  mask/  mask_visib/  scene_camera.json  scene_gt.json  scene_gt_info.json

What BOP says of an object's picture besides its pose: silhouette, visible part, their boxes and the visible fraction.

The silhouette is what rays through the pixels' centres hit of the object alone, on a canvas three times as wide and
high as the image, so that what the image's border cuts off counts as hidden; the visible part is the rendering's own
segmentation.

A model is written as BOP wants it: ``obj_000001.ply`` in millimetres with normals (and texture), and its entry in
    ``models_info.json``.
"""

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from geometry.camera import Camera
from geometry.frames import inverse, rotate, transform_points
from geometry.visibility.rays import RayMesh
from kb.surfaces.symmetries import CONTINUOUS, symmetry_entries
from plogic.base.errors import InputError
from plogic.run.bop.dataset import IDS
from plogic.run.bop.json_files import MM
from plogic.run.bop.recalls import VISIBLE
from sensing.files.whole_files import new_folder
from sensing.simulated.body import TexturedMesh
from sensing.simulated.camera import Rendering
from sensing.simulated.scene import Scene, json_bytes, png


@dataclass(frozen=True, eq=False)
class Kind:
    """One type that scenes are made of.

    ``label`` of its bodies, its mesh, metres, and ``symmetries`` (S, 4, 4), a group.
    """

    label: str
    mesh: TexturedMesh
    symmetries: NDArray[np.float64] = field(default_factory=lambda: np.eye(4)[None])


def ply(mesh: TexturedMesh, texture: str | None) -> bytes:
    """Binary PLY, millimetres; ``texture`` names the image beside it, for a mesh with texture coordinates."""
    columns = [mesh.vertices * MM, vertex_normals(mesh)]
    names = ["x", "y", "z", "nx", "ny", "nz"]
    if texture is not None and mesh.uv is not None:
        columns, names = [*columns, mesh.uv], [*names, "texture_u", "texture_v"]
    faces = np.empty(len(mesh.triangles), dtype=[("count", "u1"), ("corners", "<i4", 3)])
    faces["count"], faces["corners"] = 3, mesh.triangles
    header = [
        "ply",
        "format binary_little_endian 1.0",
        *([f"comment TextureFile {texture}"] if texture is not None else []),
    ]
    header += [f"element vertex {len(mesh.vertices)}", *(f"property float {name}" for name in names)]
    header += [f"element face {len(faces)}", "property list uchar int vertex_indices", "end_header"]
    return "\n".join([*header, ""]).encode() + np.hstack(columns).astype("<f4").tobytes() + faces.tobytes()


def vertex_normals(mesh: TexturedMesh) -> NDArray[np.float64]:
    """(V, 3) unit: the mean of the normals of the triangles at each vertex, by their area.

    (0, 0, 1) where no triangle is.
    """
    a, b, c = np.moveaxis(mesh.corners, 1, 0)
    sums = np.zeros_like(mesh.vertices)
    for corner in range(3):
        np.add.at(sums, mesh.triangles[:, corner], np.cross(b - a, c - a))
    length = np.linalg.norm(sums, axis=1, keepdims=True)
    return np.where(length > 0, sums / np.where(length > 0, length, 1.0), (0.0, 0.0, 1.0))


def model_info(kind: Kind) -> dict[str, Any]:
    """The entry of ``models_info.json``: diameter, box and symmetries, millimetres."""
    low, high = kind.mesh.vertices.min(axis=0) * MM, kind.mesh.vertices.max(axis=0) * MM
    box = {f"min_{axis}": float(low[i]) for i, axis in enumerate("xyz")} | {
        f"size_{axis}": float(high[i] - low[i]) for i, axis in enumerate("xyz")
    }
    return {"diameter": diameter(kind.mesh.vertices) * MM} | box | _symmetries(kind.symmetries)


def diameter(points: NDArray[np.float64]) -> float:
    """The largest distance between two of ``points`` (N, 3): two corners of their hull."""
    from scipy.spatial import ConvexHull, QhullError

    try:
        corners = points[ConvexHull(points).vertices]
    except QhullError:  # flat
        corners = np.unique(points, axis=0)
    return float(np.sqrt(max(((corners[i:] - corner) ** 2).sum(axis=1).max() for i, corner in enumerate(corners))))


def _symmetries(group: NDArray[np.float64]) -> dict[str, Any]:
    """One axis where the group is the KB's stand-in for all turns about it; else every motion but the identity."""
    entries = symmetry_entries(group)
    if len(entries) == 1 and entries[0].get("fold") == CONTINUOUS:
        return {"symmetries_continuous": [{"axis": entries[0]["axis"], "offset": [0.0, 0.0, 0.0]}]}
    scaled = np.array(group, dtype=np.float64)
    scaled[:, :3, 3] *= MM
    others = [motion.ravel().tolist() for motion in scaled if np.abs(motion - np.eye(4)).max() > 1e-9]
    return {"symmetries_discrete": others} if others else {}


Box = list[int]
NOTHING: Box = [-1, -1, -1, -1]


@dataclass(frozen=True, eq=False)
class Silhouette:
    """``mask`` (H, W): the part in the image.

    ``pixels`` and ``box`` (x, y, width, height) of all of it, beyond the border too.
    """

    mask: NDArray[np.bool_]
    pixels: int
    box: Box


def silhouette(shape: RayMesh, camera_from_object: NDArray[np.float64], camera: Camera) -> Silhouette:
    """The picture of one object alone; of one that is not before the camera, nothing."""
    mask = np.zeros((camera.height, camera.width), dtype=bool)
    u, v = _grid(transform_points(camera_from_object, shape.vertices), camera)
    rays = camera.rays(np.stack([u, v], axis=-1).astype(np.float64))
    object_from_camera = inverse(camera_from_object)
    hit = np.isfinite(shape.first_hit(object_from_camera[None, :3, 3], rotate(object_from_camera, rays)))
    u, v = u[hit], v[hit]
    inside = (u >= 0) & (u < camera.width) & (v >= 0) & (v < camera.height)
    mask[v[inside], u[inside]] = True
    return Silhouette(mask, len(u), box_of(u, v))


def _grid(points_camera: NDArray[np.float64], camera: Camera) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """The pixels (N,), (N,) of the canvas that points' images lie among; all of it where a point has no image."""
    uv = camera.project(points_camera)
    size = np.array([camera.width, camera.height])
    known = bool(np.isfinite(uv).all())
    low = np.clip(np.floor(uv.min(axis=0)), -size, 2 * size - 1) if known else -size
    high = np.clip(np.ceil(uv.max(axis=0)), -size, 2 * size - 1) if known else 2 * size - 1
    u, v = np.meshgrid(np.arange(int(low[0]), int(high[0]) + 1), np.arange(int(low[1]), int(high[1]) + 1))
    return u.ravel(), v.ravel()


def box_of(u: NDArray[Any], v: NDArray[Any]) -> Box:
    """BOP's box (x, y, width, height) of pixels; -1 for none.

    As in the benchmark the width is the last column minus the first.
    """
    if not len(u):
        return list(NOTHING)
    return [int(u.min()), int(v.min()), int(u.max() - u.min()), int(v.max() - v.min())]


def gt_info(whole: Silhouette, visible: NDArray[np.bool_], measured: NDArray[np.bool_]) -> dict[str, Any]:
    """One entry of ``scene_gt_info.json``.

    ``visible`` and ``measured`` (H, W): the object's pixels, and those that have a depth.

    A visible pixel at the edge that no ray has hit counts as the silhouette's.
    """
    extra = int((visible & ~whole.mask).sum())
    everything, seen = whole.pixels + extra, int(visible.sum())
    v, u = np.nonzero(visible)
    return {
        "bbox_obj": whole.box,
        "bbox_visib": box_of(u, v),
        "px_count_all": everything,
        "px_count_valid": int((measured & (whole.mask | visible)).sum()),
        "px_count_visib": seen,
        "visib_fract": seen / everything if everything else 0.0,
    }


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
        _put_json(place / IDS, numbers)
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
