r"""A scene that one can observe and retract in: what is touched is solved anew, what is not stays.

>>> scene = LiveScene(situation)
>>> scene.marginals()["h1"]
(0.97, 0.97)
>>> scene.observe("\\+ noise(a3)")
>>> scene.answers("cause(a3, H, F)")
>>> scene.unobserve()

The same questions as ``plogic.scene.asking.query.answers`` puts to the program text, with the same answers (tested);
what speaks of choices that the graph has summed out is refused (OutsideError), and is for the text.
"""

import time
from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace
from typing import NamedTuple

from plogic.base.errors import ProgramError, SituationError
from plogic.facts.hypothesis import Hypothesis
from plogic.facts.sanity import check
from plogic.facts.situation import Situation
from plogic.inference.gates import Literal, observed, with_formulas
from plogic.inference.graph import Beliefs, FactorGraph
from plogic.inference.marginals import Remembered
from plogic.inference.ranked import best
from plogic.logic.served.engine import Answer, Limits, in_order
from plogic.scene.asking.relevant import restricted
from plogic.scene.factors.asked_formulas import Asked
from plogic.scene.factors.goal_meaning import Meaning, meaning
from plogic.scene.factors.scene_graph import SceneGraph, scene_graph
from plogic.scene.worlds.ranked_worlds import Ranking, listed_worlds, ranking_of

Interval = tuple[float, float]
Pairs = frozenset[tuple[str, str]]


class _Posed(NamedTuple):
    """A scene's graph with its evidence, solved."""

    scene: SceneGraph
    asked: Asked


class LiveScene:
    """``given``: the evidence, in the order in which it came.

    ``solved``: how many pieces of graphs had to be solved so far.

    Every question takes ``seconds``, after which (grounding not counted) it answers in intervals that contain the exact
    values.
    """

    def __init__(self, situation: Situation, *, limits: Limits | None = None) -> None:
        check(situation)
        self.situation = situation
        self.given: tuple[str, ...] = ()
        self._limits = limits
        self._memory = Remembered()
        self._meanings: dict[str, Meaning] = {}

    @property
    def solved(self) -> int:
        """Pieces that were solved, and not remembered."""
        return self._memory.solved

    def observe(self, goal: str, *, seconds: float | None = None) -> None:
        """Add evidence: there is a substitution for which the goal holds.

        Raises InconsistentError, and then nothing has changed.
        """
        self._become(self.situation, (*self.given, goal), self._meanings, seconds)

    def unobserve(self, goal: str | None = None) -> None:
        """Take evidence back, as it was written; without a goal, all of it."""
        if goal is not None and goal not in self.given:
            raise ProgramError(f"{goal} was not observed", file="goal")
        last = 0 if goal is None else len(self.given) - 1 - self.given[::-1].index(goal)
        self.given = () if goal is None else (*self.given[:last], *self.given[last + 1 :])

    def add(
        self,
        hypothesis: Hypothesis,
        *,
        overlaps: Pairs = frozenset(),
        rivals: Pairs = frozenset(),
        exclusive: Pairs = frozenset(),
    ) -> None:
        """One more hypothesis, with its pairs; raises SituationError, and then nothing has changed."""
        s = self.situation
        self._become(
            replace(
                s,
                hypotheses=(*s.hypotheses, hypothesis),
                overlaps=s.overlaps | overlaps,
                rivals=s.rivals | rivals | exclusive,
                exclusive=s.exclusive | exclusive,
            ),
            self.given,
            {},
        )

    def remove(self, name: str) -> None:
        """One hypothesis fewer: what speaks of it in pairs, relations and occlusion goes too."""
        if all(h.id != name for h in self.situation.hypotheses):
            raise SituationError(f"hypothesis {name!r} is unknown")
        self._become(without(self.situation, name), self.given, {})

    def marginals(self, *, seconds: float | None = None) -> dict[str, Interval]:
        """P(present(H) | evidence)."""
        scene, asked = self._posed(seconds=seconds)
        low, high = asked.beliefs.low, asked.beliefs.high
        return {
            h.id: (float(low[v][s]), float(high[v][s]))
            for h in self.situation.hypotheses
            for v, s in [scene.place[h.id]]
        }

    def worlds(self, n: int = 10, *, seconds: float | None = None) -> Ranking:
        """The ``n`` most probable worlds given the evidence, each with its causes."""
        end = None if seconds is None else time.monotonic() + seconds
        scene, asked = self._posed(seconds=None if seconds is None else seconds / 2)
        held = replace(scene, graph=asked.graph)
        ranking = ranking_of(self.situation, held, asked.beliefs, listed_worlds(self.situation, held, n, end))
        if not scene.causes:
            return ranking
        return replace(
            ranking, worlds=tuple(replace(w, causes={**w.causes, **_causes(held, w.present)}) for w in ranking.worlds)
        )

    def answers(self, goal: str = "present(H)", *, seconds: float | None = None) -> list[Answer]:
        """P(goal | evidence), every answer, most probable first, ties by text."""
        meant = self._meaning(goal, ())
        scene, asked = self._posed(meant.appearances, seconds)
        return answers_of(meant, scene, asked)[0]

    def _become(
        self,
        situation: Situation,
        given: tuple[str, ...],
        meanings: dict[str, Meaning],
        seconds: float | None = None,
    ) -> None:
        """Take another situation or other evidence, if some world is possible then; else nothing changes."""
        check(situation)
        before = self.situation, self.given, self._meanings
        self.situation, self.given, self._meanings = situation, given, meanings
        try:
            self._posed(seconds=seconds)
        except BaseException:
            self.situation, self.given, self._meanings = before
            raise

    def _meaning(self, goal: str, given: Sequence[str]) -> Meaning:
        key = "given " * len(given) + (given[0] if given else goal)
        if key not in self._meanings:
            goals = () if given else (goal,)
            self._meanings[key] = meaning(self.situation, goals, given, limits=self._limits)
        return self._meanings[key]

    def _posed(self, explicit: Iterable[str] = (), seconds: float | None = None) -> _Posed:
        return posed(
            self.situation,
            [self._meaning("", (goal,)) for goal in self.given],
            explicit,
            _solver(self._memory, seconds),
        )


