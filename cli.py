"""The command line: one function a command, which parses, calls and prints. Everything else is in the packages."""

import io
import os
import sys
import warnings
from errno import EDQUOT, EFBIG, EMFILE, ENFILE, ENOSPC, EROFS
from pathlib import Path
from typing import Any

import click

from plogic.base.errors import ReaderGoneError
from plogic.base.memory import EACH, LEAST, OF_ALL, VARIABLE, held, hold, limit
from plogic.face.authoring.kb_group import kb
from plogic.face.commands.bench import bench
from plogic.face.commands.clicked import batch, bop, doctor, measures, next_view, schema, settle, watch
from plogic.face.shown.options import (
    AS_JSON,
    BEST_BY,
    BOP,
    BOP_IMAGES,
    CAMERA,
    DEADLINE,
    DIGITS,
    DV_OVER,
    EVERY,
    FIRST_READING,
    GENERATOR,
    GIVEN,
    INTERPRETATION,
    KB,
    MARKS,
    PLACE,
    POSE_TABLE,
    READING,
    READINGS,
    RECONSIDER,
    ROBOT,
    RULES,
    SEED,
    SMOOTHING,
    SOURCE,
    TRUST,
    WITHHOLD,
    Asking,
    Number,
    Perceiving,
)
from plogic.face.shown.printed import emit, hand_over, let_go, open_streams, say, tell_unkept

NO_MEMORY = (
    "failed to map segment",
    "Cannot allocate memory",
    "Insufficient memory",
    "SystemError: error return without exception set",
    "returned NULL without setting an exception",
)
"""What libraries, and Python itself, say in whose errors memory ran out."""
NO_THREAD = "can't start new thread", "Resource temporarily unavailable"  # or processes
LIMITED = (
    f"A command and all processes that it starts take no more memory together than {LEAST >> 30} GiB and"
    f" {EACH >> 30} GiB for each processor, and at most {100 * OF_ALL:g} % of what there is; {VARIABLE}=MB sets another limit."
)
NO_ROOM = ENOSPC, EDQUOT, EFBIG, EROFS, EMFILE, ENFILE
"""Of a system's errors: nothing can be written, whatever we do."""


@click.group(context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 100}, epilog=LIMITED)
@click.version_option(package_name="plogic")
def cli() -> None:
    """Abductive visual perception with probabilistic logic: an image in, ranked possible worlds out."""


@cli.command()
@click.option(
    "-o",
    "--out",
    type=click.Path(path_type=Path),
    show_default="out/demo, out/look-again or out/paper",
    help="Folder to write.",
)
@click.option("--seed", type=SEED, default=0, show_default=True)
@click.option("--reading", type=READINGS, show_default="score, or posterior with --look-again")
@click.option(
    "--look-again", is_flag=True, help="Two worlds near even, and the second view that settles it (posterior reading)."
)
@click.option("--paper", is_flag=True, help="Table 1 and figure 5 of the paper, counted from a Γ and three poses.")
@DIGITS
@AS_JSON
def demo(out: Path | None, seed: int, reading: Any, look_again: bool, paper: bool, as_json: bool) -> None:
    """Show the two towers: from a simulated camera's pixels to ranked worlds, a picture and a page."""
    if paper:
        from plogic.face.commands.demo_paper import run_paper

        if look_again or seed or reading:
            raise click.UsageError("--paper: one Γ and three poses, in both modes: leave the other options out")
        emit(run_paper(out or Path("out/paper"), say=say, as_json=as_json))
    elif look_again:
        from plogic.face.commands.demo import run_look_again

        if reading == "score":
            raise click.UsageError("--look-again: is in the posterior reading; leave --reading out")
        emit(run_look_again(out or Path("out/look-again"), seed, say=say, as_json=as_json))
    else:
        from plogic.face.commands.demo import run_demo

        emit(run_demo(out or Path("out/demo"), seed, reading or "score", say=say, as_json=as_json))


@cli.command()
@click.argument("inputs", metavar="INPUT...", nargs=-1, required=True, type=PLACE)
@KB
@CAMERA
@click.option(
    "--poses",
    type=PLACE,
    help="Where the camera stood for each of several INPUTs: `poses/1` or a TUM trajectory.",
)
@click.option("--stereo", type=PLACE, help="Calibration of a pair, `stereo/1`: two INPUTs, left and right image or Γ.")
@FIRST_READING
@RECONSIDER
@DV_OVER
@SMOOTHING
@GENERATOR
@BEST_BY
@EVERY
@click.option("-o", "--out", default="", help="File to write; `-` is stdout (default, on a terminal its worlds alone).")
@click.option("--report", type=click.Path(path_type=Path), help="Also write the page.")
@click.option(
    "--picture", type=click.Path(path_type=Path), help="Also write the picture with the hypotheses over it (PNG)."
)
@MARKS
@click.option("--timings", type=click.Path(path_type=Path), help="Write the seconds of each stage as JSON.")
def perceive(inputs: tuple[str, ...], kb_folder: str, **options: Any) -> None:
    """Interpret INPUT, an image or a Γ file (`-` is a Γ on stdin), with a knowledge base.

    Several, from a camera whose places are known (--poses, or T_world_camera in its camera), are views of one world:
    they give a panorama. So do the frames of a video, clip_000000 and so on, 1,000 at most; each by itself: `batch`.
    """
    from plogic.face.commands.perceive import perceive_command

    sys.exit(perceive_command(inputs, Perceiving(kb_folder, **options), say=say, write=emit))


