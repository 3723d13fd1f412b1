"""``plogic bench programs``: what people try first, beside stock ProbLog in the same run.

Two measures of each side, both in processor seconds: the whole process, as it is started from a shell, and the way from
the text to the answers alone, without the imports.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from benchmarks.programs.families import samples
from benchmarks.programs.whole import Whole, whole
from benchmarks.shared.claims import Claim, report
from benchmarks.worlds.stock import StockRun, fastest

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from benchmarks.programs.families import Sample
    from benchmarks.worlds.stock import Knowledge

CAPTION = (
    "processor seconds; `sdd` is stock ProbLog's default and `ddnnf` its other backend. `process`: the whole process,\n"
    "`problog FILE` or `plogic query FILE`; the other columns: from the text to the answers, imports excluded."
)
FACTOR, MORE = 1.2, 0.25
"""A whole process may take so many times stock's, and so many seconds more."""
AHEAD = {"HMM": 20, "QMR": 8, "directed grid": 8}
"""Families in which we were faster than stock, from this size on."""
QUICK_LIMIT = 10.0


@dataclass(frozen=True)
class Measured:
    """One program; ``runs``: sdd, ddnnf and plogic without imports; ``whole``: the processes sdd and plogic."""

    sample: Sample
    runs: dict[str, StockRun]
    whole: dict[str, Whole]
    limit: float

    @property
    def excess(self) -> float:
        """Seconds that our process takes beyond what it may; stock's counts as the limit where it was ended."""
        return self.whole["plogic"].seconds - FACTOR * self.whole["sdd"].seconds - MORE

    @property
    def difference(self) -> float | None:
        """The largest difference of an answer from stock's, 1 where ours is missing; None where stock has none."""
        mine = self.runs["plogic"].answers
        theirs = [self.runs[name].answers for name in ("sdd", "ddnnf") if self.runs[name].answers]
        return max((abs(p - mine.get(goal, p + 1.0)) for found in theirs for goal, p in found.items()), default=None)

    def ratio(self) -> float:
        """Our seconds over those of stock's default, imports excluded."""
        theirs = self.runs["sdd"]
        return self.runs["plogic"].whole / (self.limit if theirs.why else theirs.whole)

    def row(self) -> dict[str, Any]:
        """The row of the table."""
        seconds = {name: run.why or round(run.whole, 4) for name, run in self.runs.items()}
        processes = {
            f"{name} process": f"> {self.limit:g}" if run.over else round(run.seconds, 3)
            for name, run in self.whole.items()
        }
        told = {"family": self.sample.family, "size": self.sample.size, **processes, **seconds}
        return {**told, "difference": None if self.difference is None else float(f"{self.difference:.1e}")}


def run(*, seed: int, limit: float, quick: bool, as_json: bool, say: Callable[[str], None]) -> tuple[str, bool]:
    """Run the benchmark; ``limit``: wall seconds of one run of either side."""
    limit = min(limit, QUICK_LIMIT) if quick else limit
    failed: set[tuple[str, str]] = set()
    measured = []
    for sample in samples(seed, quick=quick):
        measured.append(measure(sample, limit, failed))
        say(f"{sample.family} {sample.size}: {measured[-1].row()}")
    text, met = report("programs", [one.row() for one in measured], claims(measured), as_json=as_json)
    return (text if as_json else f"{CAPTION}\n\n{text}"), met


def measure(sample: Sample, limit: float, failed: set[tuple[str, str]]) -> Measured:
    """All sides of one program; ``ddnnf`` is not tried again in a family at which it failed: ``failed``."""
    sides: tuple[Knowledge, ...] = ("sdd", "ddnnf", "plogic")
    runs: dict[str, StockRun] = {}
    for side in sides:
        skipped = side == "ddnnf" and (sample.family, side) in failed
        runs[side] = StockRun(side, why="skipped") if skipped else fastest(sample.text, side, limit)
        if runs[side].why:
            failed.add((sample.family, side))
    return Measured(sample, runs, {side: whole(sample.text, side, limit) for side in ("sdd", "plogic")}, limit)


def claims(measured: Sequence[Measured]) -> list[Claim]:
    """Nobody is worse off than with stock."""
    answered = [one for one in measured if one.runs["plogic"].answers and not one.whole["plogic"].over]
    compared = [one.difference for one in measured if one.difference is not None]
    ahead = [one.ratio() for one in measured if one.sample.size >= AHEAD.get(one.sample.family, one.sample.size + 1)]
    return [
        Claim("programs answered", ">=", 1.0, len(answered) / len(measured)),
        Claim(
            f"whole process: most seconds past {FACTOR:g} × stock's + {MORE:g} s",
            "<=",
            0.0,
            max(one.excess for one in measured),
        ),
        Claim("largest difference from stock's answers", "<=", 1e-9, max(compared, default=1.0)),
        Claim("what was faster than stock stays so: most of our seconds over stock's", "<=", 1.0, max(ahead)),
    ]
