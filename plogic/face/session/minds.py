"""What answers a session: of a scene and of a program the same questions, each put to what is quickest there.

The observations come with every question, sorted, so that nothing depends on when they were made. ``ranked`` gives the
worlds of either without a session.
"""

import math
import time
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from geometry.digits import whole
from plogic.base.errors import InputError, OutsideError
from plogic.face.session.results import World, Worlds
from plogic.facts.situation import Situation
from plogic.facts.vocabulary import entries
from plogic.logic.safety.atoms import SPELLINGS, quoted
from plogic.logic.served.engine import (
    Answer,
    Limits,
    Process,
    Text,
    ask,
    request_of,
    through,
)
from plogic.logic.served.outline import Outline, Predicate, outline_of, outline_request
from plogic.logic.served.program_worlds import ProgramRanking, program_worlds
from plogic.scene.asking.explanations import Account, explain
from plogic.scene.asking.query import Subject, answers, stopped_of, subject_text
from plogic.scene.readings.unfinished import proved

if TYPE_CHECKING:
    from plogic.scene.asking.live import LiveScene
    from plogic.scene.worlds.ranked_worlds import Ranking

DIRECTIVES = {"query", "evidence"}
"""Predicates that say what is asked, and that nobody asks for."""
LAYER = "% ==== ("
"""How a layer of the program text begins."""


class Asked:
    """What scenes and programs have in common: a process that stays, and how to query and explain.

    Every method raises as ``plogic.scene.asking.query.answers`` does.
    """

    def __init__(self, subject: Subject, limits: Limits | None) -> None:
        self.subject, self.limits = subject, limits or Limits()
        self.process = Process(self.limits)
        self._outline: Outline | None = None

    def answers(self, goal: str | None, given: Sequence[str]) -> list[Answer]:
        """P(goal | given), every answer."""
        return self._through(lambda: answers(self.subject, goal, given=given, limits=self.limits))

    def account(self, goal: str, given: Sequence[str], most: int) -> Account:
        """Why, and why not."""
        return self._through(lambda: explain(self.subject, goal, given=given, most=most, limits=self.limits))

    def outline(self) -> Outline:
        """The program's predicates and constants, read once; raises ProgramError."""
        if self._outline is None:
            text, names = subject_text(self.subject)
            request = outline_request(request_of([text], (), (), names)["texts"], names)
            self._outline = outline_of(self._through(lambda: ask(request, self.limits)))
        return self._outline

    def close(self) -> None:
        """End what runs in the background."""
        self.process.close()

    def worlds_of_text(self, n: int, given: Sequence[str]) -> tuple[tuple[World, ...], tuple[float, float]]:
        """The ``n`` best worlds by the program text, and the mass that is not among them.

        They are grouped by what the program's queries come to. One more is looked for: without it there is no rest.
        """
        rows = self._through(lambda: _of_text(self.subject, n + 1, given, self.limits)[0])
        mass = 0.0 if len(rows) <= n else max(0.0, 1.0 - math.fsum(row.probability for row in rows[:n]))
        return rows[:n], (mass, mass)

    def clauses_of(self, name: str) -> tuple[str, tuple[str, ...]]:
        """The clauses of every predicate of that name, ``wet`` or ``wet/1``; raises InputError where there is none."""
        found = [p for p in self.outline().predicates if name in (p.name, p.signature)]
        if not found:
            raise InputError(f"listing {name}: the program has no such predicate; `listing` says what there is")
        lines = tuple(line for p in found for clause in p.clauses for line in clause.splitlines())
        return ", ".join(p.signature for p in found), lines

    def _through(self, call: Callable[[], Any]) -> Any:  # noqa: ANN401 - whatever the call returns
        with through(self.process.ask):
            return call()


