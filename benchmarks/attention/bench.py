"""``plogic bench attention``: does the order in which types are tried save time (§5.3, §7.2.2)?

Of 100 types modelled by hand three are there, and of twenty learned types three. The cycle runs in the order of
attention and in the reversed one, from the votes on, for an index votes for all types at once; and both again with half
the time that the first took. ``--quick``: few scenes, and no learned types.
"""

from __future__ import annotations

from time import monotonic, process_time
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from benchmarks.attention.learned import learned_kb, pictures
from benchmarks.places.scenes import scene
from benchmarks.places.types import LOOKS, places_kb
from benchmarks.recognition.score import Found, tally
from benchmarks.shared.claims import Claim, report
from plogic.base.clock import Stopwatch
from plogic.cycle.delta import Options
from plogic.cycle.perception import attend, attended, perceive
from plogic.cycle.state import Cycle, Task, among
from plogic.match.gamma.data import data_of
from plogic.run.perceive import Perceiver

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Sequence

    from benchmarks.recognition.score import Truth
    from kb.clouds.cloud import KnowledgeBase
    from plogic.cycle.state import Attention
    from sensing.appearance import Gamma

SCENES, QUICK_SCENES = 30, 4
OF_ONE = 10
"""Scenes of a knowledge base of types by hand; then another is drawn."""
TYPES, THERE = 100, (3, 3)
VOCABULARIES = LOOKS, (30, 30), (100, 100)
"""Least and most appearance types of the knowledge bases by hand: the fewer, the less rank tells."""
BAR = 0.6
FOR_EVER = 1e9
"""Seconds."""
CAPTION = """\
Three objects, of 100 types modelled by hand (as of `bench places`, with at most so many looks) and of twenty learned ones. The cycle
runs in the order of attention and in the reversed one; seconds are of the processor, from the votes to the document. place: median place of what is
there in the order, the first is 1; by rank: the same if rank alone gave the order. same: scenes in which both orders come to the same objects at the
same places. in half: objects found where the cycle has half of the time (of the wall) that it took in the order of attention.
Where many looks are told apart votes leave so few types that there is little to order: nothing is claimed of these."""


class Run(NamedTuple):
    """One run of the cycle: its outcome; seconds of the processor and of the wall, from the votes to the document."""

    cycle: Cycle
    seconds: float
    wall: float


class Outcome(NamedTuple):
    """One scene: the runs in order and reversed, and again in half the time; places in the order, and by rank alone.

    ``found``: of the four runs, how many of the objects there.
    """

    runs: list[Run]
    found: list[int]
    there: int
    places: list[int]
    by_rank: list[int]

    @property
    def same(self) -> bool:
        """Whether both orders come to the same."""
        one, other = (run.cycle.accepted for run in self.runs[:2])
        return len(one) == len(other) and all(among(hypothesis, other) for hypothesis in one)


Case = tuple["Gamma", "tuple[Truth, ...]"]


def run(
    *,
    seed: int,
    quick: bool,
    as_json: bool,
    say: Callable[[str], None],
    scenes: int | None = None,
    types: int = TYPES,
    learn: Callable[[Callable[[str], None], int], KnowledgeBase | None] = learned_kb,
) -> tuple[str, bool]:
    """Run the benchmark; a line of progress a scene on ``say``.

    ``learn`` gives the knowledge base of learned types, None where there is none.
    """
    count = scenes or (QUICK_SCENES if quick else SCENES)
    rows = []
    for looks in VOCABULARIES:
        what = f"{types}, {looks[1]} looks"
        rows.append(
            _row(what, [one for each in _by_hand(count, types, looks, seed) for one in _told(*each, what, say)])
        )
    learned = None if quick else learn(say, seed)
    if learned is not None:
        outcomes = _told(Perceiver(learned), pictures(learned, count, seed), "learned", say)
        rows.append(_row(f"{len(learned.types)} learned", outcomes))
    claimed = [rows[0], *rows[len(VOCABULARIES) :]]
    text, met = report("attention", rows, [claim for row in claimed for claim in _claims(row)], as_json=as_json)
    return (text if as_json else f"{CAPTION}\n\n{text}"), met


