"""Hostile input through the commands themselves: each runs in a process of its own, as from a console.

``python -m benchmarks.fuzz.console --count 10000``. An input must end in an exit status of 0 to 3, without a traceback
or an internal error, in few lines, none of them with a character that a terminal would obey, and within the limits of
``benchmarks.fuzz.worker``. The command is a copy of this process, which has imported what a first run of each
needed, with good input, so that it starts at once; one in ``FRESH`` is the console script itself.
"""

from __future__ import annotations

import json
import os
import re
import resource
import shutil
import signal
import sys
import tempfile
import warnings
from contextlib import suppress
from dataclasses import dataclass
from functools import partial
from importlib import import_module
from itertools import cycle, islice
from pathlib import Path
from random import Random
from time import monotonic
from typing import TYPE_CHECKING, Any

import click
import cv2

from benchmarks.fuzz import seeds
from benchmarks.fuzz.bench import keep_fault
from benchmarks.fuzz.kinds import ASKED, Kind, kinds
from benchmarks.fuzz.worker import MEMORY, SLOW, Fault, inputs
from benchmarks.shared.claims import Claim, report

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Sequence

FRESH = 50
"""Of so many runs one is of the console script."""
WAITED = 90
"""Seconds by the clock."""
MOST_LINES = 120
"""Lines on standard error: a hundred mistakes, and what was left out."""
LONGEST_LINE = 1100
"""Characters of a line on standard error."""
BAD = "Traceback", "internal error", "Warning: "
"""What no line on standard error may hold."""
NEEDED = ".modules"
"""File of the modules that a run has imported."""
_OBEYED = re.compile("[\x00-\x08\x0b-\x1f\x7f-\x9f\u061c\u200e\u200f\u2028\u2029\u202a-\u202e\u2066-\u2069]")
"""Characters that a terminal obeys; it may print tabs, and ends of lines."""


@dataclass(frozen=True)
class Command:
    """``words`` of a command that reads a ``kind`` of input, ``{}``; ``beside`` makes what else it needs."""

    kind: str
    words: tuple[str, ...]
    beside: Callable[[Path], None]


def _documents(folder: Path) -> None:
    """What commands need beside what is hostile: a picture, a Γ, a camera, an interpretation, a KB, a mesh."""
    for name in ("gamma", "camera", "interpretation", "poses", "moves", "stereo", "truth", "panorama"):
        (folder / f"{name}.json").write_bytes(seeds.example(f"{name}.json")[0])
    (folder / "box.obj").write_bytes(seeds.meshes("obj")[0])
    (folder / "x.png").write_bytes(seeds.picture_of_the_camera())
    (folder / "shelf").mkdir(exist_ok=True)
    (folder / "shelf" / "7.json").write_bytes(seeds.example("gamma.json")[0])
    (folder / "ids.json").write_text('{"t1": 1, "t2": 2}', encoding="utf-8")
    for name, kept in (("first", "kb"), ("towers", "seen")):
        shutil.copytree(seeds.ROOT / "kb" / name, folder / kept, dirs_exist_ok=True)


CAMERAS = "json", "bop", "ros", "opencv", "xml", "colmap", "colmap-bin"


def commands() -> list[Command]:
    """Every command with every kind of input that it reads."""
    first, seen = ("--kb", "kb"), ("--kb", "seen")  # the types of the second are detected in pictures
    rows: list[tuple[str, tuple[str, ...]]] = [
        *((f"image-{name}", ("perceive", "{}", *seen, "--fov", "60")) for name in ("png", "jpg", "bmp", "gif", "tiff", "webp", "pnm")),
        ("gamma", ("perceive", "{}", *first)),
        ("gamma", ("batch", "{}", *first, "--jobs", "1")),
        ("stream", ("watch", "{}", *seen, "--fov", "60", "--limit", "3")),
        *((f"video-{name}", ("batch", "{}", *seen, "--fov", "60", "--jobs", "1")) for name in ("avi", "mp4", "mkv")),
        *((f"camera-{name}", ("perceive", "x.png", *seen, "--camera", "{}" if name != "colmap" else "{}#1")) for name in CAMERAS),
        *((f"mesh-{name}", ("kb", "add", "thing", "--mesh", "{}", "--units", "m", *first)) for name in ("obj", "ply", "stl", "off", "gltf", "glb")),
        ("kb.yaml", ("kb", "check", "{kb}")),
        ("object.yaml", ("kb", "show", "{kb}")),
        ("rules.pl", ("kb", "check", "{kb}")),
        *((file, ("perceive", "gamma.json", "--kb", "{kb}", "--deadline", "5")) for file in ("kb.yaml", "object.yaml", "rules.pl")),
        ("poses", ("perceive", "gamma.json", "gamma.json", *first, "--poses", "{}")),
        ("poses-tum", ("perceive", "gamma.json", "gamma.json", *first, "--poses", "{}")),
        ("stereo", ("perceive", "gamma.json", "gamma.json", *first, "--stereo", "{}")),
        ("moves", ("next-view", "interpretation.json", "--moves", "{}", "-n", "1")),
        ("truth", ("kb", "learn-rates", "{folder}", *first)),
        ("batch-log", ("batch", "shelf/7.json", *first, "--jobs", "1", "-o", "{}", "--resume")),
        ("program", ("query", "{}", "--deadline", "2")),
        ("program", ("explain", "{}", "calls(mary)")),
        ("goal", ("query", "interpretation.json", "{text}", "--deadline", "2")),
        ("evidence", ("worlds", "interpretation.json", "--given", "{text}", "--deadline", "2")),
        ("rules", ("query", "interpretation.json", "present(H)", "--rules", "{}", "--deadline", "2")),
        *((f"bop-{name}", ("bop", "dataset", *seen, "-o", "a.csv", "--ids", "ids.json")) for name in ("camera", "truth", "visibility", "targets")),
        ("bop-models", ("kb", "import", "{folder}", *first)),
        ("bop-ids", ("bop", "dataset", *seen, "-o", "a.csv", "--ids", "{}")),
        ("urdf", ("kb", "import", "{}", *first)),
        ("sdf", ("kb", "import", "{}", *first)),
        ("panorama", ("kb", "assimilate", "{}", "u1", *first, "--name", "thing")),
        ("panorama", ("next-view", "{}", "-n", "1")),
        ("interpretation-query", ("shell", "{}")),
    ]  # fmt: skip
    rows += [(f"interpretation-{name}", tuple(words)) for name, words in ASKED.items()]
    known = kinds()
    return [Command(kind, words, partial(_beside, known[kind], words)) for kind, words in rows]


