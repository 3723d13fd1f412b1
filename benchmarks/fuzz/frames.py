"""A batch whose processes are killed: no frame is lost or doubled, and memory is flat.

Run: ``python -m benchmarks.fuzz.frames --frames 1000 [--every 50] [--kb first]``. The same frames three times: by two
workers that nobody kills, by two of which one is killed every so many frames, at a random moment, and by two whose
parent is ended by SIGINT, SIGTERM and SIGKILL and gone on with (``--resume``). Every run must write the same bytes.
"""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import tempfile
from collections import Counter
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from random import Random
from time import monotonic, sleep
from typing import TYPE_CHECKING, Any, Protocol

import click
import numpy as np

from benchmarks.shared.claims import Claim, report
from plogic.base.errors import InputError

if TYPE_CHECKING:
    from collections.abc import Callable, Collection, Sequence

ROOT = Path(__file__).resolve().parents[2]
LOOK = 0.05
"""Seconds between two looks at lines and memory."""
LEAVING = 10.0
"""Seconds that workers may outlive their parent."""
FLAT = 1.05
"""What the last frames may take of what those after the first took."""
SIGNALS = signal.SIGINT, signal.SIGTERM, signal.SIGKILL
CAPTION = """`left`: workers that outlive their parent; `lost`, `doubled`, `misplaced`: frames; `other`: lines that are not those of the
first run; memory: the largest resident memory of such a process within each tenth of the frames, MB."""


@dataclass(frozen=True)
class Look:
    """How many lines there were, and the resident bytes of the parent and of each worker."""

    lines: int
    parent: int
    workers: dict[int, int]


class Harm(Protocol):
    """What is done to a run while it goes on."""

    def __call__(self, parent: int, look: Look, /) -> None:
        """Look, and kill whom it is time to kill."""


@dataclass
class Run:
    """What became of one run over all frames, gone on with as often as it was ended."""

    name: str
    rows: list[bytes] = field(default_factory=list)
    looks: list[Look] = field(default_factory=list)
    kills: int = 0
    left: int = 0
    seconds: float = 0.0


# -- what is killed ----------------------------------------------------------------------------------------------------


def unharmed(_parent: int, _look: Look) -> None:
    """Kill nobody."""


class KillWorkers:
    """Kill a worker each time that ``every`` more lines are there, at a moment within the ``spread`` seconds after."""

    def __init__(self, every: int, rng: Random, spread: float = 0.5) -> None:
        self._every, self._rng, self._spread = every, rng, spread
        self._next, self._at = every, 0.0
        self.kills = 0

    def __call__(self, _parent: int, look: Look) -> None:
        """As of Harm."""
        if look.lines >= self._next:
            self._next += self._every
            self._at = monotonic() + self._rng.uniform(0.0, self._spread)
        if self._at and monotonic() >= self._at and look.workers:
            self._at = 0.0
            with suppress(ProcessLookupError):  # it has just ended by itself
                os.kill(self._rng.choice(sorted(look.workers)), signal.SIGKILL)
                self.kills += 1


@dataclass
class EndParent:
    """End the parent by a signal once so many lines are there."""

    number: int
    lines: int

    def __call__(self, parent: int, look: Look) -> None:
        """As of Harm."""
        if look.lines >= self.lines:
            os.kill(parent, self.number)
            self.lines = sys.maxsize


# -- a run -------------------------------------------------------------------------------------------------------------


def followed(arguments: Sequence[str], out: Path, run: Run, harm: Harm) -> None:
    """Run ``plogic batch`` with its lines in ``out``; looks are added to the run. Raises InputError where it fails."""
    begun, workers = monotonic(), set[int]()
    with tempfile.TemporaryFile() as said:
        command = [str(Path(sys.executable).with_name("plogic")), "batch", *arguments, "-o", str(out)]
        paths = os.pathsep.join([str(ROOT), *filter(None, [os.environ.get("PYTHONPATH")])])
        with subprocess.Popen(  # noqa: S603 - our own
            command,
            stdin=subprocess.DEVNULL,
            stderr=said,
            start_new_session=True,
            env=os.environ | {"PYTHONPATH": paths},
        ) as child:
            try:
                while child.poll() is None:
                    run.looks.append(look_at(child.pid, out))
                    workers |= run.looks[-1].workers.keys()
                    harm(child.pid, run.looks[-1])
                    sleep(LOOK)
            finally:
                child.kill()
        run.seconds += monotonic() - begun
        run.left += _living(workers)
        if child.returncode not in (0, 1, *(128 + n for n in SIGNALS), *(-n for n in SIGNALS)):
            said.seek(0)
            raise InputError(f"{run.name}: exit status {child.returncode}: {said.read().decode(errors='replace')}")


