"""The commands ``batch``, ``bop``, ``doctor``, ``measures``, ``next-view``, ``schema``, ``settle`` and ``watch``.

One function of click's each, which parses, calls and prints.
"""

import math
import sys
from pathlib import Path
from typing import Any

import click

from plogic.face.shown.options import (
    AS_JSON,
    BEST_BY,
    CAMERA,
    DIGITS,
    EVERY,
    FIRST_READING,
    INTERPRETATION,
    KB,
    MARKS,
    PLACE,
    READING,
    RECONSIDER,
    SEED,
    SMOOTHING,
    Batching,
    Moves,
    Number,
    Scoring,
    Watching,
    camera_options,
)
from plogic.face.shown.printed import emit, hand_over, say

HELP = {"help_option_names": ["-h", "--help"]}
SETTINGS = "camera", "reading", "reconsider", "smoothing", "deadline", "worlds", "full"
"""The options of ``batch`` that decide a frame's line."""
FORMATS = (
    *("gamma", "camera", "poses", "moves", "stereo", "truth"),
    *("interpretation", "panorama", "answers", "frame", "doctor"),
)


@click.command(context_settings=HELP)
@click.argument("inputs", metavar="INPUTS...", nargs=-1, required=True, type=PLACE)
@KB
@click.option(
    "--jobs",
    type=click.IntRange(1, 256),
    help="Processes at work on this machine, one thread each (default: one a core).",
)
@click.option(
    "--dask",
    metavar="ADDRESS",
    help="Scheduler of a Dask cluster to work instead, as tcp://HOST:8786; needs plogic[dask].",
)
@click.option("-o", "--out", default="-", help="File to append lines to; `-` is stdout (default).")
@click.option(
    "--resume", is_flag=True, help="Go on with the lines that the file has: skip what is done, cut a torn last line."
)
@click.option(
    "--order",
    type=click.Choice(["input", "done"]),
    default="input",
    show_default=True,
    help="Lines in the order of the inputs, or as they are done.",
)
@click.option(
    "--full",
    is_flag=True,
    help="Whole interpretations, as `perceive` writes them, in place of objects, poses and worlds.",
)
@click.option(
    "-n", "worlds", type=click.IntRange(0, 100), default=10, show_default=True, help="Worlds that a line lists."
)
@click.option(
    "--timeout",
    type=Number(0.0, min_open=True),
    help="Seconds that a frame may take; what takes longer is a bad frame.",
)
@EVERY
@CAMERA
@FIRST_READING
@RECONSIDER
@SMOOTHING
@BEST_BY
def batch(inputs: tuple[str, ...], kb_folder: str, **options: Any) -> None:  # noqa: ANN401 - click's
    r"""Perceive many frames: one line of JSON each, the same whoever works.

    INPUTS are pictures, Γ files (.json), folders with such at any depth, videos that are named (not those in folders),
    patterns in quotes, and BOP datasets; `-` is a list of them on stdin, one a line. A picture's or video's camera is
    --camera, or camera.json beside it. A video's frames are clip_000000, clip_000001, ...: 200,000 of 64 million
    pixels at most; where it is damaged, those before are perceived.

    A line (frame/1) has input, frame, status (done, unfinished, error), the SHA-256 of what was read, the KB and the
    options; then the accepted hypotheses with poses and probabilities and the most probable worlds, or the error. A bad
    frame is such a line and no stop; the exit status is then 1, and else 3 where --deadline left one unfinished. After
    a kill or Ctrl-C, --resume goes on.
    """
    if options["jobs"] and options["dask"] is not None:
        raise click.UsageError("--jobs and --dask exclude each other")
    if options["dask"] == "":
        raise click.UsageError("--dask needs an address, as tcp://HOST:8786")
    if options["out"] == "-" and options["resume"]:
        raise click.UsageError("--resume needs a file: -o OUT")
    for option in ("timeout", "deadline"):
        if options[option] == math.inf:
            raise click.UsageError(f"--{option} must be finite: leave it out to wait without end")
    from plogic.face.commands.batch import batch_command
    from plogic.run.batch.frames import Settings

    chosen = {name: options.pop(name) for name in SETTINGS}
    sys.exit(batch_command(inputs, Settings(kb_folder, **chosen), Batching(**options), listed=sys.stdin))