def _by_hand(count: int, types: int, looks: tuple[int, int], seed: int) -> Iterator[tuple[Perceiver, list[Case]]]:
    for first in range(0, count, OF_ONE):
        kb = places_kb(types, 1000 * seed + first // OF_ONE, looks)
        some = range(first, min(first + OF_ONE, count))
        yield Perceiver(kb), [scene(kb, SCENES * seed + i, THERE) for i in some]


def _told(perceiver: Perceiver, cases: Sequence[Case], what: str, say: Callable[[str], None]) -> list[Outcome]:
    for kind in perceiver.models.kinds.values():
        kind.make_ready()
    outcomes = []
    for case in cases:
        outcomes.append(outcome_of(perceiver, *case))
        o = outcomes[-1]
        times = ", ".join(f"{run.seconds:.2f} s" for run in o.runs[:2])
        say(
            f"{what}, {len(outcomes)}/{len(cases)}: {o.found[:2]} of {o.there} in {times}; in half the time {o.found[2:]}"
        )
    return outcomes


def outcome_of(perceiver: Perceiver, gamma: Gamma, truths: Sequence[Truth]) -> Outcome:
    """One scene in both orders."""
    first = run_of(perceiver, gamma, 1)
    runs = [first, run_of(perceiver, gamma, -1), *(run_of(perceiver, gamma, way, 0.5 * first.wall) for way in (1, -1))]
    names = {kind.name for kind in perceiver.kb.types}
    tallies = [
        tally([Found(h.type, h.camera_from_object) for h in run.cycle.accepted], truths, gamma.camera, names)
        for run in runs
    ]
    types = [datum.type for datum in gamma.appearances]
    alone = sorted(attend(perceiver.models.values(), types, perceiver.kb), key=lambda row: (-row.rank, -row.excess))
    return Outcome(
        runs,
        [t.found + t.extra for t in tallies],
        len(truths),
        _places(first.cycle.attention, truths),
        _places(alone, truths),
    )


def _places(order: Sequence[Attention], truths: Sequence[Truth]) -> list[int]:
    names = [row.type for row in order]
    return [names.index(truth.type) + 1 for truth in truths]


def run_of(perceiver: Perceiver, gamma: Gamma, way: int, within: float | None = None) -> Run:
    """The cycle and its document; ``way`` −1: reversed; ``within`` seconds of the wall, from the votes on."""
    data = data_of(gamma.in_order().appearances, gamma.camera, perceiver.width)
    end = None if within is None else monotonic() + FOR_EVER
    task = Task(data, perceiver.kb, perceiver.models, perceiver.dv, end)
    order = attended(task)[::way]
    start, began = process_time(), monotonic()
    if within is not None:
        task.deadline.end = began + within
    cycle = perceive(task, order)
    perceiver.document(gamma, data, cycle, Options(), None, Stopwatch())
    return Run(cycle, process_time() - start, monotonic() - began)


def _row(what: str, outcomes: Sequence[Outcome]) -> dict[str, Any]:
    ordered, reverse = (np.array([o.runs[k].seconds for o in outcomes]) for k in range(2))
    found = np.sum([o.found for o in outcomes], axis=0).tolist()
    return {
        "types": what,
        "scenes": len(outcomes),
        "there": sum(o.there for o in outcomes),
        "place": float(np.median([place for o in outcomes for place in o.places])),
        "by rank": float(np.median([place for o in outcomes for place in o.by_rank])),
        "found": found[0],
        "reversed": found[1],
        "same": sum(o.same for o in outcomes),
        "s": round(float(ordered.sum()) / len(outcomes), 3),
        "reversed s": round(float(reverse.sum()) / len(outcomes), 3),
        "in half": found[2],
        "reversed in half": found[3],
    }


def _claims(row: dict[str, Any]) -> list[Claim]:
    what = row["types"]
    return [
        Claim(f"{what}: seconds in the order of attention over reversed", "<=", BAR, row["s"] / row["reversed s"]),
        Claim(f"{what}: share of scenes with the same answer", ">=", 1.0, row["same"] / row["scenes"]),
        Claim(
            f"{what}: more objects found in half the time than reversed",
            ">=",
            1.0,
            row["in half"] - row["reversed in half"],
        ),
    ]