@cli.command()
@SOURCE
@click.option("-n", "number", type=click.IntRange(1), default=10, show_default=True)
@GIVEN
@RULES
@WITHHOLD
@READING
@DEADLINE
@TRUST
@POSE_TABLE
@DIGITS
@AS_JSON
def worlds(source: str, number: int, given: tuple[str, ...], as_json: bool, **options: Any) -> None:
    """List the possible worlds, most probable first, with the mass that is not listed."""
    from plogic.face.commands.asking import worlds_command

    text, status = worlds_command(source, number, given, Asking(**options), as_json=as_json)
    emit(text)
    sys.exit(status)


@cli.command()
@SOURCE
@click.argument("goals", metavar="[GOAL]...", nargs=-1)
@GIVEN
@RULES
@WITHHOLD
@READING
@DEADLINE
@TRUST
@DIGITS
@AS_JSON
def query(source: str, goals: tuple[str, ...], given: tuple[str, ...], as_json: bool, **options: Any) -> None:
    """Give P(goal) with every answer substitution, most probable first; of several in order; of none, the program's."""
    from plogic.face.commands.asking import query_command

    text, status = query_command(source, goals, given, Asking(**options), as_json=as_json)
    emit(text)
    sys.exit(status)


@cli.command()
@SOURCE
@click.argument("goal", required=False)
@GIVEN
@click.option(
    "--missing",
    metavar="TYPE",
    help="Instead of a GOAL: how far a type came that was not found, and why (--json: by visual word).",
)
@click.option("--kb", "kb_folder", type=PLACE, help="With --missing: the knowledge base, for the cause.")
@click.option(
    "-n",
    "number",
    type=click.IntRange(1),
    help="Explanations of each kind, whole (default: a screen of 5; of present(h), a summary).",
)
@RULES
@WITHHOLD
@READING
@TRUST
@DIGITS
@AS_JSON
def explain(
    source: str,
    goal: str | None,
    given: tuple[str, ...],
    missing: str | None,
    kb_folder: str | None,
    number: int | None,
    as_json: bool,
    **options: Any,
) -> None:
    """Say why, and why not: ranked explanations of the GOAL as trees down to the data; or why a TYPE is missing."""
    if (goal is None) == (missing is None):
        raise click.UsageError("give either a GOAL or --missing TYPE")
    if missing is not None:
        from plogic.face.commands.missing import missing_command

        if given or number is not None or any(options.values()):
            raise click.UsageError("--missing takes --kb, --digits and --json alone")
        emit(missing_command(source, missing, kb_folder, as_json=as_json))
        return
    if kb_folder is not None:
        raise click.UsageError("--kb: only with --missing")
    from plogic.face.commands.asking import explain_command

    emit(explain_command(source, goal or "", given, number, Asking(**options), as_json=as_json))


@cli.command()
@SOURCE
@RULES
@READING
@TRUST
@DIGITS
def shell(source: str, **options: Any) -> None:
    """Ask, observe, predict, rank worlds and ask why, at a prompt or from lines on stdin."""
    from plogic.face.commands.asking import shell_command

    sys.exit(shell_command(source, Asking(**options), write=emit, say=say))


@cli.command()
@click.argument("interpretation", metavar="[INTERPRETATION]", required=False, type=PLACE)
@click.option("--kb", "kb_folder", type=PLACE, help="Folder of a knowledge base, or a shipped one: print Σ alone.")
@RULES
@WITHHOLD
@READING
@AS_JSON
def program(interpretation: str | None, kb_folder: str | None, **options: Any) -> None:
    """Print the ProbLog program of an interpretation or a KB: it runs unchanged in a stock `problog`."""
    from plogic.face.commands.program import program_command

    write = emit if options["as_json"] else hand_over
    write(program_command(interpretation, kb_folder, **options))


@cli.command()
@INTERPRETATION
@click.option("-o", "--out", required=True, help="The page to write; `-` is stdout.")
def report(interpretation: str, out: str) -> None:
    """Write one self-contained HTML page that works offline."""
    from plogic.face.commands.program import report_command

    report_command(interpretation, out, say=say, write=hand_over)