@click.command(context_settings=HELP)
@click.argument("source", metavar="CAMERA|FILE|-", type=PLACE)
@KB
@camera_options("A stream tells none: one of these is needed.")
@click.option("--every", type=click.IntRange(1), default=1, show_default=True, help="Take each so many-th frame.")
@click.option("--limit", type=click.IntRange(1), metavar="FRAMES", help="Stop after so many.")
@click.option("--jobs", type=click.IntRange(1, 256), help="Frames that are interpreted at once (default: one a core).")
@click.option("--newest", is_flag=True, help="Of a stream too, skip to the newest frame when frames come too fast.")
@click.option("--short", is_flag=True, help="Short lines, as `batch` writes them, in place of whole interpretations.")
@click.option("--picture", type=click.Path(path_type=Path), help="Write the newest frame's picture there (PNG).")
@click.option(
    "--pictures", type=click.Path(path_type=Path, file_okay=False), help="Write each frame's picture into this folder."
)
@MARKS
@FIRST_READING
@RECONSIDER
@SMOOTHING
@BEST_BY
def watch(source: str, kb_folder: str, **options: Any) -> None:  # noqa: ANN401 - click's
    """Interpret frames as they come: one line of JSON each, until they end, or Ctrl-C.

    A camera is a number, as of /dev/video0: its newest frame is taken, and what was skipped meanwhile is told. FILE is
    a video, or pictures in a row, as `-` is on stdin (JPEG, PNG, PNM). Of these no frame is skipped without --newest,
    and the same input gives the same bytes.

    Anything else goes through a pipe: `ffmpeg -i INPUT -r 2 -f image2pipe -c:v ppm - | plogic watch - ...`.

    A line is an interpretation, as `perceive` writes it, with the key `moment`: the frame's number in the stream, its
    time in seconds (null for pictures on stdin), and how many were skipped just before it. A bad frame is a frame/1
    with its error and no stop; the exit status is then 1, as after Ctrl-C, and else 3 where --deadline left one
    unfinished. Limits are a frame's, not the stream's: 64 million pixels of a video, 200 of a picture.
    """
    if options["newest"] and source != "-":
        raise click.UsageError("--newest: is of a stream on stdin; a camera's newest frame is taken anyway")
    if options["deadline"] == math.inf:
        raise click.UsageError("--deadline must be finite: leave it out to wait without end")
    from plogic.face.commands.watch import watch_command
    from plogic.run.batch.frames import Settings

    chosen = {name: options.pop(name) for name in ("camera", "reading", "reconsider", "smoothing", "deadline")}
    full = not options["short"]
    sys.exit(watch_command(source, Settings(kb_folder, **chosen, full=full), Watching(**options)))


@click.command(context_settings=HELP)
@click.argument("dataset", metavar="DATASET", type=PLACE)
@KB
@click.option(
    "-o", "--out", required=True, help="Results file (CSV) to write; `-` is stdout, and scores then go to stderr."
)
@click.option(
    "--ids",
    type=PLACE,
    help='BOP numbers of the types as JSON, {"003_cracker_box": 2}; obj_000002, the dataset\'s own names and its ids.json need none.',
)
@click.option(
    "--times",
    "timed",
    is_flag=True,
    help="Write each image's seconds; else -1, so that the same input gives the same bytes.",
)
@AS_JSON
def bop(dataset: str, kb_folder: str, out: str, ids: str | None, timed: bool, as_json: bool) -> None:  # noqa: FBT001 - click's flags
    """Perceive every image of a BOP dataset, write the challenge's results file, and score it against ground truth.

    DATASET is a dataset's folder, one of its splits, or one scene. A name by the challenge's convention is
    METHOD_DATASET-SPLIT.csv.
    """
    from plogic.face.commands.bop import bop_command

    text = bop_command(dataset, kb_folder, out, Scoring(ids, timed, as_json), say=say, write=hand_over)
    if text:
        emit(text)


