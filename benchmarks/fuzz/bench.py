"""``make fuzz``: hostile inputs of every kind through their readers, in processes with limits; what came of them.

Run: ``python -m benchmarks.fuzz.bench --count 20000 [--kinds image-png,gamma] [--seconds 600] [--seed 0]``. Every input
that did what it must not is kept below ``out/fuzz``, and it is a row of the table; those that were mended lie in
``benchmarks/fuzz/corpus``, which the tests read.
"""

from __future__ import annotations

import hashlib
import os
import sys
import tempfile
from dataclasses import dataclass, field, replace
from multiprocessing import Pipe, RawValue
from multiprocessing.connection import wait
from pathlib import Path
from time import monotonic
from typing import TYPE_CHECKING, Any

import click
import cv2

from benchmarks.fuzz.kinds import Kind, kinds
from benchmarks.fuzz.worker import MEMORY, SLOW, Fault, Lot, inputs, outcome, place_for, work
from benchmarks.shared.claims import Claim, report
from plogic.base.children import Copy, ending_well

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

LOT = 500
"""Inputs of one process."""
POOL = 300
"""Inputs of interest that are kept beside the good ones, the newest."""
CORPUS = Path(__file__).with_name("corpus")
REACHED = "pool"
"""The folder of the inputs that reached new code (``benchmarks.fuzz.guided``), below that of the faults."""
WAITED = 120.0
"""Seconds by the wall clock that one input may take, as others are at work on the machine too."""
LOOK = 0.2
"""Seconds between two looks at how much processor time an input has taken."""
CAPTION = f"""inputs through the readers in process; `accepted`: by the reader; `faults`: exceptions that are no mistake of the input,
deaths, and hangs, inputs of more than {SLOW:g} processor seconds; `slowest`: processor seconds of one input; `memory`: MB at worst of a
process of {LOT} inputs, which may take {MEMORY >> 20} beside the program itself."""


@dataclass
class Tally:
    """What came of all lots of a kind, ``most`` inputs."""

    kind: Kind
    pool: list[bytes]
    out: Path
    say: Callable[[str], None]
    most: int
    lot: int = 0
    tried: int = 0
    accepted: int = 0
    seconds: float = 0.0
    slowest: float = 0.0
    memory: int = 0
    faults: dict[tuple[str, str, str], Fault] = field(default_factory=dict)
    doubtful: tuple[int, int] | None = None

    def add(self, lot: Lot) -> None:
        """Take in what one process did."""
        self.tried, self.accepted, self.seconds = (
            self.tried + lot.tried,
            self.accepted + lot.accepted,
            self.seconds + lot.seconds,
        )
        self.slowest, self.memory = max(self.slowest, lot.slowest), max(self.memory, lot.memory)
        for fault in lot.faults:
            self.fault(fault)
        good = len(self.kind.seeds())
        self.pool[good:] = [*self.pool[good:], *lot.found][-POOL:]

    def fault(self, fault: Fault) -> None:
        """Take in what must not happen, once."""
        sign = fault.sign if fault.where else (*fault.sign[:2], hashlib.sha256(fault.data).hexdigest()[:8])
        if sign not in self.faults:
            self.faults[sign] = fault
            self.say(keep_fault(fault, self.out))

    def row(self) -> dict[str, Any]:
        """Its row of the table."""
        return {
            "kind": self.kind.name, "inputs": self.tried, "accepted": self.accepted, "faults": len(self.faults),
            "seconds": round(self.seconds, 1), "slowest": round(self.slowest, 2), "memory": self.memory >> 20,
        }  # fmt: skip


