"""``plogic bench worlds``: exact inference over program families, beside stock ProbLog and independent oracles.

Vocabulary: a ``Case`` is one situation of a family; a ``Measured`` is what all sides made of it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from benchmarks.families.bench import clusters, grid
from benchmarks.shared.claims import report
from benchmarks.worlds.oracle import MOST, by_frontier, enumerated, marginals_of
from benchmarks.worlds.ours import FEW, OurRun, ours
from benchmarks.worlds.stock import StockRun, fastest
from benchmarks.worlds.table import CAPTION, claims, row, stages

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from benchmarks.worlds.stock import Knowledge
    from plogic.facts.situation import Situation

SIZES = (5, 10, 20, 40, 80, 200)
QUICK_SIZES, QUICK_SCENES, QUICK_LIMIT = (5, 10, 20), (10,), 3.0
WIDEST = 19
"""Columns of the widest grid, which is square."""
SWEPT = 12
"""Columns from which a grid is held to the frontier: narrower ones are held to ProbLog or to enumeration."""
SKIPPED = "skipped"


@dataclass(frozen=True)
class Case:
    """One situation; ``columns`` of a grid, else 0; ``tried``: whether stock ProbLog is run at all."""

    family: str
    number: int
    situation: Situation
    columns: int = 0
    tried: bool = True


@dataclass(frozen=True)
class Measured:
    """One case, the stock runs, ours, and the largest difference from each side that has an answer."""

    case: Case
    stock: tuple[StockRun, ...]
    ours: OurRun
    differences: dict[str, float]
    limit: float


def run(*, seed: int, limit: float, quick: bool, as_json: bool, say: Callable[[str], None]) -> tuple[str, bool]:
    """Run the benchmark; a line of progress a case on ``say``. ``limit``: seconds of one stock run."""
    limit = min(limit, QUICK_LIMIT) if quick else limit
    failed: set[tuple[str, Knowledge]] = set()
    measured = []
    for case in cases(seed, quick=quick):
        measured.append(measure(case, limit, failed))
        say(_said(measured[-1]))
    promised = claims(measured)
    if as_json:
        return report("worlds", [row(m) | stages(m) for m in measured], promised, as_json=True)
    text, met = report("worlds", [row(m) for m in measured], promised, as_json=False)
    from plogic.face.shown.tables import plain_table

    table = plain_table("stages: ProbLog's faster way, and ours", [_named(m) | stages(m) for m in measured])
    return f"{CAPTION}\n\n{table}\n{text}", met


def cases(seed: int, *, quick: bool) -> Iterator[Case]:
    """All cases, smaller ones of a family first; made one at a time, since scenes are rendered."""
    sizes = QUICK_SIZES if quick else SIZES
    yield from (Case("clusters", k, clusters(k, seed)) for k in sizes)
    yield from (Case("clusters/score", k, clusters(k, seed, "score")) for k in sizes)
    yield from (Case("grid", k, grid(k, math.isqrt(k), seed), math.isqrt(k)) for k in sizes)
    if not quick:
        yield Case("grid", WIDEST**2, grid(WIDEST**2, WIDEST, seed), WIDEST, tried=False)
    yield from _scenes(seed, QUICK_SCENES if quick else sizes)


def _scenes(seed: int, sizes: tuple[int, ...]) -> Iterator[Case]:
    from benchmarks.worlds.scenes import simulated
    from plogic.run.perceive import Perceiver
    from plogic.run.sources import kb_of

    perceiver = Perceiver(kb_of("towers"))
    yield from (Case("simulated", k, simulated(perceiver, k, seed)) for k in sizes)


def measure(case: Case, limit: float, failed: set[tuple[str, Knowledge]]) -> Measured:
    """Stock ProbLog, ours, and the oracles.

    ``failed`` remembers the families that a way from the text failed at.
    """
    from plogic.scene.text.program_text import program_text, query_lines

    text = program_text(case.situation) + query_lines(case.situation) if case.tried else None
    stock = tuple(_stock(case, text, k, limit, failed) for k in ("ddnnf", "sdd")) if text is not None else ()
    told = _stock(case, text, "plogic", limit, failed) if text is not None else None
    mine = ours(case.situation, told)
    return Measured(case, stock, mine, _differences(case, mine, stock), limit)


def _stock(case: Case, text: str, knowledge: Knowledge, limit: float, failed: set[tuple[str, Knowledge]]) -> StockRun:
    """A way that failed at a smaller size of the family is not tried again."""
    if (case.family, knowledge) in failed:
        return StockRun(knowledge, why=SKIPPED)
    found = fastest(text, knowledge, limit)
    if found.why:
        failed.add((case.family, knowledge))
    return found


def _differences(case: Case, mine: OurRun, stock: tuple[StockRun, ...]) -> dict[str, float]:
    """The largest difference of a marginal from ProbLog's ways, from the program text by ours, and from the oracles."""
    found: dict[str, float] = {
        s.knowledge: _largest(mine.answers, _by_hypothesis(case, s.answers)) for s in stock if s.answers
    }
    if mine.of_text:
        found["text"] = _largest(mine.answers, _by_hypothesis(case, mine.of_text))
    if case.number <= MOST:
        chances = enumerated(case.situation)
        best = sorted(chances.ravel().tolist(), reverse=True)[:FEW]
        found["enumeration"] = _largest(mine.answers, marginals_of(case.situation, chances))
        found["enumerated worlds"] = max(abs(p - q) for p, q in zip(mine.best, best, strict=False))
    if case.columns >= SWEPT:
        names = [h.id for h in case.situation.hypotheses]
        found["frontier"] = _largest(
            mine.answers, by_frontier(case.situation, case.columns, (names[0], names[len(names) // 2], names[-1]))
        )
    return found


def _by_hypothesis(case: Case, answers: dict[str, float]) -> dict[str, float]:
    from plogic.facts.situation import names_of

    names = names_of(case.situation)
    return {h.id: answers[f"present({names.atom(h.id)})"] for h in case.situation.hypotheses}


def _largest(mine: dict[str, float], theirs: dict[str, float]) -> float:
    return max(abs(mine[h] - p) for h, p in theirs.items())


def _named(m: Measured) -> dict[str, Any]:
    return {"family": m.case.family, "K": m.case.number}


def _said(m: Measured) -> str:
    runs = ", ".join(f"{s.knowledge} {s.why or f'{s.infer:.3f} s'}" for s in m.stock)
    return f"{m.case.family} {m.case.number}: ours {1000 * m.ours.marginals:.2f} ms; {runs or 'stock not run'}"