def look_at(parent: int, out: Path) -> Look:
    """Lines and memory now."""
    lines = out.read_bytes().count(b"\n") if out.exists() else 0
    with suppress(OSError):
        workers = Path(f"/proc/{parent}/task/{parent}/children").read_text(encoding="ascii").split()
        return Look(lines, resident(parent), {int(pid): resident(int(pid)) for pid in workers})
    return Look(lines, 0, {})


def resident(pid: int) -> int:
    """Bytes of memory of a process; 0 where it has ended."""
    with suppress(OSError):
        return int(Path(f"/proc/{pid}/statm").read_text(encoding="ascii").split()[1]) * os.sysconf("SC_PAGE_SIZE")
    return 0


def _living(workers: Collection[int]) -> int:
    """How many of them outlive their parent by more than they may."""
    end = monotonic() + LEAVING
    while any(resident(pid) for pid in workers) and monotonic() < end:
        sleep(LOOK)
    return sum(resident(pid) > 0 for pid in workers)


@dataclass(frozen=True)
class Frames:
    """The frames of all runs and the KB that they are perceived with; ``folder`` takes the outputs."""

    folder: Path
    kb: str
    names: Sequence[str]

    def run(self, run: Run, harms: Sequence[Harm]) -> Run:
        """All frames, begun anew for each harm."""
        out = self.folder / f"{run.name.replace(' ', '-')}.jsonl"
        for i, harm in enumerate(harms):
            resumed = ["--resume"] if i else []
            followed([str(self.folder / "frames"), "--kb", self.kb, "--jobs", "2", *resumed], out, run, harm)
        run.rows = out.read_bytes().splitlines(keepends=True)
        return run


