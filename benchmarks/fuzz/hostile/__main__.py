"""Hostile programs through the console script: what runs, opens, outlives its limit, or is left behind.

``python -m benchmarks.fuzz.hostile``. Every program comes through a door (``doors``) in a folder of its own, with bait
beside it. It must run no code and open no file: nothing may be opened or started that harmless programs do not open or
start in the same run, ProbLog's libraries apart. It must end within its limit and two seconds, beside the time that a
harmless program takes there, and leave no process and no file.
"""

from __future__ import annotations

import sys
import tempfile
from collections import defaultdict
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from benchmarks.fuzz.hostile.bombs import bombs
from benchmarks.fuzz.hostile.disguises import disguises
from benchmarks.fuzz.hostile.doors import DOORS, HARMLESS, door_of, goal_of, limit_of
from benchmarks.fuzz.hostile.escapes import escapes
from benchmarks.fuzz.hostile.hard_counting import clauses, grid, hard
from benchmarks.fuzz.hostile.other_doors import other_doors
from benchmarks.fuzz.hostile.run import Cost, Seen, killed, run
from benchmarks.fuzz.hostile.texts import texts
from benchmarks.shared.claims import Claim, report

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Sequence

    from benchmarks.fuzz.hostile.program import Hostile

BEYOND = 2.0
"""Seconds by which a program may outlive its limit."""
AGAIN = 25
"""After so many programs the harmless ones run once more: the machine may have become slower."""
FAMILIAR = {
    "libraries": ":- use_module(library(lists)). :- use_module(library(apply)). :- use_module(library(aggregate)). "
    ":- use_module(library(string)). :- use_module(library(assert)). :- use_module(library(record)). :- use_module(library(cut)). "
    ":- use_module(library(collect)). :- use_module(library(control)). :- use_module(library(scope)). 0.5::a. query(a).",
    "refused": "a :- consult(x). query(a).",
    "late": "a :- p(z). p(X) :- p(f(X)). query(a).",
    "compiled": grid(5),
    "impossible": "0.5::a. evidence(a). evidence(\\+ a). query(a).",
    "mistaken": "a :- b(. query(a).",
}
"""Programs that are harmless too: what they open and start is no fault of any other."""


def corpus() -> list[Hostile]:
    """All programs."""
    return [*escapes(), *disguises(), *other_doors(), *bombs(), *hard(), *texts()]


@dataclass(frozen=True)
class Told:
    """A program, its door and its limit, what was seen of it, and what a harmless program takes there."""

    program: Hostile
    door: str
    limit: float
    seen: Seen
    start: Cost
    did: tuple[str, ...]

    @property
    def beyond(self) -> float:
        """Seconds beyond its limit."""
        return self.seen.cost.beyond(self.start, self.limit)

    def faults(self) -> list[str]:
        """What must not have happened."""
        late = [f"{self.beyond:.1f} s beyond its limit"] * (self.beyond > BEYOND)
        return self.misdeeds() + late

    def misdeeds(self) -> list[str]:
        """The same, whatever time it took."""
        seen = self.seen
        found = {
            f"took bait: {seen.owned}": bool(seen.owned),
            f"opened or started: {self.did[:3]}": bool(self.did),
            "told a secret": seen.told,
            f"left files: {seen.left_files[:3]}": bool(seen.left_files),
            f"left {seen.left_processes} processes": seen.left_processes > 0,
            f"{seen.fault}": seen.fault is not None,
        }
        return [what for what, wrong in found.items() if wrong]