def _beside(kind: Kind, words: Sequence[str], folder: Path) -> None:
    _documents(folder)
    kind.beside(folder)
    if "dataset" in words and not (folder / "dataset").exists():
        seeds.bop_dataset(folder)


def words_of(command: Command, path: Path, data: bytes) -> list[str]:
    """The command's words for one input."""
    above = next((p for p in path.parents if (p / "kb.yaml").exists()), path.parent)
    text = data.decode("utf-8", "replace").replace("\0", "")[:60_000]
    said = {"{}": str(path), "{}#1": f"{path}#1", "{kb}": str(above), "{folder}": str(path.parent), "{text}": text}
    return [said.get(word, word) for word in command.words]


# -- one run -----------------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class _Run:
    """A run that has started, in ``place``."""

    command: Command
    data: bytes
    place: Path


def _become(words: Sequence[str], folder: Path, how: str) -> None:
    """In the copy: be the command, and end."""
    code = 70
    try:
        os.setsid()
        signal.alarm(WAITED)
        if how != "first":  # which may compile
            resource.setrlimit(resource.RLIMIT_CPU, (int(SLOW) + 1, int(SLOW) + 1))
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
        os.chdir(folder)
        for i, name in enumerate(("in", "out", "err")):
            os.dup2(os.open(f".{name}", os.O_RDWR | os.O_CREAT | (os.O_TRUNC if i else 0), 0o600), i)
        if how == "script":
            os.execv(shutil.which("plogic") or "", ["plogic", *words])  # noqa: S606 - our own
        sys.argv = ["plogic", *words]
        warnings.resetwarnings()
        sys.stdin, sys.stdout, sys.stderr = (os.fdopen(i, mode, encoding="utf-8") for i, mode in enumerate("rww"))
        from plogic.face.commands.started import main

        main()
        code = 0
    except SystemExit as end:
        code = end.code if isinstance(end.code, int) else 0 if end.code is None else 1
    except BaseException:  # noqa: BLE001 - what a console would show
        import traceback

        traceback.print_exc()
    finally:
        Path(folder, NEEDED).write_text("\n".join(sys.modules), encoding="utf-8")
        for stream in (sys.stdout, sys.stderr):
            try:
                stream.flush()
            except (OSError, ValueError):
                code = 71
        os._exit(code)


def fault_of(status: int, seconds: float, memory: int, folder: Path) -> str | None:
    """What was wrong with a run, if anything."""
    said, printed = ((folder / name).read_text("utf-8", "replace") for name in (".err", ".out"))
    lines = said.splitlines() or [""]
    bad = [line for line in lines if any(sign in line for sign in BAD)]
    seen = _OBEYED.search(said + printed)
    faults = {
        f"ended with {status}: {said[-300:]}": status not in (0, 1, 2, 3),
        f"said {bad[0] if bad else ''}": bool(bad),
        f"took {seconds:.1f} processor seconds": seconds > SLOW,
        f"took {memory >> 20} MB": memory > MEMORY,
        f"printed {seen[0] if seen else ''!r}": seen is not None,
        f"wrote {len(lines)} lines to standard error": len(lines) > MOST_LINES,
        f"wrote a line of {max(map(len, lines))} characters to standard error": max(map(len, lines)) > LONGEST_LINE,
    }
    return next((what for what, wrong in faults.items() if wrong), None)