class ProgramMind(Asked):
    """Everything through the process that stays: it has the program, and what it compiled."""

    types = None
    worlds = Asked.worlds_of_text
    clauses = Asked.clauses_of

    def __init__(self, text: Text, limits: Limits | None) -> None:
        super().__init__(text, limits)
        self.text = text

    def contents(self) -> tuple[tuple[str, str], ...]:
        """(signature, meaning) of every predicate: the number of its clauses."""
        return tuple((p.signature, p.meaning) for p in self.outline().predicates)

    def predicates(self) -> tuple[Predicate, ...]:
        """The program's own, without its queries and evidence."""
        return tuple(p for p in self.outline().predicates if p.name not in DIRECTIVES)

    def names(self) -> tuple[tuple[str, str], ...]:
        """(constant, '') of the program's own constants."""
        return tuple((constant, "") for constant in self.outline().constants)

    def greeting(self) -> str:
        """The file and its size."""
        found = self.predicates()
        return f"{self.text.file}: {sum(len(p.clauses) for p in found)} clauses of {len(found)} predicates"


class SceneMind(Asked):
    """Worlds and answers from the scene's graph; explanations through the process that stays.

    What is observed stays in the graph, and only what it touches is computed anew.
    """

    def __init__(self, situation: Situation, limits: Limits | None) -> None:
        super().__init__(situation, limits)
        self.situation = situation
        self._live: LiveScene | None = None

    def answers(self, goal: str | None, given: Sequence[str]) -> list[Answer]:
        """P(goal | given) on the graph; of what the graph has summed out, by the program text."""
        try:
            return self._through(lambda: self._given(given).answers(goal or "present(H)"))
        except OutsideError:
            return super().answers(goal, given)

    def worlds(self, n: int, given: Sequence[str]) -> tuple[tuple[World, ...], tuple[float, float]]:
        """The ``n`` best assignments of present/1, and the interval of the mass that is not among them."""
        try:
            ranking = self._through(lambda: self._given(given).worlds(n))
        except OutsideError:
            return self.worlds_of_text(n, given)
        return _of_graph(ranking), ranking.unlisted

    @property
    def types(self) -> dict[str, str]:
        """The type of each hypothesis, by id."""
        return {h.id: h.type for h in self.situation.hypotheses}

    def close(self) -> None:
        """End the process, and forget the graph."""
        super().close()
        self._live = None

    def _given(self, given: Sequence[str]) -> "LiveScene":
        """The scene with this evidence; what it solved before, it remembers. After an interruption it is built anew."""
        from plogic.scene.asking.live import LiveScene

        live, self._live = self._live or LiveScene(self.situation, limits=self.limits), None
        if live.given != tuple(given):
            live.unobserve()
            for goal in given:
                live.observe(goal)
        self._live = live
        return live

    def contents(self) -> tuple[tuple[str, str], ...]:
        """(name, meaning) of the layers of the program, and of its predicates."""
        layers = tuple((str(i), title) for i, (title, _) in enumerate(self._layers(), 1))
        return (*layers, *((p.signature, p.meaning) for p in self.outline().predicates))

    def clauses(self, name: str) -> tuple[str, tuple[str, ...]]:
        """A layer as the program text has it, or the clauses of a predicate with labels for atoms."""
        layers = self._layers()
        number = whole(name, len(layers))
        if number:
            return layers[number - 1]
        spelled = {f"{word}{end}": f"{own}{end}" for (word, n), own in SPELLINGS.items() for end in ("", f"/{n}")}
        return self.clauses_of(spelled.get(name, name))

    def predicates(self) -> tuple[Predicate, ...]:
        """The vocabulary, and what the author's rules add."""
        known = [Predicate(e.usage.split("(")[0], e.arity, e.usage, e.meaning) for e in entries(self.situation.reading)]
        return (*known, *(p for p in self._author() if p.signature not in {k.signature for k in known}))

    def names(self) -> tuple[tuple[str, str], ...]:
        """(constant, what it names) of hypotheses, appearances, features, types."""
        situation = self.situation
        found: dict[str, str] = {h.id: f"{h.type}, a hypothesis" for h in situation.hypotheses}
        found |= {a.id: f"{a.type}, an appearance" for a in situation.appearances}
        for h in situation.hypotheses:
            found |= {f.id: f"{f.type}, a feature" for f in h.features if f.id not in found}
            found.setdefault(h.type, "a type of objects")
        for kind in situation.dv:
            found.setdefault(kind, "a type of features")
        return tuple((quoted(label), meaning) for label, meaning in found.items())

    def greeting(self) -> str:
        """How much there is to decide, in which reading. Raises ProgramError for rules of one's own with a mistake."""
        s = self.situation
        if s.own is not None:
            self.answers(None, ())
        return f"a scene of {len(s.hypotheses)} hypotheses and {len(s.appearances)} appearances, reading {s.reading}"

    def _author(self) -> tuple[Predicate, ...]:
        """What the program has with the author's rules and not without them."""
        if not self.situation.rules.strip() and self.situation.own is None:
            return ()
        plain = SceneMind(replace(self.situation, rules="", own=None), self.limits)
        plain.process = self.process
        ours = {p.signature for p in plain.outline().predicates}
        return tuple(p for p in self.outline().predicates if p.signature not in ours)

    def _layers(self) -> list[tuple[str, tuple[str, ...]]]:
        layers: list[tuple[str, list[str]]] = []
        from plogic.scene.text.program_text import program_text

        for line in program_text(self.situation).splitlines():
            if line.startswith(LAYER):
                layers.append((line.split(") ", 1)[1], []))
            elif layers and line:
                layers[-1][1].append(line)
        return [(title, tuple(lines)) for title, lines in layers]


