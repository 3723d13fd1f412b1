"""The kinds of input that README names: what a good one looks like, how it is spoilt, and who reads it.

* ``Kind("image-png", as_png, picture_seeds(".png"), "picture.png", read_picture)``
"""

from __future__ import annotations

import shutil
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING

from benchmarks.fuzz import readers, seeds
from benchmarks.fuzz.mutators import (
    as_archive,
    as_bytes,
    as_glb,
    as_json,
    as_log,
    as_numbers,
    as_png,
    as_text,
    as_xml,
    as_yaml,
)
from benchmarks.fuzz.shaped import ShapedAs

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence
    from pathlib import Path

    from benchmarks.fuzz.mutators import Mutator


def nothing(_: Path) -> None:
    """What some kinds need beside them."""


@dataclass(frozen=True)
class Kind:
    """One kind of input.

    ``mutate`` changes one of the good ones, ``seeds``; the result is written to ``file``, below a folder that
    ``beside`` has filled, and handed to ``read``; one in ``every`` that is accepted also to ``use``, which is slow.
    Where ``read`` itself is slow, one in ``rare`` inputs of the others is tried.
    """

    name: str
    mutate: Mutator
    seeds: Callable[[], Sequence[bytes]]
    file: str
    read: Callable[[Path], object]
    beside: Callable[[Path], None] = nothing
    use: Callable[[Path], object] = nothing
    every: int = 1
    rare: int = 1


def _in_kb(name: str, folder: Path) -> None:
    from kb.files.folder import shipped

    shutil.copytree(shipped(name), folder, dirs_exist_ok=True)


def _beside_documents(folder: Path) -> None:
    (folder / "interpretation.json").write_bytes(seeds.example("interpretation.json")[0])


ASKED: dict[str, Sequence[str]] = {
    "worlds": ("worlds", "{}", "-n", "3"),
    "query": ("query", "{}", "present(H)"),
    "relations": ("query", "{}", "partially_occludes(X, Y)", "--reading", "posterior"),
    "explain": ("explain", "{}", "present(h1)"),
    "program": ("program", "{}"),
    "report": ("report", "{}", "-o", "-"),
    "measures": ("measures", "{}"),
    "next-view": ("next-view", "{}", "-n", "1"),
    "missing": ("explain", "{}", "--missing", "box"),
    "settle": ("settle", "{}"),
}
"""Every command that reads an interpretation, but for ``shell``, which reads it as these do."""


