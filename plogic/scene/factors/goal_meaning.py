"""What a goal of the vocabulary means on a scene's graph: a boolean formula over who is present and what causes what.

The goal is ground in the child process, over the program with its choices left open
(``plogic.scene.text.open_choices``), and comes back as data. Vocabulary:

* ``Meaning``, of one or several goals and pieces of evidence: nodes, and keys into them
  (``plogic.logic.served.goal_formulas``)
* ``Meaning.formula(key, scene)``: the formula, over the variables of a graph that has the appearances in
  ``appearances`` as variables
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from plogic.base.errors import OutsideError
from plogic.facts.names import names_of
from plogic.inference.gates import And, Literal, Not, Or
from plogic.logic.safety.atoms import own_atom
from plogic.logic.served.engine import Limits, Text, ask, request_of
from plogic.scene.text.open_choices import OUTSIDE, free_program

if TYPE_CHECKING:
    from collections.abc import Iterable, Sequence

    from plogic.facts.situation import Situation
    from plogic.inference.gates import Formula
    from plogic.scene.factors.scene_graph import SceneGraph

    Key = int | None

TRUE, FALSE = And(()), Or(())


@dataclass(frozen=True)
class Meaning:
    """``answers``: per goal, what to show of each answer and its key; ``single``: whether the goal has one answer, possible or not.

    ``given``: keys that the evidence makes true.
    """

    nodes: tuple[tuple[str, Any], ...]
    answers: tuple[tuple[tuple[str, Key], ...], ...]
    single: tuple[bool, ...]
    given: tuple[Key, ...]

    @property
    def appearances(self) -> frozenset[str]:
        """Those whose cause is spoken of."""
        return frozenset(arguments[0][0] for kind, arguments in self.nodes if kind == "chosen")

    def formulas(self, keys: Iterable[Key], scene: SceneGraph) -> list[Formula]:
        """The formulas of the keys, which share their parts; nodes come before those that use them."""
        made: list[Formula] = []

        def of(key: Key) -> Formula:
            if not key:
                return FALSE if key is None else TRUE
            return made[key - 1] if key > 0 else Not(made[-key - 1])

        for kind, arguments in self.nodes:
            if kind in ("and", "or"):
                parts = tuple(of(key) for key in arguments)
                made.append(And(parts) if kind == "and" else Or(parts))
            else:
                made.append(_literal(kind, arguments, scene))
        return [of(key) for key in keys]


def _literal(kind: str, arguments: list[list[str]], scene: SceneGraph) -> Formula:
    """``present(h1)`` or ``chosen(a1, h1/roof/apex)``; nothing else is a choice here."""
    if kind == "present":
        variable, state = scene.place[arguments[0][0]]
        return Literal(variable, frozenset({state}))
    cause = scene.causes[arguments[0][0]]
    return Literal(cause.variable, frozenset({cause.states.index(tuple(arguments[1]))}))


def meaning(
    situation: Situation,
    goals: Sequence[str],
    given: Sequence[str] = (),
    *,
    rules: Text | None = None,
    limits: Limits | None = None,
) -> Meaning:
    """The meaning of goals and evidence.

    Raises OutsideError where they, or the rules, speak of what the graph does not have; else what
    ``plogic.logic.served.engine.run`` raises.
    """
    direct = _direct(situation, goals, given) if rules is None else None
    if direct is not None:
        return direct
    texts = [Text(free_program(situation)), *([] if rules is None else [rules])]
    request = request_of(texts, goals, given, names_of(situation))
    reply = ask({**request, "task": "formula", "outside": list(OUTSIDE)}, limits or Limits())
    if "outside" in reply:
        raise OutsideError(reply["outside"], file="goal")
    answers = tuple(tuple((shown, key) for shown, key in found) for found in reply["answers"])
    return Meaning(
        tuple((kind, arguments) for kind, arguments in reply["nodes"]),
        answers,
        tuple(reply["single"]),
        tuple(reply["given"]),
    )


def _direct(situation: Situation, goals: Sequence[str], given: Sequence[str]) -> Meaning | None:
    """Where all that is said is present/1 of a hypothesis, or its negation, or ``present(H)``: nothing has to be ground."""
    ids = [h.id for h in situation.hypotheses]
    said = _spellings(ids)
    known = {_squeezed(text) for text in (*goals, *given)} - {"present(H)"}
    if situation.rules.strip() or not known <= said.keys() or any(_squeezed(text) == "present(H)" for text in given):
        return None
    nodes: tuple[tuple[str, Any], ...] = tuple(("present", [[name]]) for name in ids)
    everyone = tuple((f"present({_written(name)})", i) for i, name in enumerate(ids, 1))
    answers = tuple(everyone if _squeezed(g) == "present(H)" else (_shown(ids, said[_squeezed(g)]),) for g in goals)
    single = tuple(_squeezed(g) != "present(H)" for g in goals)
    return Meaning(nodes, answers, single, tuple(said[_squeezed(g)] for g in given))


def _shown(ids: list[str], key: int) -> tuple[str, int]:
    return ("" if key > 0 else "\\+ ") + f"present({_written(ids[abs(key) - 1])})", key


def _spellings(ids: list[str]) -> dict[str, int]:
    r"""``present(h1)`` → 1, ``\+present('h1')`` → -1: as ``_squeezed`` leaves them."""
    found: dict[str, int] = {}
    for i, name in enumerate(ids, 1):
        for form in (name, f"'{name}'") if own_atom(name) else (_written(name),):
            found[f"present({form})"], found[f"\\+present({form})"] = i, -i
    return found


def _squeezed(text: str) -> str:
    """Without the full stop, and without spaces before and after it and after the negation."""
    bare = text.strip().removesuffix(".").rstrip()
    return "\\+" + bare[2:].lstrip() if bare.startswith("\\+") else bare


def _written(label: str) -> str:
    """The label as users write it."""
    return label if own_atom(label) else "'" + label.replace("\\", "\\\\").replace("'", "\\'") + "'"
