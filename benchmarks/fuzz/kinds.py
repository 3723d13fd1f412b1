"""The kinds of input that README names: what a good one looks like, how it is spoilt, and who reads it.

* ``Kind("image-png", as_png, picture_seeds(".png"), "picture.png", read_picture)``
"""

from __future__ import annotations

import shutil
import tempfile
from contextlib import redirect_stderr, redirect_stdout
from dataclasses import dataclass
from functools import cache, partial
from io import BytesIO, StringIO
from typing import TYPE_CHECKING, Any
from zlib import crc32

from benchmarks.fuzz import seeds
from benchmarks.fuzz.mutators import as_archive, as_bytes, as_glb, as_json, as_png, as_text, as_xml
from benchmarks.fuzz.shaped import ShapedAs
from geometry.errors import PlogicError

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
    ``beside`` has filled, and handed to ``read``.
    """

    name: str
    mutate: Mutator
    seeds: Callable[[], Sequence[bytes]]
    file: str
    read: Callable[[Path], object]
    beside: Callable[[Path], None] = nothing


# -- readers -----------------------------------------------------------------------------------------------------------


def _picture(path: Path) -> None:
    from sensing.files.exif import exif_of
    from sensing.files.images import read_image

    exif_of(path.read_bytes())
    read_image(path)


def _stream(path: Path) -> None:
    from sensing.files.picture_stream import pictures_in

    for _ in pictures_in(BytesIO(path.read_bytes()), "stream"):
        pass


def _gamma(path: Path) -> None:
    from sensing.files.gamma_files import read_gamma

    read_gamma(path)


def _camera(path: Path) -> None:
    from geometry.files.camera_files import read_camera

    read_camera(path, size=(640, 480))


def _kb(path: Path) -> None:
    from plogic.run.sources import kb_of

    kb_of(str(_above(path)))


def _above(path: Path) -> Path:
    return next(above for above in path.parents if (above / "kb.yaml").exists())


def _kb_used(path: Path) -> None:
    """As ``kb check`` reads it; one in six that are accepted is shown, perceived with, and a scene is made of it."""
    _kb(path)
    kb = str(_above(path))
    if crc32(path.read_bytes()) % 6 == 0:
        command(path, "perceive", str(seeds.EXAMPLES / "first_gamma.json"), "--kb", kb, "--deadline", "5")
        with tempfile.TemporaryDirectory() as folder:
            command(path, "simulate", "--kb", kb, "--gamma", "-o", f"{folder}/made")
            command(path, "kb", "show", kb, "--html", f"{folder}/page.html")


def _mesh(path: Path) -> None:
    """As a KB reads it and as ``kb add`` does; of one in 25 a type is made, which takes a third of a second."""
    from kb.intake.new_type import new_type
    from kb.intake.source import read_source
    from kb.surfaces.surface import surface_from_mesh

    surface_from_mesh(path)
    source = read_source(path)
    if crc32(path.read_bytes()) % 25 == 0:
        new_type("thing", source, "m", path)


def _cloud(path: Path) -> None:
    from kb.clouds.learned import read_cloud

    read_cloud(path.read_bytes())


def _points(path: Path) -> None:
    from kb.learning.photo import read_points

    read_points(path, "m")


def _poses(path: Path) -> None:
    from geometry.files.pose_files import read_poses

    read_poses(path)


def _moves(path: Path) -> None:
    from geometry.files.pose_files import read_moves

    read_moves(path)


def _stereo(path: Path) -> None:
    from sensing.files.stereo import read_stereo

    read_stereo(path)


def _truth(path: Path) -> None:
    from plogic.rates.scene_records import read_truth

    read_truth(path, ["box", "t1"])


def _program(path: Path) -> None:
    """All but the asking, which is a process of its own: as ``program`` and ``explain`` read it."""
    from plogic.logic.safety.check import check_source, parse
    from plogic.run.sources import program_text_of

    check_source(parse(program_text_of(str(path)), str(path)))


def _bop(path: Path) -> None:
    from plogic.run.bop.dataset import open_dataset

    folder = next(above for above in path.parents if above.name == "dataset")
    dataset = open_dataset(folder)
    frames, _ = dataset.listed()
    for scene_id, im_id in frames[:2]:
        scene = dataset.scene(scene_id)
        scene.frame(im_id)
        scene.truths(im_id)


def _bop_models(path: Path) -> None:
    from kb.intake.bop_models import bop_models, bop_symmetries
    from plogic.run.bop.models import model_names, read_models

    for name, _, row in bop_models(path.parent):
        bop_symmetries(row, "mm", name)
    model_names(path.parent)
    read_models(path.parent, [1, 2])


def _ids(path: Path) -> None:
    from plogic.run.bop.models import read_ids

    read_ids(str(path))


def _urdf(path: Path) -> None:
    from kb.intake.robots import frozen_joints, merged, urdf_visuals

    frozen_joints(path)
    merged(path, urdf_visuals(path))


def _sdf(path: Path) -> None:
    from kb.intake.robots import merged, sdf_visuals

    merged(path, sdf_visuals(path))


def _log(path: Path) -> None:
    from plogic.run.batch.log import read_lines

    read_lines(path, str(path))


# -- commands, in this process -----------------------------------------------------------------------------------------


def command(path: Path, *arguments: str) -> None:
    """Run one as the console does; ``{}`` is the input's path. Raises PlogicError for bad input and bad usage."""
    from click.exceptions import ClickException

    from cli import cli

    words = [str(path) if word == "{}" else word for word in arguments]
    with redirect_stdout(StringIO()), redirect_stderr(StringIO()):
        try:
            cli.main(words, standalone_mode=False)
        except ClickException as error:
            raise PlogicError(error.format_message()) from error
        except SystemExit as end:
            if end.code not in (0, 1, 2, 3, None):
                raise RuntimeError(f"exit status {end.code}") from end


