"""``plogic bench constancy``: 40 sequences with known objects, unknown ones and clutter.

What is called physical, and what noise, by views seen.

The data of known objects are taken away by the engine's own interpretation of each view, never by ground truth.
``--quick``: four sequences.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, NamedTuple

from benchmarks.constancy.explained import bodies_of, unexplained_of
from benchmarks.constancy.peers import epipolar
from benchmarks.constancy.scenes import VIEWS, constancy_kb, sequence
from benchmarks.constancy.score import called_of, is_one, score, whose
from benchmarks.constancy.table import ANGLELESS, CAPTION, COUNTS, ONE_LOOK, OURS, PEER, Tally, claims, rows
from benchmarks.shared.claims import report
from benchmarks.shared.processor import processor_seconds
from plogic.sequence.constancy.decide import unknown_objects
from plogic.sequence.views.panorama import hiding

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from benchmarks.constancy.scenes import Sequence
    from kb.clouds.cloud import KnowledgeBase
    from plogic.run.perceive import Perceiver
    from plogic.sequence.views.panorama import Body

SEQUENCES, QUICK_SEQUENCES = 40, 4


class Seen(NamedTuple):
    """A sequence, and what the engine made of each view.

    The ids of what it left unexplained, and the bodies that it accepted.
    """

    sequence: Sequence
    unexplained: Mapping[str, tuple[str, ...]]
    bodies: Mapping[str, list[Body]]


def run(
    *, seed: int, quick: bool, as_json: bool, say: Callable[[str], None], sequences: int | None = None
) -> tuple[str, bool]:
    """Run the benchmark; a line of progress a sequence on ``say``."""
    from plogic.run.perceive import Perceiver

    kb = constancy_kb(seed)
    perceiver = Perceiver(kb)
    count = sequences or (QUICK_SEQUENCES if quick else SEQUENCES)
    tally = Tally()
    for i in range(count):
        seen = perceived(perceiver, sequence(kb, SEQUENCES * seed + i))
        for views in COUNTS:
            judge(seen, views, kb, tally)
        say(_said(seen, SEQUENCES * seed + i))
    text, met = report("constancy", rows(tally), claims(tally), as_json=as_json)
    return (text if as_json else f"{CAPTION}\n\n{text}"), met


def perceived(perceiver: Perceiver, moved: Sequence) -> Seen:
    """Each view interpreted by itself."""
    from plogic.cycle.delta import Options

    documents = {view.id: perceiver(view.gamma, Options(reading="posterior")) for view in moved.views[:VIEWS]}
    unexplained = {name: unexplained_of(document) for name, document in documents.items()}
    return Seen(
        moved, unexplained, {view.id: bodies_of(perceiver.kb, view, documents[view.id]) for view in moved.views}
    )


def judge(seen: Seen, count: int, kb: KnowledgeBase, tally: Tally) -> None:
    """All sides on the first ``count`` views."""
    views = seen.sequence.views[:count]
    hidden = hiding(views, seen.bodies)
    start = processor_seconds()
    ours = unknown_objects(views, seen.unexplained, kb.rates, hidden)
    tally.add(OURS, count, score(seen.sequence, count, called_of(ours)), processor_seconds() - start)
    for feature in (feature for one in ours.unknown for feature in one.features):
        tally.forecast(count, feature.probability, right=is_one(whose(seen.sequence, feature.data)))
    one = unknown_objects(views, seen.unexplained, kb.rates, hidden, looks=1)
    tally.add(ONE_LOOK, count, score(seen.sequence, count, called_of(one)))
    angleless = unknown_objects(views, seen.unexplained, replace(kb.rates, sigma_angle=None), hidden)
    tally.add(ANGLELESS, count, score(seen.sequence, count, called_of(angleless)))
    tally.add(PEER, count, score(seen.sequence, count, epipolar(views, seen.unexplained, kb.rates)))


def _said(seen: Seen, seed: int) -> str:
    known = sum(seen.sequence.known)
    left = [len(seen.unexplained[view.id]) for view in seen.sequence.views]
    sizes = [len(view.gamma.appearances) for view in seen.sequence.views]
    return f"sequence {seed}: {known} known and {len(seen.sequence.known) - known} unknown bodies; unexplained {left} of {sizes}"
