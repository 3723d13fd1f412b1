"""What documents claim of photos, and whether it came true: P(a type is there), and P(its pose is right).

P(a type is there): in the posterior reading, the probability of the worlds that hold some object of the type.
``pose_probability`` of what is accepted is a claim if an object of its type is there with a known pose: it is true if
ADD, of symmetric types ADD-S, is below a tenth of the diameter.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from benchmarks.calibration.reliability import BINS, bootstrap_interval, expected_calibration_error, reliability
from benchmarks.photos.score import RIGHT, Posed, error_of
from benchmarks.shared.claims import Claim

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping, Sequence

    from benchmarks.photos.answers import Shown
    from geometry.arrays import Floats
    from plogic.facts.document import HypothesisRow, Interpretation, RejectedRow
    from plogic.run.bop.models import Model

EVERY, NAMED, POSED = "a type is there, all types", "a type is there, those found", "its pose is right"
STANDS = "it stands on the plane"
"""Claims: of every type of the KB; of those that are accepted or their rivals; the others of what is accepted."""
JUDGED = NAMED, POSED
FEW_BINS, IN_BIN = 5, 10
"""Bins are as many as hold ten forecasts each, ``FEW_BINS`` to ``BINS``: of few a bin, ECE is that of the noise. Of 12
calibrated forecasts it is 0.16 in five bins and 0.24 in fifteen, of 150 still 0.08 in fifteen (p from Beta(5, 1))."""


class Forecast(NamedTuple):
    """``Forecast("1/3", NAMED, 0.98, True)``: of a photo, a claim, its probability, and whether it is true."""

    photo: str
    claim: str
    p: float
    true: bool


def forecasts(
    document: Interpretation, numbers: Mapping[str, int], shown: Shown, models: Mapping[int, Model]
) -> Iterator[Forecast]:
    """What the document of a photo claims; ``numbers``: of the KB's types."""
    there = {some.obj_id for some in (*shown.truths, *shown.hidden)} | set(shown.unposed)
    rows = [h for h in document["hypotheses"] if h["status"] != "rejected"]
    for name, number in numbers.items():
        own = {h["id"] for h in rows if type_of(h) == name}
        worlds = document["worlds"] if own else []
        p = min(1.0, float(np.sum([w["probability"] for w in worlds if own.intersection(w["present"])])))
        for claim in (EVERY, NAMED) if own else (EVERY,):
            yield Forecast(shown.name, claim, p, number in there)
    for h in rows:
        number = numbers.get(type_of(h), -1)
        truths = [some for some in (*shown.truths, *shown.hidden) if some.obj_id == number]
        if truths and h["status"] == "accepted" and "pose_probability" in h:
            pose = Posed(number, np.array(h["T_camera_object"]))
            error = min(error_of(pose, truth, models[number]) for truth in truths)
            yield Forecast(shown.name, POSED, h["pose_probability"], error < RIGHT)


def type_of(row: HypothesisRow | RejectedRow) -> str:
    """The type of a hypothesis by the name that its author gave it."""
    return row.get("label") or row["type"]


def rows(name: str, told: Sequence[Forecast], seed: int = 0) -> list[dict[str, Any]]:
    """A row a claim: mean probability, share that is true, ECE with its 95 % interval (photos drawn anew)."""
    return [_row(name, claim, told, seed) for claim in (EVERY, *JUDGED, STANDS) if any(f.claim == claim for f in told)]


def _row(name: str, claim: str, told: Sequence[Forecast], seed: int) -> dict[str, Any]:
    p, y, photo = _said(told, claim)
    low, high = bootstrap_interval(_error, p, y, photo, seed=seed)
    return {
        "of": name,
        "claim": claim,
        "forecasts": len(p),
        "mean P": round(float(p.mean()), 3),
        "true": round(float(y.mean()), 3),
        "ECE": round(_error(p, y), 4),
        "low": round(low, 4),
        "high": round(high, 4),
    }


def bins(name: str, told: Sequence[Forecast], judged: Sequence[str] = JUDGED) -> list[dict[str, Any]]:
    """The reliability table of each claim: a row a bin."""
    listed = []
    for claim in judged:
        p, y, _ = _said(told, claim)
        for b in reliability(p, y, _bins(p)) if len(p) else ():
            low, high = b.interval
            said = {"from": round(b.low, 4), "to": round(b.high, 4), "mean P": round(b.forecast, 4)}
            true = {"true": round(b.true, 4), "low": round(low, 4), "high": round(high, 4)}
            listed.append({"of": name, "claim": claim, **said, **true, "forecasts": b.count})
    return listed


def claims(
    name: str,
    told: Sequence[Forecast],
    bar: float,
    judged: Sequence[str] = JUDGED,
    none: float | None = 0.0,
) -> list[Claim]:
    """That claims are calibrated; ``none``: what is said of no forecast, of which nothing is wrong."""
    said = [(claim, *_said(told, claim)[:2]) for claim in judged]
    return [Claim(f"{name}: ECE, {claim}", "<=", bar, _error(p, y) if len(p) else none) for claim, p, y in said]


def _said(told: Sequence[Forecast], claim: str) -> tuple[Floats, Floats, list[str]]:
    """Probabilities (N,), outcomes (N,), and photos."""
    some = [f for f in told if f.claim == claim]
    return np.array([f.p for f in some]), np.array([float(f.true) for f in some]), [f.photo for f in some]


def _error(p: Floats, y: Floats) -> float:
    return expected_calibration_error(p, y, _bins(p))


def _bins(p: Floats) -> int:
    return min(BINS, max(FEW_BINS, len(p) // IN_BIN))
