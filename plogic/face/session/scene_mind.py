"""A session about the scene of one image: what is observed stays in the graph, and only what it touches is computed anew."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from plogic.base.errors import OutsideError
from plogic.face.session.minds import Asked
from plogic.face.session.program_mind import clauses_of, rest
from plogic.face.session.results import World
from plogic.facts.vocabulary import entries
from plogic.logic.safety.atoms import SPELLINGS, quoted
from plogic.logic.served.outline import Predicate

if TYPE_CHECKING:
    from collections.abc import Sequence

    from plogic.face.session.minds import Ranked
    from plogic.facts.situation import Situation
    from plogic.logic.served.engine import Answer, Limits
    from plogic.scene.asking.live import LiveScene

LAYER = "% ==== ("
"""How a layer of the program text begins."""


class SceneMind(Asked):
    """Worlds and answers from the scene's graph; explanations through the process that stays."""

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

    def worlds(self, n: int, given: Sequence[str]) -> Ranked:
        """The ``n`` best assignments of present/1."""
        try:
            ranking = self._through(lambda: self._given(given).worlds(n))
        except OutsideError:
            return self._worlds_of_text(n, given)
        return tuple(World(w.probability, w.present, w.causes, w.interval) for w in ranking.worlds), ranking.unlisted

    @property
    def types(self) -> dict[str, str]:
        """The type of each hypothesis, by id."""
        return {h.id: h.type for h in self.situation.hypotheses}

    def _worlds_of_text(self, n: int, given: Sequence[str]) -> Ranked:
        """The same by the program text, where the evidence speaks of what the graph has summed out; the causes are not told then."""
        from plogic.logic.served.engine import program_worlds
        from plogic.scene.asking.query import subject_text

        text, table = subject_text(self.situation)
        ranking = self._through(
            lambda: program_worlds(text, n + 1, given=given, goals=("present(H)",), names=table, limits=self.limits)
        )
        ids = {f"present({quoted(h)})": h for h in self.types}
        rows = tuple(
            World(w.probability, tuple(ids[goal] for goal in w.holds), None, (w.probability,) * 2, w.choices)
            for w in ranking.worlds[:n]
        )
        return rows, rest(rows, complete=len(ranking.worlds) <= n)

    def close(self) -> None:
        """End the process, and forget the graph."""
        super().close()
        self._live = None

    def _given(self, given: Sequence[str]) -> LiveScene:
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
        """The layers of the program, and its predicates."""
        layers = tuple((str(i), title) for i, (title, _) in enumerate(self._layers(), 1))
        return (*layers, *((p.signature, p.meaning) for p in self.outline().predicates))

    def clauses(self, name: str) -> tuple[str, tuple[str, ...]]:
        """A layer as the program text has it, or the clauses of a predicate with labels for atoms."""
        layers = self._layers()
        if name.isdecimal() and 0 < int(name) <= len(layers):
            return layers[int(name) - 1]
        spelled = {f"{word}{end}": f"{own}{end}" for (word, n), own in SPELLINGS.items() for end in ("", f"/{n}")}
        return clauses_of(self.outline(), spelled.get(name, name))

    def predicates(self) -> tuple[Predicate, ...]:
        """The vocabulary, and what the author's rules add."""
        known = [Predicate(e.usage.split("(")[0], e.arity, e.usage, e.meaning) for e in entries(self.situation.reading)]
        return (*known, *(p for p in self._author() if p.signature not in {k.signature for k in known}))

    def names(self) -> tuple[tuple[str, str], ...]:
        """Hypotheses, appearances, features, types."""
        return _names(self.situation)

    def greeting(self) -> str:
        """How much there is to decide, in which reading."""
        s = self.situation
        return f"a scene of {len(s.hypotheses)} hypotheses and {len(s.appearances)} appearances, reading {s.reading}"

    def _author(self) -> tuple[Predicate, ...]:
        """What the program has with the author's rules and not without them."""
        if not self.situation.rules.strip():
            return ()
        plain = SceneMind(replace(self.situation, rules=""), self.limits)
        plain.process = self.process
        ours = {p.signature for p in plain.outline().predicates}
        return tuple(p for p in self.outline().predicates if p.signature not in ours)

    def _layers(self) -> list[tuple[str, tuple[str, ...]]]:
        from plogic.scene.text.program_text import program_text

        layers: list[tuple[str, list[str]]] = []
        for line in program_text(self.situation).splitlines():
            if line.startswith(LAYER):
                layers.append((line.split(") ", 1)[1], []))
            elif layers and line:
                layers[-1][1].append(line)
        return [(title, tuple(lines)) for title, lines in layers]


def _names(situation: Situation) -> tuple[tuple[str, str], ...]:
    found: dict[str, str] = {h.id: f"{h.type}, a hypothesis" for h in situation.hypotheses}
    found |= {a.id: f"{a.type}, an appearance" for a in situation.appearances}
    for h in situation.hypotheses:
        found |= {f.id: f"{f.type}, a feature" for f in h.features if f.id not in found}
        found.setdefault(h.type, "a type of objects")
    for kind in situation.dv:
        found.setdefault(kind, "a type of features")
    return tuple((quoted(label), meaning) for label, meaning in found.items())