def _kinds() -> list[Kind]:
    pictures = [
        Kind(
            f"image-{name}",
            as_png if name == "png" else as_bytes,
            partial(seeds.pictures, name),
            f"x.{name}",
            readers.picture,
        )
        for name in ("png", "jpg", "bmp", "gif", "tiff", "webp", "pnm")
    ]
    cameras = [
        Kind(f"camera-{name}", mutate, partial(seeds.camera, name), file, readers.camera)
        for name, mutate, file in (
            ("json", as_json, "camera.json"),
            ("bop", as_json, "scene_camera.json"),
            ("opencv-json", as_json, "camera.json"),
            ("ros", as_yaml, "camera.yaml"),
            ("opencv", as_text, "camera.yml"),
            ("xml", as_xml, "camera.xml"),
            ("colmap", as_text, "cameras.txt"),
            ("colmap-bin", as_numbers, "cameras.bin"),
        )
    ]
    meshes = [
        Kind(f"mesh-{name}", mutate, partial(seeds.meshes, name), f"mesh.{name}", readers.mesh, nothing, readers.mesh_used, 25)
        for name, mutate in (
            ("obj", as_text), ("ply", as_text), ("stl", as_numbers), ("off", as_text), ("gltf", as_json), ("glb", as_glb),
        )
    ]  # fmt: skip
    first = partial(_in_kb, "first")
    authored = [
        *(
            Kind(name, as_yaml, partial(seeds.shipped, f"first/{file}"), file, readers.kb, first, readers.kb_used, 6)
            for name, file in (("kb.yaml", "kb.yaml"), ("object.yaml", "objects/box/object.yaml"))
        ),
        Kind("rules.pl", as_text, seeds.rules, "rules.pl", readers.kb, first),
        Kind("cloud", as_archive, seeds.clouds, "cloud.npz", readers.cloud),
        Kind("points", as_yaml, seeds.points, "points.yaml", readers.points),
        Kind("points-csv", as_text, seeds.point_rows, "points.csv", readers.points),
    ]
    carried = [
        *(
            Kind(name, ShapedAs(module, shape), partial(seeds.example, f"{name}.json"), f"{name}.json", read)
            for name, module, shape, read in (
                ("gamma", "sensing.files.gamma_files", "GammaRow", readers.gamma),
                ("poses", "geometry.files.pose_files", "PosesRow", readers.poses),
                ("stereo", "sensing.files.stereo", "StereoRow", readers.stereo),
                ("truth", "plogic.facts.document", "TruthRow", readers.truth),
            )
        ),
        Kind("poses-tum", as_text, seeds.trajectory, "poses.txt", readers.poses),
        Kind("moves", ShapedAs("geometry.files.pose_files", "MovesRow"), seeds.moves, "moves.json", readers.moves),
        Kind("stream", as_bytes, seeds.streams, "stream", readers.stream),
        Kind("batch-log", as_log, seeds.log, "log.jsonl", readers.log),
        *(
            Kind(f"video-{name}", as_bytes, partial(seeds.videos, name), f"x.{name}", readers.video, rare=100)
            for name in ("avi", "mp4", "mkv")
        ),
    ]
    logic = [
        Kind("program", as_text, seeds.programs, "x.pl", readers.program),
        Kind("goal", as_text, seeds.goals, "goal", readers.goal, _beside_documents, readers.goal_used, 50),
        Kind(
            "evidence",
            as_text,
            seeds.evidence,
            "evidence",
            readers.evidence,
            _beside_documents,
            readers.evidence_used,
            50,
        ),
        Kind("rules", as_text, seeds.rules, "own.pl", readers.rules, _beside_documents, readers.rules_used, 50),
    ]
    foreign = [
        Kind(f"bop-{name}", as_json, partial(seeds.bop, file), f"dataset/{file}", readers.bop, seeds.bop_dataset)
        for name, file in (
            ("camera", "test/000001/scene_camera.json"),
            ("truth", "test/000001/scene_gt.json"),
            ("visibility", "test/000001/scene_gt_info.json"),
            ("targets", "test_targets_bop19.json"),
        )
    ]
    foreign += [
        Kind(
            "bop-models",
            as_json,
            seeds.bop_models_info,
            "models/models_info.json",
            readers.bop_models,
            seeds.bop_models,
        ),
        Kind("bop-ids", as_json, lambda: [b'{"t1": 1, "t2": 2}'], "ids.json", readers.ids),
        Kind("urdf", as_xml, seeds.urdf, "robot.urdf", readers.urdf, seeds.robot_mesh),
        Kind("sdf", as_xml, seeds.sdf, "model.sdf", readers.sdf, seeds.robot_mesh),
    ]
    asked = [
        Kind(
            f"interpretation-{name}",
            ShapedAs("plogic.facts.document", "Interpretation"),
            partial(seeds.example, "interpretation.json"),
            "i.json",
            partial(readers.asked, words),
        )
        for name, words in ASKED.items()
    ]
    panorama = ShapedAs("plogic.sequence.constancy.panorama_reading", "Panorama")
    seed, next_view = partial(seeds.example, "panorama.json"), partial(readers.asked, ASKED["next-view"])
    asked += [Kind("panorama", panorama, seed, "p.json", next_view)]
    return [*pictures, *cameras, *meshes, *authored, *carried, *logic, *foreign, *asked]


def kinds() -> dict[str, Kind]:
    """All of them, by name."""
    return {kind.name: kind for kind in _kinds()}