def runs(frames: Frames, every: int, rng: Random, say: Callable[[str], None]) -> list[Run]:
    """The three of them, the one that nobody kills first."""
    total = len(frames.names)
    workers = KillWorkers(every, rng)
    ends = [EndParent(number, total * i // (len(SIGNALS) + 1)) for i, number in enumerate(SIGNALS, 1)]
    planned: list[tuple[str, list[Harm]]] = [
        ("unharmed", [unharmed]),
        ("workers killed", [workers]),
        ("parent ended", [*ends, unharmed]),
    ]
    found = []
    for name, harms in planned:
        found.append(frames.run(Run(name), harms))
        say(f"{name}: {len(found[-1].rows)} lines, {found[-1].seconds:.0f} s")
    found[1].kills, found[2].kills = workers.kills, sum(end.lines == sys.maxsize for end in ends)
    return found


# -- what came of it ---------------------------------------------------------------------------------------------------


def wrong_lines(names: Sequence[str], rows: Sequence[bytes], right: Sequence[bytes]) -> dict[str, int]:
    """How many frames are lost, doubled, bad, not in their place, or not as in the ``right`` rows."""
    told = [json.loads(row) for row in rows]
    there = Counter(row["input"] for row in told)
    return {
        "lost": sum(name not in there for name in names),
        "doubled": sum(count - 1 for count in there.values()),
        "bad": sum(row["status"] != "done" for row in told),
        "misplaced": sum(row["input"] != name for row, name in zip(told, names, strict=False)),
        "other": len(set(right) ^ set(rows)),
    }


def megabytes(looks: Sequence[Look], total: int, of: Callable[[Look], int]) -> list[float | None]:
    """The largest resident memory within each tenth of the frames; None where nobody looked."""
    found = dict[int, float]()
    for look in looks:
        tenth = min(look.lines * 10 // total, 9)
        found[tenth] = max(found.get(tenth, 0.0), round(of(look) / 1e6, 1))
    return [found.get(tenth) for tenth in range(10)]


PROCESSES: dict[str, Callable[[Look], int]] = {
    "parent": lambda look: look.parent,
    "worker": lambda look: max(look.workers.values(), default=0),
}


def table(found: Sequence[Run], names: Sequence[str]) -> list[dict[str, Any]]:
    """A row a run."""
    return [
        {
            "run": run.name, "lines": len(run.rows), "kills": run.kills, "left": run.left,
            **wrong_lines(names, run.rows, found[0].rows), "seconds": round(run.seconds, 1),
        }
        for run in found
    ]  # fmt: skip


def memory(found: Sequence[Run], total: int) -> list[dict[str, Any]]:
    """A row a run and kind of process."""
    return [
        {"run": run.name, "MB of": who, **{str(i): mb for i, mb in enumerate(megabytes(run.looks, total, of), 1)}}
        for run in found
        for who, of in PROCESSES.items()
    ]


def claims(rows: Sequence[dict[str, Any]], taken: Sequence[dict[str, Any]], total: int, every: int) -> list[Claim]:
    """Nothing lost, doubled or left, and memory flat where the parent stays."""
    faults = ("lost", "doubled", "bad", "misplaced", "other", "left")
    return [
        *(Claim(f"{what}, of {total} frames in each run", "<=", 0, sum(row[what] for row in rows)) for what in faults),
        Claim("workers killed", ">=", total // every - 1, rows[1]["kills"]),
        Claim("parents ended", ">=", len(SIGNALS), rows[2]["kills"]),
        *(
            Claim(
                f"{row['run']}: {row['MB of']}, memory of the last tenth to that of the second", "<=", FLAT, grown(row)
            )
            for row in taken
            if row["run"] != rows[2]["run"]
        ),
    ]


def grown(row: dict[str, Any]) -> float | None:
    """The last tenth's memory, as a multiple of the second's."""
    return row["10"] / row["2"] if row["2"] and row["10"] else None


def write(kb: str, number: int, seed: int, folder: Path, say: Callable[[str], None]) -> Frames:
    """Γ of one object among clutter, each another; of the towers some are pictures."""
    from benchmarks.batch.frames import gamma, write_frames
    from plogic.run.batch.frames import frames_of
    from plogic.run.sources import kb_of
    from sensing.files.gamma_files import write_gamma

    place, known = folder / "frames", kb_of(kb)
    if kb == "towers":
        write_frames(known, number, seed, place, say)
    else:
        place.mkdir()
        for i in range(number):
            write_gamma(gamma(known, np.random.default_rng([seed, i])), place / f"{i:06d}.json")
    return Frames(folder, kb, [frame.input for frame in frames_of([str(place)], ())])


@click.command()
@click.option("--frames", "number", type=click.IntRange(20), default=1000, show_default=True)
@click.option("--every", type=click.IntRange(1), default=50, show_default=True, help="Frames between two kills.")
@click.option(
    "--kb", default="first", show_default=True, help="`first` or `towers`, where one frame of 25 is a picture."
)
@click.option("--seed", default=0, show_default=True)
@click.option("--json", "as_json", is_flag=True)
def main(number: int, every: int, kb: str, seed: int, *, as_json: bool) -> None:
    """Kill the processes of a batch, and say what came of it."""

    def say(line: str) -> None:
        click.echo(line, err=True)

    with tempfile.TemporaryDirectory(prefix="plogic-frames-") as folder:
        frames = write(kb, number, seed, Path(folder), say)
        found = runs(frames, every, Random(seed), say)  # noqa: S311 - no secret
    rows, taken = table(found, frames.names), memory(found, number)
    text, met = report("fuzz frames", rows, claims(rows, taken, number, every), as_json=as_json, more={"memory": taken})
    click.echo(text if as_json else f"{text}\n{CAPTION}")
    sys.exit(0 if met else 1)


if __name__ == "__main__":
    main()
