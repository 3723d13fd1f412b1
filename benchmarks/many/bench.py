"""``plogic bench many``: scenes of five to ten objects, partly occluded, of fifty types and more, beside a peer.

Half of the types are polyhedra, half are made of what was learned from the YCB meshes; where these are not there all
are polyhedra, and the text says so. ``--quick``: few scenes.
"""

from __future__ import annotations

from dataclasses import dataclass
from importlib.util import find_spec
from typing import TYPE_CHECKING

from benchmarks.clutter.bench import learned_kb, ours
from benchmarks.clutter.scenes import Trial
from benchmarks.clutter.told import told
from benchmarks.many.placing import CROWD
from benchmarks.many.ransac import LEAST_INLIERS, greedy, kept
from benchmarks.many.scenes import scene
from benchmarks.many.score import deepest, verdict
from benchmarks.many.table import CAPTION, CROWDED, OURS, TOLD, Answer, best_least, claims, rows, totals
from benchmarks.many.types import many_kb
from benchmarks.shared.claims import report
from benchmarks.shared.processor import processor_seconds

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from benchmarks.many.scenes import Scene
    from benchmarks.recognition.peer import Candidate
    from benchmarks.recognition.score import Found
    from kb.clouds.cloud import KnowledgeBase
    from plogic.run.perceive import Perceiver

SCENES, QUICK_SCENES = 100, 5
CROWDS, QUICK_CROWDS = 20, 1
"""Scenes of more objects, which are asked of us alone, and claim nothing."""


@dataclass(frozen=True)
class Case:
    """One scene: ours and who was told; what the peer came to, in how many seconds, None where it is not installed."""

    scene: Scene
    ours: Answer
    told: Answer
    peer: tuple[Sequence[Candidate], float] | None


def run(
    *,
    seed: int,
    limit: float,
    quick: bool,
    as_json: bool,
    say: Callable[[str], None],
    learn: Callable[[Callable[[str], None], int], KnowledgeBase | None] = learned_kb,
    scenes: int | None = None,
) -> tuple[str, bool]:
    """Run the benchmark; a line of progress a scene on ``say``. ``limit``: seconds that the peer may take a scene.

    ``learn`` gives the knowledge base of learned types (by default that of the YCB meshes), None where there is none.
    """
    from plogic.run.perceive import Perceiver

    learned = learn(say, seed)
    kb = many_kb(learned, seed)
    perceiver = Perceiver(kb)
    count = scenes or (QUICK_SCENES if quick else SCENES)
    peer = find_spec("poselib") is not None
    if not peer:
        say("peer: left out, for the package poselib is not installed")
    cases = []
    for i in range(count):
        cases.append(case(perceiver, SCENES * seed + i, limit if peer else None))
        say(f"scene {_told_of(SCENES * seed + i, cases[-1].ours)}")
    crowds = []
    for i in range(QUICK_CROWDS if quick or scenes else CROWDS):
        crowds.append(_ours(perceiver, scene(kb, CROWDS * seed + i, CROWD)))
        say(f"crowd {_told_of(CROWDS * seed + i, crowds[-1])}")
    return _judgement(cases, crowds, kb, learned, as_json=as_json)


def case(perceiver: Perceiver, seed: int, limit: float | None) -> Case:
    """The scene of a seed.

    Ours first, then who was told, then the peer within ``limit`` seconds, None to leave it out.
    """
    posed, kb = scene(perceiver.kb, seed), perceiver.kb
    mine = _ours(perceiver, posed)
    ceiling = _answer(posed, kb, lambda: all_told(kb, posed))
    if limit is None:
        return Case(posed, mine, ceiling, None)
    start = processor_seconds()
    candidates = greedy(kb, posed.gamma, limit)
    return Case(posed, mine, ceiling, (candidates, processor_seconds() - start))


def all_told(kb: KnowledgeBase, posed: Scene) -> list[Found]:
    """The ceiling: the true poses, each refined on its own data."""
    found: list[Found] = []
    for i, truth in enumerate(posed.truths):
        found += told(
            kb,
            Trial(posed.gamma, truth, {name: feature for name, (whose, feature) in posed.causes.items() if whose == i}),
        )
    return found


def _ours(perceiver: Perceiver, posed: Scene) -> Answer:
    return _answer(posed, perceiver.kb, lambda: ours(perceiver, posed.gamma)[0])


def _answer(posed: Scene, kb: KnowledgeBase, ask: Callable[[], Sequence[Found]]) -> Answer:
    start = processor_seconds()
    found = ask()
    taken = processor_seconds() - start
    return Answer(verdict(found, posed.truths), taken, deepest(found, kb))


def _judgement(
    cases: Sequence[Case], crowds: Sequence[Answer], kb: KnowledgeBase, learned: KnowledgeBase | None, *, as_json: bool
) -> tuple[str, bool]:
    """The table or the document, and whether every claim was met."""
    mine, others = totals([c.ours for c in cases]), {TOLD: totals([c.told for c in cases])}
    if any(c.peer for c in cases):
        least = best_least({least: totals(_peers(cases, least)) for least in LEAST_INLIERS})
        others[f"peer at {least}"] = totals(_peers(cases, least, kb))
    others[CROWDED] = totals(crowds)
    polyhedral = {kind.name for kind in kb.types if kind.name.startswith("p") and kind.name[1:].isdigit()}
    text, met = report("many", rows(mine, others, lambda name: name not in polyhedral), claims(mine), as_json=as_json)
    left_out = "" if learned is not None else "\nThere are no learned types: all are polyhedra."
    return (text if as_json else f"{CAPTION}{left_out}\n\n{text}"), met


def _peers(cases: Sequence[Case], least: int, kb: KnowledgeBase | None = None) -> list[Answer]:
    """What the peer accepts with so many inliers or more.

    With Σ, how far it reaches into each other too, which takes longer to tell.
    """
    found = [(c, kept(c.peer[0], least), c.peer[1]) for c in cases if c.peer]
    return [
        Answer(verdict(some, c.scene.truths), seconds, deepest(some, kb) if kb else 0.0) for c, some, seconds in found
    ]


def _told_of(seed: int, mine: Answer) -> str:
    v = mine.verdict
    found = sum(s.turned is not None for s in v.seen)
    return f"{seed}: {OURS} {found} of {len(v.seen)}, {v.accepted - v.right} of {v.accepted} wrong, in {mine.seconds:.2f} s"