class Bench:
    """Programs that run beside each other, and the harmless ones that they are compared with."""

    def __init__(self, folder: Path, jobs: int) -> None:
        self.folder, self.jobs = folder, jobs
        self.start: dict[str, Cost] = {}
        self.familiar: set[str] = set()
        self.memory = 0
        """Of harmless programs at worst."""

    def measure(self, doors: Sequence[str], familiar: Sequence[str] = ()) -> None:
        """Run what is harmless through doors."""
        given = [(door, HARMLESS[door]) for door in doors] + [("query", text) for text in familiar]
        for i, (door, seen) in enumerate(self._beside(given)):
            if i < len(doors):
                self.start[door] = seen.cost.beside(self.start.get(door, Cost()))
            self.familiar |= seen.did
            self.memory = max(self.memory, seen.memory)

    def _beside(self, given: Sequence[tuple[str, str]]) -> list[tuple[str, Seen]]:
        with ThreadPoolExecutor(self.jobs) as pool:
            goals = {"scene rules": "present(H)", "interpretation": "present(H)"}
            runs = [
                pool.submit(
                    run, door, text, goals.get(door, "a"), self.folder / f"harmless{i}", limit_of(door, text, bomb=True)
                )
                for i, (door, text) in enumerate(given)
            ]
            return [(door, each.result()) for (door, _), each in zip(given, runs, strict=True)]

    def attack(self, programs: Sequence[tuple[str, Hostile]]) -> Iterator[Told]:
        """Each program by its door."""
        with ThreadPoolExecutor(self.jobs) as pool:
            for begin in range(0, len(programs), AGAIN):
                some = programs[begin : begin + AGAIN]
                if begin:
                    self.measure(sorted({door for door, _ in some}))
                runs = [pool.submit(self._one, begin + i, door, program) for i, (door, program) in enumerate(some)]
                for (door, program), each in zip(some, runs, strict=True):
                    limit, seen = limit_of(door, program.text, bomb=program.bomb), each.result()
                    yield Told(program, door, limit, seen, self.start[door], tuple(sorted(seen.did - self.familiar)))

    def _one(self, number: int, door: str, program: Hostile) -> Seen:
        limit = limit_of(door, program.text, bomb=program.bomb)
        return run(door, program.text, goal_of(program), self.folder / f"hostile{number}", limit)


def attacked(programs: Sequence[Hostile], jobs: int, say: Callable[[str], None] = print) -> tuple[list[Told], int]:
    """Run programs; faults are said as they are found. Also bytes of memory of the harmless ones at worst."""
    given = [(door_of(program, i), program) for i, program in enumerate(programs)]
    with tempfile.TemporaryDirectory(prefix="plogic-hostile-") as folder:
        bench, told = Bench(Path(folder), jobs), []
        bench.measure(sorted({"query", *(door for door, _ in given)}), list(FAMILIAR.values()))
        for each in bench.attack(given):
            told.append(each)
            for fault in each.faults():
                say(f"{each.program.tries} ({each.door}): {fault}")
    return told, bench.memory


def rows_of(told: Sequence[Told]) -> list[dict[str, Any]]:
    """A row for each door."""
    by_door = defaultdict(list)
    for each in told:
        by_door[each.door].append(each)
    return [
        {
            "door": " ".join(["plogic", *DOORS[door]]),
            "programs": len(some),
            "bombs": sum(each.program.bomb for each in some),
            "faults": sum(bool(each.faults()) for each in some),
            "start": round(max(each.start.clock for each in some), 2),
            "beyond": round(max(each.beyond for each in some), 2),
            "memory": max(each.seen.memory for each in some) >> 20,
        }
        for door, some in by_door.items()
    ]


def claims(told: Sequence[Told], left: int | None) -> list[Claim]:
    """What must hold of all programs together; ``left``: processes of a command that was killed."""
    return [
        Claim("ran code, or took bait", "<=", 0, sum(bool(each.seen.owned) for each in told)),
        Claim("opened or started something", "<=", 0, sum(bool(each.did) for each in told)),
        Claim("told a secret", "<=", 0, sum(each.seen.told for each in told)),
        Claim("seconds beyond the limit", "<=", BEYOND, max(each.beyond for each in told)),
        Claim("left a process", "<=", 0, sum(each.seen.left_processes > 0 for each in told)),
        Claim("left a file", "<=", 0, sum(bool(each.seen.left_files) for each in told)),
        Claim("ended in an internal error", "<=", 0, sum(each.seen.fault is not None for each in told)),
        Claim("processes left by SIGKILL while a compiler works", "<=", 0, left),
    ]


@click.command()
@click.option("--jobs", type=click.IntRange(1), default=2, show_default=True, help="Programs beside each other.")
@click.option("--only", multiple=True, help="Programs that try this, or come by this door (may be repeated).")
@click.option("--every", type=click.IntRange(1), default=1, help="One of so many programs.")
@click.option("--json", "as_json", is_flag=True)
def main(jobs: int, only: tuple[str, ...], every: int, *, as_json: bool) -> None:
    """Run hostile programs, and say what came of it."""
    programs = [
        program
        for program in corpus()
        if not only or any(word in program.tries or word == program.door for word in only)
    ][::every]
    told, memory = attacked(programs, jobs, lambda line: click.echo(line, err=True))
    with tempfile.TemporaryDirectory(prefix="plogic-killed-") as folder:
        left = killed(clauses(120, 480), Path(folder))
    name = f"hostile programs: {len(told)}, {sum(each.program.bomb for each in told)} of them bombs"
    text, met = report(
        f"{name}; harmless ones take {memory >> 20} MB", rows_of(told), claims(told, left), as_json=as_json
    )
    click.echo(text)
    sys.exit(0 if met else 1)


if __name__ == "__main__":
    main()
