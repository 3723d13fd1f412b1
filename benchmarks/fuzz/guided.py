"""Hostile inputs that are led by the code that they reach: libFuzzer, through atheris, changes what got further.

Run: ``python -m benchmarks.fuzz.guided --count 5000 [--kinds gamma,program] [--seed 1]``, where atheris is installed
(the extra ``fuzz``). Each kind is read in a process of its own. Inputs that reached new code are kept below
``out/fuzz/pool``: the next run, and ``benchmarks.fuzz.bench``, go on from them. What hangs, or ends its process, is
read again by ``benchmarks.fuzz.bench``, whose readers nobody watches, and is a fault if it does so there.
"""

from __future__ import annotations

import json
import re
import sys
import tempfile
from base64 import b64decode
from dataclasses import dataclass, field, replace
from hashlib import sha256
from importlib.util import find_spec
from pathlib import Path
from time import monotonic
from typing import TYPE_CHECKING, Any

import click
import cv2

from benchmarks.fuzz.bench import REACHED, Plan, Tally, attack, kept, processor_of
from benchmarks.fuzz.kinds import Kind, kinds
from benchmarks.fuzz.worker import SLOW, Fault
from benchmarks.shared.claims import Claim, report
from plogic.base.children import Child, ending_well, heard, python

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

WATCHED = 5.0
"""How much longer an input may take where every step is watched."""
STARTING = 120.0
"""Processor seconds until the first input is read."""
ENDS = 20
"""Processes of a kind that may be ended by an input."""
_COVERED = re.compile(r"#\d+\s+(\w+)\s+cov: (\d+)")
CAPTION = """`outcomes`: different ways in which reading ended; `began`, `reached`: branches of our code, and of ProbLog's, that what it began
with goes through, and all inputs; `kept`: inputs that reached new code; `ends`: processes that an input ended, or hung."""


@dataclass
class Guided:
    """One kind, and what came of it."""

    tally: Tally
    folder: Path
    count: int
    seed: int
    outcomes: set[str] = field(default_factory=set)
    suspects: list[bytes] = field(default_factory=list)
    began: int = 0
    reached: int = 0

    @property
    def kind(self) -> Kind:
        """What is read."""
        return self.tally.kind

    @property
    def pool(self) -> Path:
        """Where inputs that reached new code are kept."""
        return self.tally.out / REACHED / self.kind.name

    def done(self) -> bool:
        """Whether no more inputs are to be read."""
        return self.tally.tried >= self.count or len(self.suspects) >= ENDS

    def told(self, line: bytes) -> None:
        """Take in what was said of an input."""
        self.tally.tried += 1
        if line.startswith(b"{"):
            row = json.loads(line)
            self.tally.fault(Fault(self.kind.name, row["what"], b64decode(row["data"]), row["where"]))
        else:
            self.outcomes.add(line.decode())

    def covered(self, said: str) -> None:
        """Take in what libFuzzer said."""
        found = [(what, int(number)) for what, number in _COVERED.findall(said)]
        self.began = self.began or max((number for what, number in found if what == "INITED"), default=0)
        self.reached = max([self.reached, *(number for _, number in found)])

    def row(self) -> dict[str, Any]:
        """Its row of the table."""
        return {
            "kind": self.kind.name, "inputs": self.tally.tried, "outcomes": len(self.outcomes), "began": self.began,
            "reached": self.reached, "kept": len(list(self.pool.iterdir())), "ends": len(self.suspects),
            "faults": len(self.tally.faults),
        }  # fmt: skip


class Reading:
    """The process that reads a kind's inputs."""

    def __init__(self, guided: Guided) -> None:
        self.guided, number = guided, len(guided.suspects)
        self._place = guided.folder / str(number)
        left = guided.count - guided.tally.tried
        words = [guided.kind.name, str(left), str(guided.seed + number), str(self._place), str(guided.pool)]
        self.child = Child(python("benchmarks.fuzz.guided_child", *words, str(guided.folder / "start")), folder=".")
        self._rest, self._read = b"", 0
        self._before, self._since = 0.0, monotonic()

    def hear(self) -> bool:
        """Take in what it says; whether it is still alive."""
        piece = self.child.read()
        *lines, self._rest = (self._rest + piece).split(b"\n")
        for line in lines:
            self.guided.told(line)
        if lines:
            self._read += len(lines)
            self._before, self._since = processor_of(self.child.pid), monotonic()
        return bool(piece)

    def hangs(self) -> bool:
        """Whether the input that is read takes too long."""
        limit = WATCHED * SLOW if self._read else STARTING
        return processor_of(self.child.pid) - self._before > limit or monotonic() - self._since > 10 * limit

    def end(self, *, well: bool) -> None:
        """End it; what it was reading is suspect, unless it went ``well``.

        Raises RuntimeError where it did not begin.
        """
        well = well and self.child.wait() == 0
        self.guided.covered(self.child.last_words())
        said = self.child.last_words()[-2000:]
        self.child.end()
        if not self._read:
            raise RuntimeError(f"{self.guided.kind.name}: did not begin: {said}")
        if not well:
            self.guided.tally.tried += 1
            self.guided.suspects.append((self._place / self.guided.kind.file).read_bytes())


