"""``plogic bench clutter``: one object of up to a thousand types among a thousand appearances, beside peers.

A third of the trials are of types made of what was learned from the YCB meshes; where these are not there those trials
are left out, and the table says so. ``--quick``: ten trials a row, peers asked in three of them, one row less.
"""

from __future__ import annotations

import tempfile
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from benchmarks.clutter.near import NEAR_CAPTION, near, near_rows
from benchmarks.clutter.near import TRIALS as NEAR_TRIALS
from benchmarks.clutter.peers import there
from benchmarks.clutter.scenes import PLAN, Case, Trial, trial
from benchmarks.clutter.table import ACCEPTED, CAPTION, OURS, TOLD, Outcome, claims, judged, rows
from benchmarks.clutter.told import told
from benchmarks.clutter.types import learned_types, random_types, with_learned
from benchmarks.recognition.score import Found
from benchmarks.shared.claims import report
from benchmarks.shared.processor import processor_seconds
from plogic.base.errors import InputError

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from benchmarks.clutter.near import Refined
    from benchmarks.clutter.peers import Peer
    from kb.clouds.cloud import KnowledgeBase, ObjectType
    from plogic.run.perceive import Perceiver
    from sensing.appearance import Gamma

TRIALS, QUICK_TRIALS = 200, 10
LEARNED_EVERY = 3
"""Every third trial, from the first on, is of a learned type."""
PEER_TRIALS, QUICK_PEER_TRIALS = 10, 3
"""Trials of a row in which peers are asked."""
SEEN_FROM = float(np.radians(80.0))
"""Half angle of the lobes, the least of learned ones: 'about 20 of its own' of 100 features, 60 % detected."""
NEAR_CASES = PLAN[0], PLAN[2]
"""Of 100 types and 300 appearance types, easy and hard."""
BUDGET = 2.0
"""Seconds that a peer may take a trial: twice as many as we promise for ourselves."""


@dataclass(frozen=True)
class Plan:
    """Which cases, how many trials each, in how many of them peers are asked, for how many seconds.

    In ``near`` ones refiners are asked, too.
    """

    cases: Sequence[Case] = PLAN
    trials: int = TRIALS
    peer_trials: int = PEER_TRIALS
    budget: float = BUDGET
    near: Sequence[Case] = NEAR_CASES


QUICK = Plan(PLAN[:-1], QUICK_TRIALS, QUICK_PEER_TRIALS)
"""Of the cases with most types one will do: they take longest to make ready."""


@dataclass(frozen=True, eq=False)
class Series:
    """The trials of a case: in one knowledge base, of ``learned`` types and of the ``others``."""

    case: Case
    kb: KnowledgeBase
    learned: Sequence[ObjectType]
    others: Sequence[ObjectType]

    def numbers(self, trials: int) -> list[int]:
        """Of so many trials those that there can be."""
        return [number for number in range(trials) if self.learned or not of_learned(number)]

    def trial(self, seed: int, number: int) -> Trial:
        """The trial of this number: the same type at the same pose whatever the detector."""
        kinds = self.learned if of_learned(number) else self.others
        rng = np.random.default_rng([seed, self.case.types, self.case.appearance_types, 1 + number])
        return trial(kinds[int(rng.integers(len(kinds)))], self.kb, self.case.detector, rng, self.case.appearances)


def of_learned(number: int) -> bool:
    """Whether the trial of this number is of a learned type."""
    return number % LEARNED_EVERY == 0


def run(
    *,
    seed: int,
    limit: float,
    quick: bool,
    as_json: bool,
    say: Callable[[str], None],
    learn: Callable[[Callable[[str], None], int], KnowledgeBase | None] | None = None,
    plan: Plan | None = None,
) -> tuple[str, bool]:
    """Run the benchmark; a line of progress a trial on ``say``. ``limit``: most seconds that a peer may take a trial.

    ``learn`` gives the knowledge base of learned types (by default that of the YCB meshes), None where there is none.
    """  # fmt: skip
    plan = plan or (QUICK if quick else Plan())
    learned = (learn or learned_kb)(say, seed)
    peers, seconds = there(say), min(limit, plan.budget)
    outcomes: list[Outcome] = []
    refined: list[Refined] = []
    builds: dict[Case, float] = {}
    for case in plan.cases:
        series = series_of(case, learned, seed)
        perceiver, builds[case] = _built(series.kb)
        say(f"{case}: made ready in {builds[case]:.1f} s")
        outcomes += _of_case(series, perceiver, seed, peers, replace(plan, budget=seconds), say)
        refined += _near(series, perceiver, seed, plan, say)
    left_out = "" if learned is not None else "\nThere are no learned types: their trials are left out."
    more = {"near": near_rows(refined)} if refined else {}
    text, met = report("clutter", rows(outcomes, builds), claims(outcomes), as_json=as_json, more=more)
    return (text if as_json else f"{CAPTION}\n{NEAR_CAPTION}{left_out}\n\n{text}"), met


