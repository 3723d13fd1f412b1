"""``plogic bench places``: types modelled by hand that have places alone, no angles: twelve of them, and fifty.

``--quick``: few scenes. The time is that of the search, from Γ to Δi.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from benchmarks.clutter.scenes import CAMERA
from benchmarks.places.scenes import scene
from benchmarks.places.types import places_kb
from benchmarks.recognition.score import Found, Tally, tally
from benchmarks.shared.claims import Claim, report
from benchmarks.shared.processor import processor_seconds

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from plogic.run.perceive import Perceiver

SCENES, QUICK_SCENES = 60, 6
SIZES = 12, 50
"""Types of the knowledge bases."""
OF_ONE = 10
"""Scenes of a knowledge base; then another is drawn."""
IDENTITY, POSE, MEDIAN, MOST = 0.97, 0.95, 1.0, 2.0
SLOWER = 2.0
"""How much longer the search may take with the most types."""
CAPTION = """\
Scenes of one to four objects, of 12 types and of 50 that are modelled by hand, without angles, 14 to 40 features each, 40 to 80 appearances, 15 %
missed, at least 25 % clutter, one pixel of noise. A scene in which an object at least half visible has fewer than five data is drawn again.
there: objects at least half visible; found: those that an accepted object of their type stands for; posed: within 5 degrees and 5 % of the
distance, up to stated symmetries; false: accepted objects that stand for none. Seconds are of the processor, from the data to what is accepted."""


class Outcome(NamedTuple):
    """One scene: its counts, and the processor seconds of the search."""

    tally: Tally
    seconds: float


def run(
    *,
    seed: int,
    quick: bool,
    as_json: bool,
    say: Callable[[str], None],
    scenes: int | None = None,
    sizes: Sequence[int] = SIZES,
) -> tuple[str, bool]:
    """Run the benchmark; a line of progress a scene on ``say``; ``sizes``: numbers of types."""
    count = scenes or (QUICK_SCENES if quick else SCENES)
    found = {size: [*_of_size(size, count, seed, say)] for size in sizes}
    rows = [_row(size, outcomes) for size, outcomes in found.items()]
    text, met = report("places", rows, _claims(rows), as_json=as_json)
    return (text if as_json else f"{CAPTION}\n\n{text}"), met


def _of_size(size: int, count: int, seed: int, say: Callable[[str], None]) -> list[Outcome]:
    from plogic.run.perceive import Perceiver

    outcomes = []
    for i in range(count):
        if i % OF_ONE == 0:
            perceiver = Perceiver(places_kb(size, 1000 * seed + i // OF_ONE))
        outcomes.append(one_scene(perceiver, SCENES * seed + i))
        t, seconds = outcomes[-1]
        say(f"{size} types, {i + 1}/{count}: {t.found} of {t.there}, {t.posed} posed, {t.false} false, {seconds:.2f} s")
    return outcomes


def one_scene(perceiver: Perceiver, seed: int) -> Outcome:
    """The scene of a seed, searched, and compared with the truth."""
    from plogic.base.clock import Stopwatch
    from plogic.cycle.delta import Options

    gamma, truths = scene(perceiver.kb, seed)
    start = processor_seconds()
    _, cycle = perceiver.cycle(gamma, Options(), Stopwatch())
    seconds = processor_seconds() - start
    found = [Found(one.type, one.camera_from_object) for one in cycle.accepted]
    return Outcome(tally(found, truths, CAMERA, {kind.name for kind in perceiver.kb.types}), seconds)


def _row(size: int, outcomes: Sequence[Outcome]) -> dict[str, Any]:
    whole, seconds = sum((o.tally for o in outcomes), Tally()), [o.seconds for o in outcomes]
    return {
        "types": size,
        "scenes": len(outcomes),
        "there": whole.there,
        "found": whole.found,
        "posed": whole.posed,
        "false": whole.false,
        "median s": round(float(np.median(seconds)), 3),
        "95 % s": round(float(np.percentile(seconds, 95)), 3),
    }


def _claims(rows: Sequence[dict[str, Any]]) -> list[Claim]:
    claims = []
    for row in rows:
        slower = 1.0 if row["types"] == SIZES[0] else SLOWER
        there = max(1, row["there"])
        claims += [
            Claim(f"{row['types']} types: seconds of search, median", "<=", slower * MEDIAN, row["median s"]),
            Claim(f"{row['types']} types: seconds of search, 95th percentile", "<=", slower * MOST, row["95 % s"]),
            Claim(f"{row['types']} types: at least half visible, found", ">=", IDENTITY, row["found"] / there),
            Claim(
                f"{row['types']} types: at least half visible, found and posed right", ">=", POSE, row["posed"] / there
            ),
        ]
    return claims