Mind = ProgramMind | SceneMind
"""What a session asks of its subject."""


def mind_of(subject: Subject, limits: Limits | None) -> Mind:
    """The mind of a situation or of a program's text."""
    return ProgramMind(subject, limits) if isinstance(subject, Text) else SceneMind(subject, limits)


def ranked(
    subject: Subject, n: int, given: Sequence[str], limits: Limits, seconds: float | None = None
) -> "tuple[Worlds, Ranking | ProgramRanking]":
    """The ``n`` most probable worlds, with what is proved of a stopped search, and the ranking that they are from.

    That of a scene is by the program text where the evidence speaks of choices that the graph has summed out; causes
    are not told then. With ``seconds``, what is known by then.
    """
    ranking: Ranking | ProgramRanking
    if isinstance(subject, Text):
        rows, ranking = _of_text(subject, n, given, limits, seconds)
        return Worlds(rows, ranking.unlisted, tuple(given), None, complete=ranking.complete), ranking
    try:
        ranking = _on_graph(subject, n, given, seconds)
        rows, complete = _of_graph(ranking), ranking.exact
    except OutsideError:
        rows, ranking = _of_text(subject, n, given, limits, seconds)
        complete = ranking.complete
    stopped, types = stopped_of(subject), {h.id: h.type for h in subject.hypotheses}
    rows = tuple(replace(row, interval=proved(stopped, row.interval)) for row in rows)
    return Worlds(rows, proved(stopped, ranking.unlisted), tuple(given), types, stopped, complete), ranking


def _of_graph(ranking: "Ranking") -> tuple[World, ...]:
    return tuple(
        World(
            w.probability,
            w.present,
            w.causes,
            w.interval,
            support=None if w.told is None else w.told.state,
            stances=None if w.told is None else w.told.stances,
        )
        for w in ranking.worlds
    )


def _of_text(
    subject: Subject, n: int, given: Sequence[str], limits: Limits, seconds: float | None = None
) -> tuple[tuple[World, ...], ProgramRanking]:
    """The worlds by the program text: of a scene those of who is present, by ids."""
    text, names = subject_text(subject)
    ids = {} if isinstance(subject, Text) else {f"present({quoted(h.id)})": h.id for h in subject.hypotheses}
    goals = () if isinstance(subject, Text) else ("present(H)",)
    found = program_worlds(text, n, given=given, goals=goals, limits=limits, seconds=seconds, names=names)
    rows = tuple(
        World(w.probability, tuple(ids.get(goal, goal) for goal in w.holds), None, (w.probability,) * 2, w.choices)
        for w in found.worlds
    )
    return rows, found


def _on_graph(situation: Situation, n: int, given: Sequence[str], seconds: float | None) -> "Ranking":
    """With a deadline, grounding the evidence included; what it takes then is left of the time."""
    from plogic.scene.asking.live import LiveScene
    from plogic.scene.worlds.ranked_worlds import ranked_worlds

    if not given:
        return ranked_worlds(situation, n, seconds=seconds)
    end = None if seconds is None else time.monotonic() + seconds
    scene = LiveScene(situation)
    for goal in given:
        scene.observe(goal, seconds=_left(end))
    return scene.worlds(n, seconds=_left(end))


def _left(end: float | None) -> float | None:
    return None if end is None else max(end - time.monotonic(), 0.0)