@cli.command()
@KB
@click.option(
    "--objects",
    "number",
    type=click.IntRange(0, 50),
    help="How many stand there, where there is room.  [default: 2, or as many as are named]",
)
@click.option("--type", "names", multiple=True, help="A type that may stand there, again for more; else all of a size.")
@click.option(
    "--decoys", type=click.IntRange(0, 50), default=0, show_default=True, help="Untyped boxes and wedges beside them."
)
@click.option("--distance", type=Number(0.0, min_open=True), help="Metres from the camera to the middle of the scene.")
@click.option("--size-px", type=click.IntRange(1, 2000), help="Instead: how long the largest thing is in the picture.")
@click.option("--hiding", is_flag=True, help="One of the first two hides a part of the other.")
@click.option("--gamma", is_flag=True, help="Write gamma.json, typed appearances by the KB's rates, and no picture.")
@click.option("--seed", type=SEED, default=0, show_default=True)
@click.option(
    "-o", "--out", type=click.Path(path_type=Path), required=True, help="New folder for image, camera and ground truth."
)
@BOP
@BOP_IMAGES
@ROBOT
def simulate(kb_folder: str, seed: int, out: Path, **options: Any) -> None:
    """Simulate a physically settled scene, as large as its objects, with its ground truth."""
    from plogic.face.commands.simulate import Wanted, simulate_command, tell_without_physics

    if options["distance"] is not None and options["size_px"] is not None:
        raise click.UsageError("--distance and --size-px: each says how far the camera is: leave one out")
    if options["gamma"] and options["bop"] is not None:
        raise click.UsageError("--gamma: makes no picture, and --bop is of pictures: leave one out")
    if not options["gamma"]:
        tell_without_physics(say)
    scene = "number", "decoys", "names", "distance", "size_px", "gamma", "hiding"
    wanted = Wanted(**{key: options.pop(key) for key in scene})
    simulate_command(kb_folder, wanted, seed, out, say=say, **options)
    say(f"wrote {out}")


@cli.command()
@click.argument("name", metavar="bash|zsh|fish", type=click.Choice(["bash", "zsh", "fish"]))
def completion(name: str) -> None:
    """Print what makes a shell complete commands and options; its comment says where to put it."""
    from plogic.face.commands.shells import completion_text

    emit(completion_text(name))


@cli.command()
def man() -> None:
    """Print the manual of all commands as a man page: `plogic man | man -l -`."""
    from importlib.metadata import version

    from plogic.face.commands.shells import man_text

    emit(man_text(cli, version("plogic")))


cli.add_command(kb)
cli.add_command(bop)
cli.add_command(doctor)
cli.add_command(bench)
cli.add_command(batch)
cli.add_command(watch)
cli.add_command(next_view)
cli.add_command(measures)
cli.add_command(schema)
cli.add_command(settle)


def main() -> None:
    """Run a command; only here does an error turn into an exit code, and none shows a traceback."""
    os.environ.setdefault(
        "OPENBLAS_NUM_THREADS", "1"
    )  # our products of matrices are many and small: more threads take longer
    if os.environ.get("PATH") == "":  # as good as none, but problog joins it to a list
        del os.environ["PATH"]
    if not sys.warnoptions:  # what libraries warn programmers of; what a user should know, commands say themselves
        warnings.simplefilter("ignore")
        os.environ.setdefault("PYTHONWARNINGS", "ignore")  # so in the processes that are started
    open_streams()
    try:
        hold(limit(os.environ))
        sys.exit(cli.main(prog_name="plogic", standalone_mode=False))
    except ReaderGoneError:
        sys.exit(0)
    except click.ClickException as error:
        error.show(usage := io.StringIO())
        say(usage.getvalue())
        sys.exit(error.exit_code)
    except click.Abort:
        say("Aborted!")
        sys.exit(1)
    except Exception as error:
        if os.environ.get("PLOGIC_TRACEBACK"):
            raise
        error.__traceback__ = None  # with all that its frames hold: there may be no memory left to tell it
        say("\n".join(f"plogic: {line}" for line in _told(error)))
        sys.exit(1)
    finally:
        tell_unkept()
        let_go()


def _told(error: Exception) -> list[str]:
    """What a user is told: the mistakes, a line each; of a mistake of ours, where to get its traceback."""
    from geometry.errors import PlogicError
    from geometry.printable import on_one_line

    if isinstance(error, PlogicError):
        return on_one_line(str(error), sys.argv).splitlines()
    what = " ".join(f"{type(error).__name__}: {error}".split())
    if isinstance(error, MemoryError) or any(sign in what for sign in NO_MEMORY):
        than = f"the {held() >> 20} MB that a command may ({VARIABLE}, ulimit)" if held() else "there is"
        return [f"out of memory: the input, or the knowledge base, takes more than {than}"]
    if any(sign in what for sign in NO_THREAD):
        return ["no more threads or processes can be started: their number, or memory, is at its limit (ulimit -u, -v)"]
    if isinstance(error, OSError) and error.errno in NO_ROOM:
        return [f"{error.filename or 'a scratch file'}: cannot be written: {error.strerror}"]
    return [f"internal error: {what} (please report it with the traceback that PLOGIC_TRACEBACK=1 shows)"]


if __name__ == "__main__":
    main()
