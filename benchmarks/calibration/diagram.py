"""A reliability diagram as plain SVG.

What was forecast against what came true, a panel a forecaster, on light and on dark pages.

Vocabulary: ``Panel("posterior", "ECE 0.02", p, y)``, one forecaster's forecasts (N,) and what came of them (N,).

A dot is a bin of equal mass; the bar through it is where the share that came true may lie (95 %, Wilson). Below, how
many forecasts there are in each tenth. The same input gives the same bytes.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING
from xml.sax.saxutils import escape

import numpy as np

from benchmarks.calibration.reliability import BINS, reliability

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    from numpy.typing import NDArray

SIDE, LEFT, TOP, APART = 300, 62, 76, 84
"""Pixels: a panel's side, the space left of the first and above, and between two."""
STRIP, GAP = 64, 62
"""Height of the counts below, and how far below they begin."""
TENTHS = 10
STYLE = """\
.page{fill:#ffffff}.text{fill:#1c1c1c}.faint{fill:#5f5f5f}.grid{stroke:#dddddd}.frame{stroke:#8a8a8a}.even{stroke:#8a8a8a}
.bar{stroke:#1f5fbf}.dot{fill:#1f5fbf;stroke:#ffffff}.count{fill:#9db9e3}
@media (prefers-color-scheme: dark){.page{fill:#14171c}.text{fill:#e8e8e8}.faint{fill:#a5a5a5}.grid{stroke:#30353d}.frame{stroke:#7c828c}
.even{stroke:#7c828c}.bar{stroke:#7fb0ff}.dot{fill:#7fb0ff;stroke:#14171c}.count{fill:#3d5a87}}"""


@dataclass(frozen=True, eq=False)
class Panel:
    """One forecaster: its name, a line of figures, and its forecasts with what came of them, (N,) each, N > 0."""

    title: str
    figures: str
    forecasts: NDArray[np.float64]
    outcomes: NDArray[np.float64]


def diagram(title: str, panels: Sequence[Panel], bins: int = BINS) -> str:
    """The panels side by side, as the text of an SVG file. Raises ValueError where forecasts are none."""
    width, height = LEFT + len(panels) * (SIDE + APART) - APART + 24, TOP + SIDE + GAP + STRIP + 44
    return "\n".join(
        [
            *_head(title, width, height),
            *(line for i, panel in enumerate(panels) for line in _panel(panel, i, bins)),
            "</svg>",
            "",
        ]
    )


def _head(title: str, width: int, height: int) -> Iterator[str]:
    named = 'font-family="sans-serif" font-size="13" role="img" aria-labelledby="t"'
    yield f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" {named}>'
    yield f'<title id="t">{escape(title)}</title>'
    yield f"<style>\n{STYLE}\n</style>"
    yield f'<rect class="page" width="{width}" height="{height}"/>'
    yield _text(LEFT, 24, title, "text", size=15)


def _panel(panel: Panel, number: int, bins: int) -> Iterator[str]:
    left, bottom = LEFT + number * (SIDE + APART), TOP + SIDE
    yield f'<g transform="translate({left} 0)">'
    yield _text(0, TOP - 26, panel.title, "text", weight="bold")
    yield _text(0, TOP - 9, panel.figures, "faint", size=12)
    yield from _axes(bottom)
    yield f'<path class="even" stroke-dasharray="5 4" d="M0 {bottom}L{SIDE} {TOP}"/>'
    yield from _dots(panel, bottom, bins)
    yield from _counts(panel, bottom + GAP)
    yield "</g>"


def _axes(bottom: int) -> Iterator[str]:
    for fifth in range(6):
        along, label = SIDE * fifth // 5, f"{fifth / 5:.1f}"
        yield f'<path class="grid" d="M{along} {TOP}V{bottom}M0 {bottom - along}H{SIDE}"/>'
        yield _text(along, bottom + 17, label, "faint", anchor="middle", size=12)
        yield _text(-7, bottom - along + 4, label, "faint", anchor="end", size=12)
    yield f'<rect class="frame" x="0" y="{TOP}" width="{SIDE}" height="{SIDE}" fill="none"/>'
    yield _text(SIDE // 2, bottom + 35, "probability that was given", "text", anchor="middle")
    middle = TOP + SIDE // 2
    yield f'<text class="text" transform="translate(-40 {middle}) rotate(-90)" text-anchor="middle">share that is true</text>'


def _dots(panel: Panel, bottom: int, bins: int) -> Iterator[str]:
    table = reliability(panel.forecasts, panel.outcomes, bins)
    for b in table:
        low, high = b.interval
        yield f'<path class="bar" stroke-width="1.6" d="M{SIDE * b.forecast:.1f} {bottom - SIDE * low:.1f}V{bottom - SIDE * high:.1f}"/>'
    for b in table:
        said = f"{b.count} from {b.low:.3f} to {b.high:.3f}, {b.forecast:.3f} on the average: {b.true:.3f} true"
        place = f'cx="{SIDE * b.forecast:.1f}" cy="{bottom - SIDE * b.true:.1f}"'
        yield f'<circle class="dot" {place} r="5" stroke-width="1.2"><title>{said}</title></circle>'


def _counts(panel: Panel, top: int) -> Iterator[str]:
    counts = np.histogram(panel.forecasts, bins=TENTHS, range=(0.0, 1.0))[0].tolist()
    wide, bottom = SIDE / TENTHS, top + STRIP
    for i, count in enumerate(counts):
        tall = (STRIP - 14) * count / max(counts)
        yield f'<rect class="count" x="{wide * i + 1:.1f}" y="{bottom - tall:.1f}" width="{wide - 2:.1f}" height="{tall:.1f}"/>'
        yield _text(wide * (i + 0.5), bottom - tall - 3, str(count), "faint", anchor="middle", size=11)
    yield f'<path class="frame" d="M0 {bottom}H{SIDE}"/>'
    yield _text(SIDE // 2, bottom + 18, f"how many, of {len(panel.forecasts)}", "text", anchor="middle")


def _text(
    x: float, y: float, text: str, style: str, *, anchor: str = "start", size: int = 13, weight: str = "normal"
) -> str:
    heavy = "" if weight == "normal" else f' font-weight="{weight}"'
    return f'<text class="{style}" x="{x:g}" y="{y:g}" text-anchor="{anchor}" font-size="{size}"{heavy}>{escape(text)}</text>'
