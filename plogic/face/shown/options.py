"""Options and arguments of commands, and what carries them to the functions that do the work."""

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import wraps
from pathlib import Path
from typing import Any, Literal

import click

from plogic.base.errors import InputError
from plogic.face.shown.figures import MOST, places
from plogic.facts.situation import DvOver, Reading, Reconsider
from plogic.run.cameras import NOTHING_GIVEN, GivenCamera

READINGS = click.Choice(["score", "posterior"])
SEED = click.IntRange(0)
MODES = click.Choice(["to_B", "drop", "reassign"])
PLACE = click.Path(readable=False)
"""A file or folder, or ``-``: nothing is checked of it here, but shells complete its name."""
INTERPRETATION = click.argument("interpretation", metavar="INTERPRETATION", type=PLACE)
SOURCE = click.argument("source", metavar="INTERPRETATION|PROGRAM.pl", type=PLACE)
GIVEN = click.option(
    "--given",
    multiple=True,
    metavar="EVIDENCE",
    help="A literal that is observed; may be repeated. Of one with variables some instance holds.",
)
RULES = click.option("--rules", type=PLACE, help="A file of your own rules.")
READING = click.option(
    "--reading", type=READINGS, help="The other reading of the same Δh (default: the interpretation's own)."
)
TRUST = click.option(
    "--trust",
    is_flag=True,
    help="Lift the allow-list from a program of your own: it may then run Python and read files.",
)
WITHHOLD = click.option(
    "--withhold",
    multiple=True,
    metavar="HYPOTHESIS",
    help="Answer as somebody who does not know where it stands: its relations by what is detected; "
    "OTHER.json:HYPOTHESIS for one that is seen in another image (may be repeated).",
)


def _shown_to(ctx: click.Context, _: click.Parameter, number: int | None) -> None:
    """Show probabilities to so many places while the command runs."""
    ctx.with_resource(places(number))


DIGITS = click.option(
    "--digits",
    type=click.IntRange(1, MOST),
    expose_value=False,
    callback=_shown_to,
    help="Places of the probabilities that are shown (default: 3); --json has all.",
)
POSE_TABLE = click.option(
    "--poses",
    "poses",
    is_flag=True,
    help="CSV instead: of each object in each world T_camera_object, and T_world_object where the camera has a pose "
    "(4x4, row by row, metres).",
)
AS_JSON = click.option("--json", "as_json", is_flag=True, help="One versioned JSON document on stdout.")


class Number(click.FloatRange):
    """A range that NaN is outside of: every comparison with NaN is false, so that click lets it pass."""

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> float:  # noqa: ANN401 - click's
        """The number; fails as bad usage."""
        number = super().convert(value, param, ctx)
        return self.fail(f"{value} is no number", param, ctx) if math.isnan(number) else number


KB = click.option(
    "--kb",
    "kb_folder",
    required=True,
    type=PLACE,
    help="Folder of the knowledge base; `first` and `towers` are shipped.",
)
EVERY = click.option(
    "--every", type=click.IntRange(1), default=1, show_default=True, help="Of a video, each so many-th frame."
)


def camera_options(without: str) -> Callable[[Callable[..., None]], Callable[..., None]]:
    """The options that tell the camera of pictures, at most one of them, as one ``camera``, a ``GivenCamera``.

    ``without``: what happens where none is given, for the help text.
    """
    what = (
        f"Camera of pictures, of ours, ROS, OpenCV, BOP or COLMAP (its folder as well); #NAME is one of many. {without}"
    )
    view = Number(0.0, 180.0, min_open=True, max_open=True)
    ways = [
        click.option("--camera", type=click.Path(), metavar="FILE[#NAME]", help=what),
        click.option("--fov", type=view, metavar="DEG", help="Instead: field of view across, no distortion."),
        click.option("--fov-diagonal", type=view, metavar="DEG", help="Instead: field of view from corner to corner."),
        click.option(
            "--focal", type=Number(0.0, 1e9, min_open=True), metavar="PX", help="Instead: focal length in pixels."
        ),
    ]

    def with_options(command: Callable[..., None]) -> Callable[..., None]:
        @wraps(command)
        def told(*args: Any, camera: str | None, **options: Any) -> None:  # noqa: ANN401 - click's
            others = {name: options.pop(name) for name in ("fov", "fov_diagonal", "focal")}
            try:
                given = GivenCamera(camera, **others)
            except InputError as error:
                raise click.UsageError(str(error)) from None
            command(*args, camera=given, **options)

        for option in reversed(ways):
            told = option(told)
        return told

    return with_options