class _Running:
    """A lot that is being read."""

    def __init__(self, tally: Tally, seed: int, count: int, folder: Path, first: int = 0) -> None:
        self.tally, self.lot, self.folder, self.first = tally, (seed, tally.lot, count, first), folder, first
        self.pool = tuple(tally.pool)
        self.end, theirs = Pipe(duplex=False)
        self.at = RawValue("q", -1)
        self._copy = Copy(work, tally.kind, self.lot, self.pool, folder, self.at, theirs)
        theirs.close()
        self.told = 0
        self._seen, self._before, self._since = -2, 0.0, 0.0

    def hangs(self) -> bool:
        """Whether the input that is read has taken too long, or waits for what never comes; not while one is made."""
        if self.at.value != self._seen:
            self._seen, self._before, self._since = self.at.value, processor_of(self._copy.pid), monotonic()
        long = processor_of(self._copy.pid) - self._before > SLOW + 1.0 or monotonic() - self._since > WAITED
        return long and self.at.value % 2 == 0

    def stop(self) -> int:
        """End it; the number of the input that was read last."""
        self._copy.end()
        self.end.close()
        return max(self.at.value // 2, self.first)

    def data(self, at: int) -> bytes:
        """That input."""
        seed, number, count, _ = self.lot
        return next(data for i, data in enumerate(inputs(self.tally.kind, seed, number, self.pool, count)) if i == at)


def processor_of(pid: int) -> float:
    """Processor seconds of a process and its children that have ended; 0 where it has ended itself."""
    try:
        words = Path(f"/proc/{pid}/stat").read_text(encoding="ascii").rpartition(")")[2].split()
    except OSError:
        return 0.0
    return sum(map(int, words[11:15])) / os.sysconf("SC_CLK_TCK")


@dataclass(frozen=True)
class Plan:
    """How many inputs of each kind, for how long at most, by how many processes, and where faults are kept."""

    count: int
    seconds: float
    seed: int
    jobs: int
    out: Path


def attack(chosen: Sequence[Kind], plan: Plan, say: Callable[[str], None]) -> list[Tally]:
    """So many inputs of each kind, or as many as the time is enough for, each kind in turn."""
    tallies = [
        Tally(
            kind,
            [*kind.seeds(), *kept(kind.name), *kept(kind.name, plan.out / REACHED)],
            plan.out,
            say,
            max(1, plan.count // kind.rare),
        )
        for kind in chosen
    ]
    seed, jobs = plan.seed, plan.jobs
    until = monotonic() + plan.seconds
    waiting, running, shown = list(tallies), dict[str, _Running](), 0
    with tempfile.TemporaryDirectory(prefix="plogic-fuzz-") as folder:
        while (waiting and monotonic() < until) or running:
            while waiting and len(running) < jobs and monotonic() < until:
                tally = waiting.pop(0)
                running[tally.kind.name] = _Running(
                    tally, seed, min(LOT, tally.most - tally.tried), Path(folder) / tally.kind.name
                )
            for name, one in list(running.items()):
                rest = _after(one, bool(wait([one.end], LOOK / len(running))))
                if rest is None:
                    continue
                del running[name]
                shown = _progress(tallies, shown, say)
                if rest < one.lot[2]:
                    running[name] = _Running(one.tally, seed, one.lot[2], one.folder, rest)
                elif one.tally.tried < one.tally.most:
                    waiting.append(one.tally)
    return tallies


def warm(chosen: Sequence[Kind]) -> None:
    """Read what is good of each kind here: copies of this process then have what is imported, and compiled."""
    with tempfile.TemporaryDirectory(prefix="plogic-fuzz-") as folder:
        for kind in chosen:
            path = place_for(kind, Path(folder) / kind.name)
            for data in kind.seeds():
                path.write_bytes(data)
                outcome(replace(kind, every=1), path, data)


def _progress(tallies: Sequence[Tally], shown: int, say: Callable[[str], None]) -> int:
    """Say how far it is, at each percent; the percent that was said last."""
    tried, most = (sum(numbers) for numbers in zip(*((tally.tried, tally.most) for tally in tallies), strict=True))
    now = 100 * tried // most
    if now > shown:
        say(f"{now} %: {tried} of {most} inputs, {sum(len(tally.faults) for tally in tallies)} faults")
    return now


def _after(one: _Running, said: bool) -> int | None:  # noqa: FBT001 - what was seen
    """None while it goes on, else the number of the input to go on from: how many there are, once it is done."""
    if said:
        try:
            part = one.end.recv()
        except EOFError:
            return _broken(one, "the process died")
        one.tally.add(part)
        one.told += part.tried
        if part.last:
            one.stop()
            one.tally.lot += 1
            return one.lot[2]
        return None
    return _broken(one, f"more than {SLOW:g} processor seconds", sure=False) if one.hangs() else None


def _broken(one: _Running, what: str, *, sure: bool = True) -> int:
    """End it, and tell of the input that was read; where that may be the machine's doing, of one that is so twice."""
    at = one.stop()
    if not sure and one.tally.doubtful != (one.tally.lot, at):
        one.tally.doubtful = one.tally.lot, at
        one.tally.tried += at - one.first - one.told
        return at
    one.tally.fault(Fault(one.tally.kind.name, what, one.data(at)))
    one.tally.tried += at + 1 - one.first - one.told
    one.tally.lot += at + 1 == one.lot[2]
    return at + 1


def kept(name: str, folder: Path = CORPUS) -> list[bytes]:
    """What was found before, and mended; of another folder, what lies there of the kind."""
    return [path.read_bytes() for path in sorted((folder / name).glob("*"))]


def keep_fault(fault: Fault, folder: Path) -> str:
    """Write a fault's input, and tell it in a line."""
    place = folder / fault.kind / hashlib.sha256(fault.data).hexdigest()[:12]
    place.parent.mkdir(parents=True, exist_ok=True)
    place.write_bytes(fault.data)
    return f"{fault.kind}: {fault.what} ({fault.where}): {place}"


def claims(tallies: Sequence[Tally]) -> list[Claim]:
    """None of them did what it must not."""
    tried, faults = sum(tally.tried for tally in tallies), sum(len(tally.faults) for tally in tallies)
    worst = max(tally.slowest for tally in tallies)
    return [
        Claim(f"internal errors, deaths and hangs of {tried} inputs", "<=", 0, faults),
        Claim("processor seconds of one input at worst", "<=", SLOW, worst),
    ]


@click.command()
@click.option("--count", type=click.IntRange(1), default=20_000, show_default=True, help="Inputs of each kind.")
@click.option("--seconds", type=click.FloatRange(1.0), default=1e9, help="Stop after so long.")
@click.option("--kinds", "names", default="", help="Some kinds, with commas between; all others are left out.")
@click.option("--seed", default=0, show_default=True)
@click.option("--jobs", type=click.IntRange(1, 64), default=os.cpu_count() or 1, show_default=True)
@click.option("-o", "--out", type=click.Path(path_type=Path), default=Path("out/fuzz"), show_default=True)
@click.option("--json", "as_json", is_flag=True)
def main(count: int, seconds: float, names: str, seed: int, jobs: int, out: Path, *, as_json: bool) -> None:
    """Read hostile inputs of every kind, and say what came of it."""
    known = kinds()
    wanted = names.split(",") if names else list(known)
    if strange := [name for name in wanted if name not in known]:
        raise click.UsageError(f"--kinds: {', '.join(strange)}: known are {', '.join(known)}")
    cv2.setNumThreads(0)  # a copy of a process has none of its threads
    chosen = [known[name] for name in wanted]
    with ending_well():
        warm(chosen)
        plan = Plan(count, seconds, seed, jobs, out)
        tallies = attack(chosen, plan, lambda line: click.echo(line, err=True))
    text, met = report("fuzz", [tally.row() for tally in tallies], claims(tallies), as_json=as_json)
    click.echo(text if as_json else f"{text}\n{CAPTION}")
    sys.exit(0 if met else 1)


if __name__ == "__main__":
    main()