@cache
def _scene(path: Path) -> Any:  # noqa: ANN401 - an Interpretation
    """An interpretation that is asked again and again."""
    from plogic import Interpretation

    return Interpretation.load(str(path))


def _beside(path: Path) -> Path:
    return path.with_name("interpretation.json")


ASKED_OF = 50
"""Of so many goals, rules and lines of evidence one is asked: that takes a process, and half a second."""


def _goal(path: Path) -> None:
    from plogic.logic.safety.check import parse

    text = path.read_text("utf-8", "replace")
    parse(f"{text.rstrip().removesuffix('.')}\n.", "goal")
    if crc32(text.encode()) % ASKED_OF == 0:
        _scene(_beside(path)).query(text)


def _evidence(path: Path) -> None:
    """Some lines that a session observes."""
    from plogic import Session
    from plogic.logic.safety.check import parse

    text = path.read_text("utf-8", "replace")
    for line in text.splitlines()[:3]:
        parse(f"{line}.", "evidence")
    if crc32(text.encode()) % ASKED_OF == 0:
        with Session(_scene(_beside(path))) as session:
            for line in text.splitlines()[:3]:
                session.observe(line)


def _rules(path: Path) -> None:
    from plogic.logic.safety.atoms import Names
    from plogic.logic.safety.author import author_rules
    from plogic.run.sources import program_text_of
    from plogic.scene.text.rules import defined

    text = program_text_of(str(path))
    author_rules(text, Names({}, {}), defined())
    if crc32(text.encode("utf-8", "replace")) % ASKED_OF == 0:
        _scene(_beside(path)).query("present(H)", rules=str(path))


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
}
"""Every command that reads an interpretation, but for ``shell`` and ``settle``, which read it as these do."""


