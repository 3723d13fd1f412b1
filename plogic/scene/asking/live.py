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
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import replace
from functools import partial
from typing import NamedTuple

from plogic.base.errors import InconsistentError, ProgramError, SituationError, UnknownPredicateError
from plogic.base.excluding import excluding
from plogic.facts.hypothesis import Hypothesis
from plogic.facts.sanity import check
from plogic.facts.situation import Situation
from plogic.inference.graph import Beliefs, FactorGraph
from plogic.inference.marginals import Remembered
from plogic.logic.served.engine import Answer, Limits, in_order
from plogic.scene.asking.how_many import count_asked, how_many
from plogic.scene.asking.relevant import restricted
from plogic.scene.factors.asked_formulas import Asked, literals
from plogic.scene.factors.goal_meaning import Meaning, meaning
from plogic.scene.factors.scene_graph import SceneGraph, scene_graph
from plogic.scene.text.program_text import added_to
from plogic.scene.worlds.blame import blaming, unsmoothed
from plogic.scene.worlds.ranked_worlds import Ranking, listed_worlds, ranking_of, with_joint_causes

TRIED = 2.0
"""Seconds in which it is said which evidence is impossible."""
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
        ranking = ranking_of(self.situation, scene, asked.beliefs, listed_worlds(self.situation, scene, n, end))
        return with_joint_causes(ranking, self.situation, scene) if scene.causes or scene.spoken else ranking

    def answers(self, goal: str = "present(H)", *, seconds: float | None = None) -> list[Answer]:
        """P(goal | evidence), every answer, most probable first, ties by text."""
        count = count_asked(self.situation, goal)
        if count is not None:
            return how_many(count, self._posed(seconds=seconds).scene, _solver(self._memory, seconds))
        meant = self._meaning(goal, ())
        scene, asked = self._posed(meant, seconds=seconds)
        return answers_of(meant, scene, asked)[0]

    def constraints(self, name: str) -> list[tuple[str, float]]:
        """P(constraint(N) | evidence) of every constraint of the author's that may speak of a hypothesis."""
        added = added_to(self.situation)
        if added is None or not any("constraint" in piece.text for piece in added.pieces()):
            return []
        with suppress(UnknownPredicateError):
            meant = self._meaning("constraint(N)", ())
            scene, asked = self._posed(meant)
            formulas = meant.formulas([key for _, key in meant.answers[0]], scene)
            told = zip((shown for shown, _ in meant.answers[0]), formulas, strict=True)
            place = scene.place[name][0]
            return [
                (shown, sum(asked.probability(formula)) / 2)
                for shown, formula in told
                if any(literal.variable == place for literal in literals(formula))
            ]
        return []

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

    def _posed(self, *goals: Meaning, seconds: float | None = None) -> _Posed:
        def by(given: Sequence[str], situation: Situation, *goals: Meaning) -> _Posed:
            spoken = [*(self._meaning("", (goal,)) for goal in given), *goals]
            return posed(situation, spoken, _solver(self._memory, seconds))

        with blaming(self.situation), _blaming_given(self.given, self.situation, by, seconds):
            return by(self.given, self.situation, *goals)


@contextmanager
def _blaming_given(
    given: Sequence[str],
    situation: Situation,
    pose: Callable[[Sequence[str], Situation], object],
    seconds: float | None,
) -> Iterator[None]:
    """Within it, say which evidence is impossible: one piece alone, or two that exclude each other."""
    try:
        yield
    except InconsistentError as error:

        def possible(some: Sequence[str], situation: Situation = situation) -> bool:
            try:
                pose(some, situation)
            except InconsistentError:
                return False
            return True

        pieces = tuple(dict.fromkeys(given))
        most = TRIED if seconds is None else min(TRIED, seconds)
        why = excluding(pieces, lambda some: not possible(some), str, most)
        hint = unsmoothed(situation, partial(possible, given))
        raise type(error)((f"{error}; {why}" if why else str(error)) + hint) from None


def _solver(memory: Remembered, seconds: float | None) -> Callable[[FactorGraph], Beliefs]:
    """Exact; or by a moment that is ``seconds`` from now, whatever is asked till then."""
    if seconds is None:
        return memory.beliefs
    end = time.monotonic() + seconds
    return lambda graph: memory.beliefs(graph, seconds=max(end - time.monotonic(), 0.0))


def posed(situation: Situation, spoken: Sequence[Meaning], solve: Callable[[FactorGraph], Beliefs]) -> _Posed:
    """The graph with what goals and evidence speak of, solved. Raises InconsistentError where nothing is possible."""
    scene = scene_graph(situation, spoken=spoken)
    return _Posed(scene, Asked(scene.graph, solve))


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
    counts = [count_asked(situation, goal) for goal in goals]
    others = [goal for goal, count in zip(goals, counts, strict=True) if count is None]
    solve = _solver(Remembered(), seconds)

    def pose(some: Sequence[str], situation: Situation, *goals: str) -> tuple[Meaning, _Posed]:
        meant = meaning(situation, goals, some, limits=limits)
        return meant, posed(situation, [meant], solve)

    with _blaming_given(given, situation, pose, seconds):
        meant, (scene, asked) = pose(given, situation, *others)
    found = iter(answers_of(meant, scene, asked) if others else ())
    return [next(found) if count is None else how_many(count, scene, solve) for count in counts]


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