def _of_case(
    series: Series, perceiver: Perceiver, seed: int, peers: Sequence[Peer], plan: Plan, say: Callable[[str], None]
) -> list[Outcome]:
    """The outcomes of a case's trials."""
    outcomes: list[Outcome] = []
    for number in series.numbers(plan.trials):
        more = answered(series, perceiver, (seed, number), peers if number < plan.peer_trials else (), plan.budget)
        say(_said(number, more))
        outcomes += more
    return outcomes


def _near(series: Series, perceiver: Perceiver, seed: int, plan: Plan, say: Callable[[str], None]) -> list[Refined]:
    """What refiners come to from near poses, in the first trials of the cases that they are asked in."""
    outcomes: list[Refined] = []
    for number in series.numbers(min(plan.trials, NEAR_TRIALS)) if series.case in plan.near else ():
        outcomes += near(series.case, series.trial(seed, number), perceiver, np.random.default_rng([seed, number]))
        say(f"trial {number}: refined from near poses")
    return outcomes


def learned_kb(say: Callable[[str], None], seed: int = 0) -> KnowledgeBase | None:
    """The ten YCB types, learned as ``plogic bench recognition`` learns them; None where they cannot be."""
    from benchmarks.recognition.kb import learn_into
    from benchmarks.recognition.scenes import ycb_meshes
    from kb.files.read import read_kb

    with tempfile.TemporaryDirectory(prefix="plogic-clutter-") as folder:
        try:
            learn_into(Path(folder) / "kb", ycb_meshes(), say, seed)
        except InputError as error:
            say(f"no trials of learned types: {error}")
            return None
        return read_kb(Path(folder) / "kb")


def series_of(case: Case, learned: KnowledgeBase | None, seed: int) -> Series:
    """Random types, and learned ones, if there are any, that stand for some of them."""
    rng = np.random.default_rng([seed, case.types, case.appearance_types])
    kb = random_types(case.types, case.features, case.appearance_types, rng, case.detector, case.appearances, SEEN_FROM)
    kinds = () if learned is None else learned_types(learned, case.features, case.appearance_types, SEEN_FROM)
    kb = with_learned(kb, kinds, case.detector, case.appearances)
    return Series(case, kb, kinds, kb.types[len(kinds) :])


def answered(
    series: Series, perceiver: Perceiver, which: tuple[int, int], peers: Sequence[Peer], seconds: float
) -> list[Outcome]:
    """The trial of ``which`` seed and number.

    Ours first, then who was told, then the peers, who may take so many seconds, on the same Γ.
    """
    posed = series.trial(*which)
    asked: dict[str, Callable[[], list[Found]]] = {TOLD: lambda: told(series.kb, posed)}
    for peer in peers:
        asked[f"{peer.name} {seconds:g} s"] = partial(_one, peer, seconds, series.kb, posed.gamma)
    start = processor_seconds()
    accepted, others = ours(perceiver, posed.gamma)
    taken = processor_seconds() - start
    answers = {OURS: ((accepted or others)[:1], taken), ACCEPTED: (accepted, taken)}
    for who, ask in asked.items():
        start = processor_seconds()
        answers[who] = ask(), processor_seconds() - start
    learned, own = of_learned(which[1]), len(posed.causes)
    return [
        Outcome(series.case, who, learned, own, *judged(found, posed.truth), taken)
        for who, (found, taken) in answers.items()
    ]


def ours(perceiver: Perceiver, gamma: Gamma) -> tuple[list[Found], list[Found]]:
    """What we accept, and what else we thought of, each the best first."""
    from plogic.base.clock import Stopwatch
    from plogic.cycle.delta import Options

    delta, rejected, _ = perceiver.delta(gamma, Options(reading="posterior"), Stopwatch())
    beliefs = sorted([*delta.beliefs.values(), *rejected], key=lambda b: -b.surplus)
    found = [(b.status == "accepted", Found(b.type, b.camera_from_object)) for b in beliefs]
    return [one for accepted, one in found if accepted], [one for accepted, one in found if not accepted]


def _one(peer: Peer, seconds: float, kb: KnowledgeBase, gamma: Gamma) -> list[Found]:
    answer = peer.ask(kb, gamma, seconds)
    return [] if answer is None else [Found(*answer)]


def _built(kb: KnowledgeBase) -> tuple[Perceiver, float]:
    from plogic.run.perceive import Perceiver

    start = processor_seconds()
    return Perceiver(kb), processor_seconds() - start


def _said(number: int, outcomes: Sequence[Outcome]) -> str:
    verdicts = {(False, False): "wrong", (True, False): "type right", (True, True): "right"}
    rest = "; ".join(f"{o.who} {verdicts[o.identity, o.pose]} in {o.seconds:.2f} s" for o in outcomes)
    return f"trial {number}, {outcomes[0].own} of its own: {rest}"