CAMERA = camera_options(
    "Where no camera is given, camera.json beside the picture is taken, or else EXIF's focal length, and said."
)
FIRST_READING = click.option("--reading", type=READINGS, default="score", show_default=True)
RECONSIDER = click.option(
    "--reconsider", type=MODES, default="to_B", show_default=True, help="How explained misses count (score reading)."
)
DV_OVER = click.option(
    "--dv-over",
    type=click.Choice(["types", "instances"]),
    default="types",
    show_default=True,
    help="What dv counts features over: the types of the KB, or the instances in Δ.",
)
SMOOTHING = click.option(
    "--smoothing",
    type=Number(0.0, 0.5, max_open=True),
    default=0.0,
    show_default=True,
    help="ε of the score program's choices.",
)
GENERATOR = click.option(
    "--generator",
    type=click.Choice(["index", "quadruples", "softposit"]),
    default="index",
    show_default=True,
    help="Who proposes poses of types written by hand: the fast search, or the paper's plain ones; learned types have their own.",
)
BEST_BY = click.option(
    "--deadline",
    type=Number(0.0, min_open=True),
    help="Seconds from when KB, index and Γ are there (several views: all frames together, with detection); "
    "then the best answer so far is marked unfinished (exit 3).",
)
DEADLINE = click.option(
    "--deadline",
    type=Number(0.0, min_open=True),
    help="Seconds; then every answer is an interval that contains the exact one (exit 3).",
)
Marks = Literal["few", "all", "none"]
MARKS = click.option(
    "--marks",
    type=click.Choice(["few", "all", "none"]),
    default="few",
    show_default=True,
    help="Marks of features in the picture: where they are not hundreds (`few`), `all`, or `none`.",
)
BOP = click.option("--bop", type=click.Path(path_type=Path), help="New folder for scenes as a BOP dataset as well.")
BOP_IMAGES = click.option(
    "--bop-images",
    type=click.IntRange(1, 1000),
    default=1,
    show_default=True,
    help="Its images: scenes of this seed and the next.",
)
ROBOT = click.option(
    "--robot",
    metavar="MOVES.json|ring:N",
    help="Look again from elsewhere: a moves/1 or poses/1 file, or N places around; frames and poses.json.",
)


@dataclass(frozen=True)
class Asking:
    """How an interpretation or a program is asked.

    ``reading``: the other one of the same Δh, None for its own; ``deadline`` in seconds; ``rules``: a file of a user's
    own; ``trust`` lifts the allow-list of a program; ``withhold``: hypotheses whose poses nobody knows; ``poses``: of
    worlds, those of their objects are asked for.
    """

    reading: Reading | None = None
    deadline: float | None = None
    trust: bool = False
    rules: str | None = None
    withhold: tuple[str, ...] = ()
    poses: bool = False


@dataclass(frozen=True)
class Perceiving:
    """How ``plogic perceive`` interprets its inputs with ``kb``, and the files that it writes.

    ``camera``: what was given for that of pictures; ``poses``: where it stood for each of several frames; ``stereo``:
    the calibration of a pair; ``deadline`` in seconds; ``out`` is stdout where it is ``-``; ``every``: of a video each
    so many-th frame.
    """

    kb: str
    out: str = "-"
    camera: GivenCamera = NOTHING_GIVEN
    poses: str | None = None
    stereo: str | None = None
    reading: Reading = "score"
    reconsider: Reconsider = "to_B"
    smoothing: float = 0.0
    dv_over: DvOver = "types"
    generator: str = "index"
    deadline: float | None = None
    report: Path | None = None
    picture: Path | None = None
    marks: Marks = "few"
    timings: Path | None = None
    every: int = 1


@dataclass(frozen=True)
class Moves:
    """``about``: the goal that should become certain.

    Where the camera may go, one of ``ring`` m, ``within`` m and a file of ``moves``.

    ``reading``: the other one of the same Δh, None for its own.
    """

    about: str | None = None
    ring: float | None = None
    moves: Path | None = None
    within: float | None = None
    reading: Reading | None = None


@dataclass(frozen=True)
class Batching:
    """How ``plogic batch`` works through its frames, and where their lines go.

    ``out``: a file, ``-`` for stdout; ``order``: ``input`` or ``done``; ``jobs``: processes of this machine, None for
    one a core; ``dask``: the address of a cluster that works instead; ``timeout``: seconds that a frame may take;
    ``every``: of a video each so many-th frame.
    """

    out: str = "-"
    resume: bool = False
    order: str = "input"
    jobs: int | None = None
    dask: str | None = None
    timeout: float | None = None
    every: int = 1


@dataclass(frozen=True)
class Watching:
    """Which frames ``plogic watch`` takes, and what it writes of each.

    Each ``every``-th frame, ``limit`` of them at most; ``newest``: of a stream, the newest one. ``short`` lines, as of
    ``plogic batch``; ``picture``: where the newest picture stands; ``pictures``: the folder of all; ``jobs``: processes
    that interpret a frame each, None for one a core.
    """

    every: int = 1
    jobs: int | None = None
    limit: int | None = None
    newest: bool = False
    short: bool = False
    picture: Path | None = None
    pictures: Path | None = None
    marks: Marks = "few"


@dataclass(frozen=True)
class Scoring:
    """How ``plogic bop`` answers: the file with BOP's ``ids`` of types, whether images are ``timed``, text or JSON."""

    ids: str | None = None
    timed: bool = False
    as_json: bool = False


@dataclass(frozen=True)
class Learning:
    """How ``plogic kb learn`` looks: the ``detector``, how many processes render, and the seed of the noise."""

    detector: str = "sift"
    jobs: int = 2
    seed: int = 0
    as_json: bool = False


@dataclass(frozen=True)
class Photo:
    """The files that ``plogic kb learn --photo`` reads.

    ``photo`` and ``points``; ``camera``: what was given for it; ``mesh`` and its ``units``, where the type is new.
    """

    photo: Path
    points: Path
    camera: GivenCamera = NOTHING_GIVEN
    mesh: Path | None = None
    units: str | None = None
