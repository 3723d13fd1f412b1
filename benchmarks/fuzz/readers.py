"""Who reads a kind of input: the function that a command calls, or the command itself, in this process."""

from __future__ import annotations

import tempfile
from contextlib import redirect_stderr, redirect_stdout
from functools import cache
from io import BytesIO, StringIO
from typing import TYPE_CHECKING, Any

from benchmarks.fuzz import seeds
from geometry.errors import PlogicError, WhichCameraError

if TYPE_CHECKING:
    from collections.abc import Sequence
    from pathlib import Path


def picture(path: Path) -> None:
    """A picture, and what its EXIF tells."""
    from sensing.files.exif import exif_of
    from sensing.files.images import read_image

    exif_of(path.read_bytes())
    read_image(path)


def stream(path: Path) -> None:
    """Pictures that come one after another."""
    from sensing.files.picture_stream import pictures_in

    for _ in pictures_in(BytesIO(path.read_bytes()), "stream"):
        pass


def video(path: Path) -> None:
    """The frames of a video, all of which are decoded."""
    from plogic.run.video.video import Video

    with Video(path) as frames:
        frames.frame(0)
        frames.count()


def gamma(path: Path) -> None:
    """A gamma/1."""
    from sensing.files.gamma_files import read_gamma

    read_gamma(path)


def camera(path: Path) -> None:
    """A camera; of many, the first."""
    from geometry.files.camera_files import read_camera

    try:
        read_camera(path, size=(640, 480))
    except WhichCameraError:
        read_camera(path, 1, size=(640, 480))


def kb(path: Path) -> None:
    """A knowledge base."""
    from plogic.run.sources import kb_of

    kb_of(str(_above(path)))


def _above(path: Path) -> Path:
    return next(above for above in path.parents if (above / "kb.yaml").exists())


def kb_used(path: Path) -> None:
    """It is checked and perceived with, a scene is made of it, and it is shown."""
    folder = str(_above(path))
    command(path, "kb", "check", folder)
    command(path, "perceive", str(seeds.EXAMPLES / "first_gamma.json"), "--kb", folder, "--deadline", "5")
    with tempfile.TemporaryDirectory() as made:
        command(path, "simulate", "--kb", folder, "--gamma", "-o", f"{made}/made")
        command(path, "kb", "show", folder, "--html", f"{made}/page.html")


def mesh(path: Path) -> None:
    """As a KB reads it, and as ``kb add`` does."""
    from kb.intake.source import read_source
    from kb.surfaces.surface import surface_from_mesh

    surface_from_mesh(path)
    read_source(path)


def mesh_used(path: Path) -> None:
    """A type is made of it."""
    from kb.intake.new_type import new_type
    from kb.intake.source import read_source

    new_type("thing", read_source(path), "m", path)


def cloud(path: Path) -> None:
    """A learned cloud."""
    from kb.clouds.learned import read_cloud

    read_cloud(path.read_bytes())


def points(path: Path) -> None:
    """Clicked points."""
    from kb.learning.photo import read_points

    read_points(path, "m")


def poses(path: Path) -> None:
    """Poses of cameras."""
    from geometry.files.pose_files import read_poses

    read_poses(path)


def moves(path: Path) -> None:
    """Places to look from."""
    from geometry.files.pose_files import read_moves

    read_moves(path)


def stereo(path: Path) -> None:
    """Two cameras."""
    from sensing.files.stereo import read_stereo

    read_stereo(path)


def truth(path: Path) -> None:
    """What stands there."""
    from plogic.rates.scene_records import read_truth

    read_truth(path, ["box", "t1"])


def program(path: Path) -> None:
    """All but the asking, which is a process of its own: as ``program`` and ``explain`` read it."""
    from plogic.logic.safety.check import check_source, parse
    from plogic.run.sources import program_text_of

    check_source(parse(program_text_of(str(path)), str(path)))


def bop(path: Path) -> None:
    """A BOP dataset."""
    from plogic.run.bop.dataset import open_dataset

    folder = next(above for above in path.parents if above.name == "dataset")
    dataset = open_dataset(folder)
    frames, _ = dataset.listed()
    for scene_id, im_id in frames[:2]:
        scene = dataset.scene(scene_id)
        scene.frame(im_id)
        scene.truths(im_id)


def bop_models(path: Path) -> None:
    """A BOP dataset's models."""
    from kb.intake.bop_models import bop_models, bop_symmetries
    from plogic.run.bop.models import model_names, read_models

    for name, _, row in bop_models(path.parent):
        bop_symmetries(row, "mm", name)
    model_names(path.parent)
    read_models(path.parent, [1, 2])


def ids(path: Path) -> None:
    """The numbers of BOP's objects."""
    from plogic.run.bop.models import read_ids

    read_ids(str(path))


def urdf(path: Path) -> None:
    """A robot."""
    from kb.intake.robots import frozen_joints, merged, urdf_visuals

    frozen_joints(path)
    merged(path, urdf_visuals(path))


def sdf(path: Path) -> None:
    """A model or world."""
    from kb.intake.robots import merged, sdf_visuals

    merged(path, sdf_visuals(path))


def log(path: Path) -> None:
    """What a batch wrote."""
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


def goal(path: Path) -> None:
    """A goal."""
    from plogic.logic.safety.check import parse

    parse(f"{path.read_text('utf-8', 'replace').rstrip().removesuffix('.')}\n.", "goal")


def goal_used(path: Path) -> None:
    """It is asked, of an interpretation."""
    _scene(_beside(path)).query(path.read_text("utf-8", "replace"))


def evidence(path: Path) -> None:
    """Lines of evidence."""
    from plogic.logic.safety.check import parse

    for line in path.read_text("utf-8", "replace").splitlines()[:3]:
        parse(f"{line}.", "evidence")


def evidence_used(path: Path) -> None:
    """A session observes them."""
    from plogic import Session

    with Session(_scene(_beside(path))) as session:
        for line in path.read_text("utf-8", "replace").splitlines()[:3]:
            session.observe(line)


def rules(path: Path) -> None:
    """Rules."""
    from plogic.logic.safety.atoms import Names
    from plogic.logic.safety.author import author_rules
    from plogic.run.sources import program_text_of
    from plogic.scene.text.rules import defined

    author_rules(program_text_of(str(path)), Names({}, {}), defined())


def rules_used(path: Path) -> None:
    """An interpretation is asked by them."""
    _scene(_beside(path)).query("present(H)", rules=str(path))


def asked(words: Sequence[str], path: Path) -> None:
    """A command that reads it."""
    command(path, *words)
