"""What ``plogic bench calibration`` prints and draws.

A row a reading and a set of hypotheses, the claims, and the picture.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from benchmarks.calibration.diagram import Panel, diagram
from benchmarks.calibration.forecasts import CYCLE, GATE, P_EV, POSTERIOR, READINGS
from benchmarks.calibration.reliability import (
    BINS,
    LEAST,
    bootstrap_interval,
    brier,
    brier_skill,
    expected_calibration_error,
    log_loss,
)
from benchmarks.shared.claims import Claim

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from benchmarks.calibration.forecasts import Forecast

    Floats = NDArray[np.float64]

ECE, FEWEST, FEWEST_OPEN = 0.05, 1000, 200
OPEN = 0.05, 0.95
"""Probabilities between these leave a question open."""
CAPTION = f"""\
Hypotheses about scenes of bodies that look alike, seen poorly and in clutter; rates learned on other scenes. among: gate, all poses that passed
the geometric gate, duplicates merged, nothing accepted or rejected; cycle, what perception accepted and its rivals. true: right type,
and pose within the tolerance of duplicates. open: probabilities from {OPEN[0]} to {OPEN[1]}. skill: of the Brier score, over the base rate.
log loss: no forecast surer than {LEAST:g}. ECE: {BINS} bins of equal mass; low, high: its 95 % interval, scenes drawn anew. The second
posterior takes each pose as if it had been known before it was fitted."""


def rows(found: Sequence[Forecast], seed: int = 0) -> list[dict[str, Any]]:
    """One for each set of hypotheses and each reading."""
    return [
        _row(found, among, reading, seed)
        for among in (GATE, CYCLE)
        for reading in READINGS
        if any(f.among == among for f in found)
    ]


def _row(found: Sequence[Forecast], among: str, reading: str, seed: int) -> dict[str, Any]:
    p, y, scene = said(found, among, reading)
    low, high = bootstrap_interval(expected_calibration_error, p, y, scene, seed=seed)
    return {
        "among": among,
        "reading": reading,
        "hypotheses": len(p),
        "true": int(y.sum()),
        "open": _open(p),
        "Brier": round(brier(p, y), 4),
        "skill": round(brier_skill(p, y), 3),
        "log loss": round(log_loss(p, y), 3),
        "ECE": round(expected_calibration_error(p, y), 4),
        "low": round(low, 4),
        "high": round(high, 4),
    }


def said(found: Sequence[Forecast], among: str, reading: str) -> tuple[Floats, Floats, NDArray[np.intp]]:
    """Probabilities (N,), what is true (N,), and the scenes (N,) of one set of hypotheses by one reading."""
    mine = [f for f in found if f.among == among]
    return (
        np.array([f.said[reading] for f in mine]),
        np.array([float(f.true) for f in mine]),
        np.array([f.scene for f in mine], np.intp),
    )


def _open(p: Floats) -> int:
    return int(((p >= OPEN[0]) & (p <= OPEN[1])).sum())


def claims(found: Sequence[Forecast], share: float = 1.0) -> list[Claim]:
    """What is promised of the posterior reading; where a ``share`` of the scenes was judged, so much of the numbers."""
    p, y, _ = said(found, GATE, POSTERIOR)
    return [
        Claim("hypotheses that passed the geometric gate", ">=", FEWEST * share, len(p)),
        Claim("of them with a posterior from 0.05 to 0.95", ">=", FEWEST_OPEN * share, _open(p)),
        Claim("ECE of the posterior", "<=", ECE, expected_calibration_error(p, y)),
        Claim("Brier skill of the posterior over the base rate", ">=", 0.0, brier_skill(p, y)),
    ]


def drawn(found: Sequence[Forecast]) -> str:
    """The reliability diagram of the hypotheses that passed the gate: the posterior, and P(ev) beside it."""
    panels = []
    for reading in (POSTERIOR, P_EV):
        p, y, _ = said(found, GATE, reading)
        figures = f"ECE {expected_calibration_error(p, y):.3f} · Brier {brier(p, y):.3f} · skill {brier_skill(p, y):+.2f}".replace(
            "-", "−"
        )
        panels.append(Panel(reading, figures, p, y))
    return diagram(f"Do probabilities mean what they say? {len(p)} hypotheses, {BINS} bins of equal mass", panels)