def _kinds() -> list[Kind]:
    pictures = [
        Kind(
            f"image-{name}", as_png if name == "png" else as_bytes, partial(seeds.pictures, name), f"x.{name}", _picture
        )
        for name in ("png", "jpg", "bmp", "gif", "tiff", "webp", "pnm")
    ]
    cameras = [
        Kind(f"camera-{name}", mutate, partial(seeds.camera, name), file, _camera)
        for name, mutate, file in (
            ("json", as_json, "camera.json"),
            ("bop", as_json, "scene_camera.json"),
            ("opencv-json", as_json, "camera.json"),
            ("ros", as_text, "camera.yaml"),
            ("opencv", as_text, "camera.yml"),
            ("xml", as_xml, "camera.xml"),
            ("colmap", as_text, "cameras.txt"),
            ("colmap-bin", as_bytes, "cameras.bin"),
        )
    ]
    meshes = [
        Kind(f"mesh-{name}", mutate, partial(seeds.meshes, name), f"mesh.{name}", _mesh)
        for name, mutate in (
            ("obj", as_text), ("ply", as_text), ("stl", as_bytes), ("off", as_text), ("gltf", as_json), ("glb", as_glb),
        )
    ]  # fmt: skip
    first = partial(_in_kb, "first")
    authored = [
        Kind("kb.yaml", as_text, partial(seeds.shipped, "first/kb.yaml"), "kb.yaml", _kb_used, first),
        Kind(
            "object.yaml",
            as_text,
            partial(seeds.shipped, "first/objects/box/object.yaml"),
            "objects/box/object.yaml",
            _kb_used,
            first,
        ),
        Kind("rules.pl", as_text, seeds.rules, "rules.pl", _kb, first),
        Kind("cloud", as_archive, seeds.clouds, "cloud.npz", _cloud),
        Kind("points", as_text, seeds.points, "points.yaml", _points),
        Kind("points-csv", as_text, seeds.point_rows, "points.csv", _points),
    ]
    carried = [
        Kind(
            "gamma",
            ShapedAs("sensing.files.gamma_files", "GammaRow"),
            partial(seeds.example, "gamma.json"),
            "gamma.json",
            _gamma,
        ),
        Kind(
            "poses",
            ShapedAs("geometry.files.pose_files", "PosesRow"),
            partial(seeds.example, "poses.json"),
            "poses.json",
            _poses,
        ),
        Kind("poses-tum", as_text, seeds.trajectory, "poses.txt", _poses),
        Kind("moves", ShapedAs("geometry.files.pose_files", "MovesRow"), seeds.moves, "moves.json", _moves),
        Kind(
            "stereo",
            ShapedAs("sensing.files.stereo", "StereoRow"),
            partial(seeds.example, "stereo.json"),
            "stereo.json",
            _stereo,
        ),
        Kind(
            "truth",
            ShapedAs("plogic.facts.document", "TruthRow"),
            partial(seeds.example, "truth.json"),
            "truth.json",
            _truth,
        ),
        Kind("stream", as_bytes, seeds.streams, "stream", _stream),
        Kind("batch-log", as_json, seeds.log, "log.jsonl", _log),
    ]
    logic = [
        Kind("program", as_text, seeds.programs, "x.pl", _program),
        Kind("goal", as_text, seeds.goals, "goal", _goal, _beside_documents),
        Kind("evidence", as_text, seeds.evidence, "evidence", _evidence, _beside_documents),
        Kind("rules", as_text, seeds.rules, "own.pl", _rules, _beside_documents),
    ]
    foreign = [
        Kind(f"bop-{name}", as_json, partial(seeds.bop, file), f"dataset/{file}", _bop, seeds.bop_dataset)
        for name, file in (
            ("camera", "test/000001/scene_camera.json"),
            ("truth", "test/000001/scene_gt.json"),
            ("visibility", "test/000001/scene_gt_info.json"),
            ("targets", "test_targets_bop19.json"),
        )
    ]
    foreign += [
        Kind("bop-models", as_json, seeds.bop_models_info, "models/models_info.json", _bop_models, seeds.bop_models),
        Kind("bop-ids", as_json, lambda: [b'{"t1": 1, "t2": 2}'], "ids.json", _ids),
        Kind("urdf", as_xml, seeds.urdf, "robot.urdf", _urdf, seeds.robot_mesh),
        Kind("sdf", as_xml, seeds.sdf, "model.sdf", _sdf, seeds.robot_mesh),
    ]
    asked = [
        Kind(
            f"interpretation-{name}",
            ShapedAs("plogic.facts.document", "Interpretation"),
            partial(seeds.example, "interpretation.json"),
            "i.json",
            partial(_asked, words),
        )
        for name, words in ASKED.items()
    ]
    panorama = ShapedAs("plogic.sequence.constancy.panorama_reading", "Panorama")
    seed, next_view = partial(seeds.example, "panorama.json"), partial(_asked, ASKED["next-view"])
    asked += [Kind("panorama", panorama, seed, "p.json", next_view)]
    return [*pictures, *cameras, *meshes, *authored, *carried, *logic, *foreign, *asked]


def _asked(words: Sequence[str], path: Path) -> None:
    command(path, *words)


def kinds() -> dict[str, Kind]:
    """All of them, by name."""
    return {kind.name: kind for kind in _kinds()}
