"""What ``plogic bench worlds`` prints: a row a case, the seconds of each stage, and the claims."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from benchmarks.shared.claims import Claim

if TYPE_CHECKING:
    from collections.abc import Sequence

    from benchmarks.worlds.bench import Measured
    from benchmarks.worlds.stock import StockRun

CAPTION = """\
K hypotheses; Γ: appearances. Families are in the posterior reading; score: clusters in the score reading. All times are of this run and of the
processor, compilers that either side starts included: other work on the machine does not count. ProbLog's and text are in
seconds, all else of ours in milliseconds. Only ProbLog's limit is of wall time; `> ` before a ratio: what ProbLog's compilation
had used of the processor by then, over ours.
ddnnf, sdd: stock ProbLog, compilation and evaluation of the ground program, one evidence atom a constraint, all P(present(H)).
ours: all P(present(H)) from the typed description, building the graph included. ratio: ProbLog's faster way over ours.
text: from the characters of the program to the same answers, reading and grounding included, ours, in a
fresh process as ProbLog's; ratio of text: ProbLog's faster way over it. Nothing that a step of ours remembers is left for the next one.
top 10, top 1000: the most probable worlds from the typed description, building included; listed: the top 1000 as `worlds` gives them, with
marginals and causes. differ: the largest difference of any marginal (and of the ten best worlds' probabilities) from ProbLog, from our way
from the text, from the sum over all 2^K worlds where K is at most 14, and from a frontier swept over wide grids.
simulated: Δh not pruned, of as many photographs as hold ten rivals or more an object (one object at K = 5), cut to the K of greatest worth.
A way of ProbLog's that fails at one size of a family is not tried at larger ones: skipped."""
RIVALS = 10
CLUSTERS = {"clusters": "clusters, posterior", "clusters/score": "clusters, score"}
ORACLES = ("enumeration", "enumerated worlds", "frontier")


def row(m: Measured) -> dict[str, Any]:
    """One line of the table; of a way that gave no answer, why."""
    mine = m.ours
    return {
        "family": m.case.family.removeprefix("clusters/"),
        "K": m.case.number,
        "Γ": len(m.case.situation.appearances),
        **{k: _seconds(m, k) for k in ("ddnnf", "sdd")},
        "ours": _milli(mine.marginals),
        "ratio": _shown(ratio(m), ".0f", least=not answered(m)),
        "text": "" if mine.text is None else f"{mine.text:.2f}",
        "ratio of text": _shown(text_ratio(m), ".1f"),
        "top 10": _milli(mine.build + mine.few),
        "top 1000": _milli(mine.build + mine.many),
        "listed": _milli(mine.listed),
        "differ": f"{max(m.differences.values()):.0e}" if m.differences else "",
    }


def stages(m: Measured) -> dict[str, Any]:
    """Where the time goes, on both sides."""
    best = min(answered(m), key=lambda s: s.infer, default=None)
    mine = m.ours
    return {
        "way": best.knowledge if best else "",
        "parse": f"{best.parse:.3f}" if best else "",
        "ground": f"{best.ground:.3f}" if best else "",
        "compile+evaluate": f"{best.infer:.3f}" if best else "",
        "our build": _milli(mine.build),
        "marginals": _milli(mine.infer),
        "top 10 of it": _milli(mine.few),
        "top 1000 of it": _milli(mine.many),
    }


def _milli(seconds: float) -> str:
    """Milliseconds, to a microsecond or three digits."""
    return f"{1000 * seconds:.3f}" if seconds < 0.01 else f"{1000 * seconds:.3g}"


def answered(m: Measured) -> list[StockRun]:
    """The stock runs that gave an answer."""
    return [s for s in m.stock if s.answers]


def ratio(m: Measured) -> float | None:
    """ProbLog's faster way over ours; a lower bound where all that were tried ran out of time.

    None where that says nothing.
    """
    seconds = [s.infer for s in answered(m)] or [s.infer for s in m.stock if s.timed_out]
    return min(seconds) / m.ours.marginals if seconds and min(seconds) > 0 else None


def text_ratio(m: Measured) -> float | None:
    """From the text: ProbLog's faster way over ours; None where there is no answer on either side."""
    seconds = min((s.whole for s in answered(m)), default=None)
    return None if seconds is None or m.ours.text is None else seconds / m.ours.text


def _seconds(m: Measured, knowledge: str) -> str:
    found = next((s for s in m.stock if s.knowledge == knowledge), None)
    if found is None:
        return "not run"
    return found.why or f"{found.infer:.3f}"


def _shown(value: float | None, digits: str, *, least: bool = False) -> str:
    return "" if value is None else ("> " if least else "") + format(value, digits)


def claims(measured: Sequence[Measured]) -> list[Claim]:
    """What was promised, for the cases that were run."""
    return [*_speed(measured), *_ranking(measured), *_agreement(measured)]


def _speed(measured: Sequence[Measured]) -> list[Claim]:
    times = "times as fast as stock ProbLog's best"
    scenes = [ratio(m) for m in measured if m.case.family == "simulated" and m.case.number >= RIVALS]
    least = min((value for value in scenes if value is not None), default=0.0)
    return [
        *(
            Claim(f"{named}, K = {number}: all marginals, {times}", ">=", bar, ratio(m) or 0.0)
            for family, named in CLUSTERS.items()
            for number, bar in ((20, 100), (80, 300))
            for m in _of(measured, family, number)
        ),
        Claim(f"simulated scenes, Δh not pruned, K from {RIVALS}: all marginals, {times}, the least", ">=", 100, least),
        *(
            Claim(f"{named}, K = 80, from the program text: {times}", ">=", 4, text_ratio(m) or 0.0)
            for family, named in CLUSTERS.items()
            for m in _of(measured, family, 80)
        ),
    ]


def _ranking(measured: Sequence[Measured]) -> list[Claim]:
    widest = max((m for m in measured if m.case.family == "grid"), key=lambda m: m.case.columns)
    dearest = max((m.ours.build + m.ours.few) / m.ours.marginals for m in measured)
    found = [
        Claim(
            f"grid of width {widest.case.columns}: seconds for all marginals, exact", "<=", 10, widest.ours.marginals
        ),
        Claim("top-10 worlds over all marginals, both from the typed description, the largest ratio", "<=", 1, dearest),
    ]
    largest = [m.ours.listed for m in measured if m.case.number == 200]
    if largest:
        found.append(
            Claim("K = 200, any family: seconds for the top-1000 worlds, listed with causes", "<=", 1, max(largest))
        )
    return found


def _agreement(measured: Sequence[Measured]) -> list[Claim]:
    stock = [d for m in measured for name, d in m.differences.items() if name in {"ddnnf", "sdd"}]
    oracles = [d for m in measured for name, d in m.differences.items() if name in ORACLES]
    return [
        Claim(
            "largest difference from stock ProbLog wherever it finishes, in 1e-9",
            "<=",
            1,
            max(stock, default=0.0) / 1e-9,
        ),
        Claim("largest difference from enumeration and frontier, in 1e-9", "<=", 1, max(oracles, default=0.0) / 1e-9),
    ]


def _of(measured: Sequence[Measured], family: str, number: int) -> list[Measured]:
    return [m for m in measured if m.case.family == family and m.case.number == number]