def guide(chosen: Sequence[Guided], jobs: int, say: Callable[[str], None]) -> None:
    """Read the inputs of every kind, of so many kinds at a time."""
    waiting, running = list(chosen), list[Reading]()
    while waiting or running:
        while waiting and len(running) < jobs:
            running.append(Reading(waiting.pop(0)))
        speaking = heard([reading.child for reading in running], 1.0)
        for reading in list(running):
            alive = reading.child not in speaking or reading.hear()
            if alive and not reading.hangs():
                continue
            running.remove(reading)
            reading.end(well=not alive)
            if reading.guided.done():
                say(
                    f"{reading.guided.kind.name}: {reading.guided.tally.tried} inputs, {reading.guided.reached} branches"
                )
            else:
                waiting.append(reading.guided)


def judge(guided: Guided, plan: Plan, say: Callable[[str], None]) -> None:
    """Read the suspects where nobody watches: what is wrong there is a fault."""
    if guided.suspects:
        alone = replace(guided.kind, seeds=lambda: guided.suspects)
        (tally,) = attack([alone], replace(plan, count=len(guided.suspects)), say)
        guided.tally.faults |= tally.faults


def begun(kind: Kind, plan: Plan, folder: Path, say: Callable[[str], None]) -> Guided:
    """A kind with what it begins with: good inputs, and what was found before."""
    guided = Guided(Tally(kind, [], plan.out, say, plan.count), folder, plan.count, plan.seed)
    for place in (guided.pool, folder / "start"):
        place.mkdir(parents=True, exist_ok=True)
    for data in [*kind.seeds(), *kept(kind.name)]:
        (folder / "start" / sha256(data).hexdigest()[:20]).write_bytes(data)
    return guided


@click.command()
@click.option("--count", type=click.IntRange(1), default=5000, show_default=True, help="Inputs of each kind.")
@click.option("--kinds", "names", default="", help="Some kinds, with commas between; all others are left out.")
@click.option("--seed", type=click.IntRange(1), default=1, show_default=True)
@click.option("--jobs", type=click.IntRange(1, 64), default=1, show_default=True)
@click.option("-o", "--out", type=click.Path(path_type=Path), default=Path("out/fuzz"), show_default=True)
@click.option("--json", "as_json", is_flag=True)
def main(count: int, names: str, seed: int, jobs: int, out: Path, *, as_json: bool) -> None:
    """Read hostile inputs that are led by the code they reach, and say what came of it."""
    if find_spec("atheris") is None:
        click.echo("not led by the code that is reached: atheris is not installed (it has wheels for some Pythons)")
        return
    known = {name: kind for name, kind in kinds().items() if kind.rare == 1}  # what a child does is not seen
    wanted = names.split(",") if names else list(known)
    if strange := [name for name in wanted if name not in known]:
        raise click.UsageError(f"--kinds: {', '.join(strange)}: known are {', '.join(known)}")

    def say(line: str) -> None:
        click.echo(line, err=True)

    cv2.setNumThreads(0)
    plan = Plan(count, 1e9, seed, jobs, out)
    with ending_well(), tempfile.TemporaryDirectory(prefix="plogic-guided-") as folder:
        chosen = [begun(known[name], plan, Path(folder) / name, say) for name in wanted]
        guide(chosen, jobs, say)
        for guided in chosen:
            judge(guided, plan, say)
    faults = sum(len(guided.tally.faults) for guided in chosen)
    tried = sum(guided.tally.tried for guided in chosen)
    claims = [Claim(f"internal errors, deaths and hangs of {tried} inputs", "<=", 0, faults)]
    text, met = report("fuzz guided", [guided.row() for guided in chosen], claims, as_json=as_json)
    click.echo(text if as_json else f"{text}\n{CAPTION}")
    sys.exit(0 if met else 1)


if __name__ == "__main__":
    main()