def _solver(memory: Remembered, seconds: float | None) -> Callable[[FactorGraph], Beliefs]:
    """Exact; or by a moment that is ``seconds`` from now, whatever is asked till then."""
    if seconds is None:
        return memory.beliefs
    end = time.monotonic() + seconds
    return lambda graph: memory.beliefs(graph, seconds=max(end - time.monotonic(), 0.0))


def posed(
    situation: Situation, given: Sequence[Meaning], explicit: Iterable[str], solve: Callable[[FactorGraph], Beliefs]
) -> _Posed:
    """The graph with the causes in ``explicit``, and what the evidence says.

    Raises InconsistentError where that is impossible.
    """
    scene = scene_graph(situation, explicit=frozenset(explicit).union(*(m.appearances for m in given)))
    formulas = [formula for m in given for formula in m.formulas(m.given, scene)]
    graph, literals = with_formulas(scene.graph, formulas)
    return _Posed(scene, Asked(observed(graph, literals), solve))


def answers_of(meant: Meaning, scene: SceneGraph, asked: Asked) -> list[list[Answer]]:
    """Of each goal: what is ground as it was asked, and of substitutions those that are possible."""
    keys = list(dict.fromkeys(key for found in meant.answers for _, key in found))
    chances = {key: asked.probability(formula) for key, formula in zip(keys, meant.formulas(keys, scene), strict=True)}
    return [
        in_order((shown, *chances[key]) for shown, key in found if single or chances[key][1] > 0)
        for found, single in zip(meant.answers, meant.single, strict=True)
    ]


def scene_answers(
    situation: Situation,
    goals: Sequence[str],
    given: Sequence[str] = (),
    *,
    limits: Limits | None = None,
    seconds: float | None = None,
) -> list[list[Answer]]:
    """P(goal | evidence) for each goal, as ``plogic.logic.served.engine.run`` on the program text gives it.

    Raises OutsideError too.

    With ``seconds`` (which the grounding, under ``limits``, does not count against) the answers may be intervals.
    """
    check(situation)
    meant = meaning(situation, goals, given, limits=limits)
    scene, asked = posed(situation, [meant], (), _solver(Remembered(), seconds))
    return answers_of(meant, scene, asked)


def without(situation: Situation, name: str) -> Situation:
    """The situation without one hypothesis."""
    part = restricted(situation, {h.id for h in situation.hypotheses} - {name})
    return replace(
        part,
        hypotheses=tuple(
            replace(
                h, features=tuple(replace(f, hidden_by=tuple(g for g in f.hidden_by if g != name)) for f in h.features)
            )
            for h in part.hypotheses
        ),
    )


def _causes(held: SceneGraph, present: Sequence[str]) -> dict[str, str]:
    """The most probable joint causes, in this world and given the evidence, of the appearances in the evidence."""
    states = dict.fromkeys(range(len(held.variables)), 0) | dict(held.place[name] for name in present)
    (_, found), *_ = best(observed(held.graph, [Literal(v, frozenset({s})) for v, s in states.items()]), 1)
    return {name: "/".join(cause.states[found[cause.variable]]) for name, cause in held.causes.items()}