def runs(count: int, seed: int, folder: Path, jobs: int) -> Iterator[tuple[Command, bytes, str | None, float, int]]:
    """Each run as it ends: the command, the input, what was wrong, processor seconds and memory; ``jobs`` at once."""
    known, every = kinds(), commands()
    places, running = [folder / f"run-{n}" for n in range(jobs)], dict[int, _Run]()
    for command in every:
        first = _Run(command, known[command.kind].seeds()[0], places[0])
        running[_started(first, "first")] = first
        _ended(running)
        _import(places[0] / NEEDED)
    made = {}
    try:
        for i, command in enumerate(islice(cycle(every), count)):
            if command not in made:
                kind = known[command.kind]
                rng = Random(f"{command.kind} {command.words} {seed}").randrange(1 << 30)  # noqa: S311 - no secret
                made[command] = inputs(kind, rng, 1, kind.seeds(), count // len(every) + 2)
            one = _Run(command, next(made[command]), places.pop())
            running[_started(one, "copy" if i % FRESH else "script")] = one
            while running and (not places or i == count - 1):
                one, status, seconds, memory = _ended(running)
                places.append(one.place)
                yield one.command, one.data, fault_of(status, seconds, memory, one.place), seconds, memory
    finally:
        for number in running:
            os.kill(number, signal.SIGKILL)
            os.waitpid(number, 0)


def _started(run: _Run, how: str) -> int:
    """The process of a run in a new folder."""
    kind, place = kinds()[run.command.kind], run.place
    shutil.rmtree(place, ignore_errors=True)
    place.mkdir()
    run.command.beside(place)
    path = place / kind.file
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(run.data)
    (place / ".in").write_bytes(b"ask present(h1)\nworlds\nwhy present(h1)\n")
    words = words_of(run.command, path, run.data)
    number = os.fork()
    if number == 0:
        _become(words, place, how)
    return number


def _ended(running: dict[int, _Run]) -> tuple[_Run, int, float, int]:
    """The next run that ends: exit status (negative: a signal), processor seconds and bytes of memory at worst.

    Its children are counted.
    """
    number, status, used = os.wait4(-1, 0)
    seconds, memory = used.ru_utime + used.ru_stime, used.ru_maxrss * 1024
    return running.pop(number), os.waitstatus_to_exitcode(status), seconds, memory


def _import(needed: Path) -> None:
    """What a run has imported, so that copies need not."""
    for name in needed.read_text(encoding="utf-8").splitlines() if needed.exists() else ():
        if name not in sys.modules:
            with suppress(Exception):  # one that a library puts there by itself
                import_module(name)


@click.command()
@click.option("--count", type=click.IntRange(1), default=10_000, show_default=True, help="Runs of all commands.")
@click.option("--seconds", type=click.FloatRange(1.0), default=1e9, help="Stop after so long.")
@click.option("--seed", default=0, show_default=True)
@click.option("--jobs", type=click.IntRange(1, 64), default=os.cpu_count() or 1, show_default=True)
@click.option("-o", "--out", type=click.Path(path_type=Path), default=Path("out/fuzz"), show_default=True)
@click.option("--json", "as_json", is_flag=True)
def main(count: int, seconds: float, seed: int, jobs: int, out: Path, *, as_json: bool) -> None:
    """Run the commands on hostile input, and say what came of it."""
    cv2.setNumThreads(0)
    warnings.simplefilter("ignore")
    import cli  # noqa: F401 - once for all copies

    rows: dict[str, dict[str, Any]] = {}
    until, tried, shown = monotonic() + seconds, 0, 0
    with tempfile.TemporaryDirectory(prefix="plogic-console-") as folder:
        for command, data, what, took, memory in runs(count, seed, Path(folder), jobs):
            name = " ".join(command.words[:2] if command.words[0] == "kb" else command.words[:1]) + f" {command.kind}"
            row = rows.setdefault(name, {"command": name, "runs": 0, "faults": 0, "slowest": 0.0, "memory": 0})
            row["runs"] += 1
            row["faults"] += what is not None
            row["slowest"], row["memory"] = max(row["slowest"], round(took, 2)), max(row["memory"], memory >> 20)
            if what is not None:
                click.echo(keep_fault(Fault(command.kind, what, data, json.dumps(command.words)[:200]), out), err=True)
            tried += 1
            if 100 * tried // count > shown:
                shown = 100 * tried // count
                click.echo(f"{shown} %: {tried} of {count} runs", err=True)
            if monotonic() > until:
                break
    faults = sum(row["faults"] for row in rows.values())
    text, met = report(
        "fuzz console", list(rows.values()), [Claim(f"faults of {tried} runs", "<=", 0, faults)], as_json=as_json
    )
    click.echo(text)
    sys.exit(0 if met else 1)


if __name__ == "__main__":
    main()