@click.command(name="next-view", context_settings=HELP)
@INTERPRETATION
@click.option(
    "--about",
    metavar="GOAL",
    help="What should become certain, as `plogic query` takes it (default: which world it is).",
)
@click.option(
    "--ring",
    type=Number(0.0, min_open=True),
    metavar="METRES",
    help="Radius of the ring around the scene (default: the present one).",
)
@click.option("--moves", type=click.Path(path_type=Path), help="Candidates of your own: a moves/1 or poses/1 file.")
@click.option(
    "--within",
    type=Number(0.0, min_open=True),
    metavar="METRES",
    help="All of a grid within this distance, turned to the scene.",
)
@click.option(
    "-n", "number", type=click.IntRange(1), default=5, show_default=True, help="Candidates to list, the best first."
)
@READING
@click.option("--seed", type=SEED, default=0, show_default=True)
@AS_JSON
def next_view(interpretation: str, number: int, seed: int, *, as_json: bool, **options: Any) -> None:  # noqa: ANN401 - click's
    """Say where to look next: the camera moves that would tell most, with their expected gains in bits, and why.

    INTERPRETATION is that of one image, or a sequence's panorama/1: what all its views leave open, from where the last
    one stood.

    Without --ring, --moves or --within the candidates are a ring of eleven places around the scene at the present
    height and distance.
    """
    if sum(options[name] is not None for name in ("ring", "moves", "within")) > 1:
        raise click.UsageError("--ring, --moves and --within exclude one another")
    from plogic.face.commands.next_view import next_view_command

    emit(next_view_command(interpretation, number, seed, Moves(**options), as_json=as_json))


@click.command(context_settings=HELP)
@INTERPRETATION
@DIGITS
@AS_JSON
def measures(interpretation: str, *, as_json: bool) -> None:
    """Compare the measures of each hypothesis.

    They are ev alone and in each mode beside Δi, Shanahan's value, the posterior, dv and rank.

    Distinctiveness is told over the types of the knowledge base, and over the instances in Δi; visual words are summed
    up, and --json lists them.
    """
    from plogic.face.commands.program import measures_command

    emit(measures_command(interpretation, as_json=as_json))


@click.command(context_settings=HELP)
@INTERPRETATION
@click.option("--worlds", type=click.IntRange(1), default=1, show_default=True, help="How many, the best first.")
@click.option("--drop", is_flag=True, help="Let go, too, what is free: held in its world by nothing that is known.")
@click.option(
    "--picture",
    type=click.Path(path_type=Path),
    help="Also write the best world's outlines before (dashed) and after (PNG).",
)
@DIGITS
@AS_JSON
def settle(interpretation: str, worlds: int, picture: Path | None, *, drop: bool, as_json: bool) -> None:
    """Let the objects of the best worlds go, by physics: who stands, falls, tips, slides or is pushed out of another.

    They are first put on what the world says they stand on, and moved out of each other and out of the floor, then left
    to gravity for two seconds. The floor is the support plane of the interpretation, or the ground that its camera's
    place tells, or what its objects stand on. Needs pybullet.
    """
    from plogic.face.commands.settle import settle_command

    emit(settle_command(interpretation, worlds, picture, drop=drop, as_json=as_json))


@click.command(context_settings=HELP)
@click.argument("name", type=click.Choice(FORMATS))
def schema(name: str) -> None:
    """Print the JSON Schema (draft 2020-12) of a format; docs/formats.md has an example of each.

    The formats of a knowledge base: `plogic kb schema`.
    """
    from plogic.face.commands.formats import schema_command

    emit(schema_command(name))


@click.command(context_settings=HELP)
@click.option(
    "--kb", "knowledge_bases", multiple=True, metavar="KB", help="Look at a knowledge base, too; may be repeated."
)
@click.option("--fix", is_flag=True, help="Remove what is damaged, and what killed processes left; say what was done.")
@AS_JSON
def doctor(knowledge_bases: tuple[str, ...], *, fix: bool, as_json: bool) -> None:
    """Say what is wrong with the installation, its caches, and knowledge bases, and what to do.

    Versions against those that are admitted, tools that may be there or not, what is kept from run to run and what was
    left behind, limits in force, the console's encoding. The exit status is 1 where something is wrong.
    """
    from plogic.face.commands.doctor import doctor_command

    text, status = doctor_command(knowledge_bases, fix=fix, as_json=as_json)
    emit(text)
    sys.exit(status)
