"""The meaning of a goal of the vocabulary on a scene's graph.

A boolean formula over who is present and what causes what.

The goal is ground in the child process, over the program with its choices left open (``free_program``), and comes back
as data. Layers 1, 2 and 4 of that program are those of ``program_text``; layer 3 says only what can be chosen, not how
probable it is. Given the evidence that every appearance is explained, chosen(A, H/F) holds exactly where F of H causes
A: it hits, and no other claimant does. So the goals of the vocabulary need no hits, and given that nothing floats
without an excuse they need no excuses. A goal about other choices (``OUTSIDE``) has no meaning here, and is left to the
program itself. Vocabulary:

* ``Meaning``, of one or several goals and pieces of evidence: nodes, and keys into them
  (``plogic.logic.served.goal_formulas``)
* ``Meaning.formula(key, scene)``: the formula, over the variables of a graph that has the appearances in
  ``appearances`` as variables
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import lru_cache
from typing import TYPE_CHECKING, Any

from plogic.base.errors import LimitError, OutsideError
from plogic.facts.dependence import Scene, dependence
from plogic.facts.situation import Situation, names_of
from plogic.facts.vocabulary import VOCABULARY
from plogic.inference.gates import And, Formula, Literal, Not, Or
from plogic.logic.safety.atoms import Names, own_atom, quoted
from plogic.logic.safety.author import observes
from plogic.logic.served.engine import Limits, Text, ask, request_of
from plogic.scene.text import fact_layers as facts
from plogic.scene.text.choices import block_facts, pixel_facts
from plogic.scene.text.evidence_layer import evidence_choices, evidence_facts, evidence_rules
from plogic.scene.text.layout import Writer, possible_causes
from plogic.scene.text.measures import cell_facts, measures
from plogic.scene.text.object_types import object_types
from plogic.scene.text.program_text import added_to
from plogic.scene.text.rules import (
    COMMON,
    CONCORDANT,
    EV,
    EXCLUSIVE,
    FOUND,
    FOUND_REASSIGN,
    OBJECT_TYPES,
    SUPPORTED,
    VIOLATED,
    fallbacks,
    vocabulary_rules,
)
from plogic.scene.text.support_layer import open_choices, support_facts
from plogic.scene.text.values_asked import told_in_words

if TYPE_CHECKING:
    from plogic.scene.factors.scene_graph import SceneGraph

Key = int | None

OUTSIDE = (
    "hit/2",
    "pick/2",
    "luck/2",
    "ev_holds/2",
    "joint/3",
    "agrees/1",
    "excused/1",
    "drawn/1",
    "told_fits/3",
    "by_chance/1",
    "has_footing/1",
)
"""Choices that the factor graph has summed out, and what is said in terms of them."""
LOOKING = (
    *(f"subquery/{n}" for n in (2, 3, 5)), *(f"subquery_in_scope/{n}" for n in (3, 4, 6)), "possible/1", "clause/2", "clause/3",
    "create_scope/2", "find_scope/2", "findall/3", "aggregate/5", "=>/2", "=../2",
)  # fmt: skip
"""Built-ins that tell the program itself, its probabilities or its proofs, or may build such a call.
``findall/3`` has an answer once for each proof; ``all/3`` and ``all_or_none/3`` have it once."""

CHOSEN = r"""
hitting(A, H, F) :- match(H, F, A), chosen(A, H/F).
other_hit(A, H, F) :- match(G, E, A), G/E \= H/F, hitting(A, G, E).
any_hit(A) :- hitting(A, _, _).
missed(H, F) :- hitting(_, H, F).
explained(A) :- chosen(A, _).
explained(A) :- claimed(A).
claimed(_) :- fail. chosen(_, _) :- fail.
"""


def free_program(situation: Situation, names: Names | None = None, *, data: bool = True) -> str:
    """Its text: every present/1, and every chosen/2 that alternatives of causes have, with a label of no meaning.

    ``names``: by which table, where it is another situation's; ``data``: with what is in Γ.
    """
    scene = Scene(situation)
    return "\n".join(_lines(Writer(scene, dependence(scene), names or names_of(situation)), data=data)) + "\n"


def _lines(w: Writer, *, data: bool) -> Iterator[str]:
    situation = w.scene.situation
    score = situation.reading == "score"
    yield "present(_) :- fail."
    yield from object_types(w)
    yield from measures(w)
    yield from facts.geometry(w, data=data)
    yield from support_facts(w)
    yield from cell_facts(w)
    yield from (*evidence_facts(w), *evidence_choices(w), *evidence_rules(w))
    yield from ("0.5::" + w.fact("present", h.id) for h in situation.hypotheses)
    yield from open_choices(w)
    yield from _score(w) if score else _posterior(w)
    yield from (f"{s.split('/')[0]}({', '.join('_' * int(s[-1]))}) :- fail." for s in OUTSIDE)
    yield from fallbacks(situation.reading)
    yield from (
        OBJECT_TYPES,
        EV,
        COMMON,
        FOUND_REASSIGN if (score and situation.reconsider == "reassign") else FOUND,
        VIOLATED,
    )
    yield from vocabulary_rules(situation.reading)


def _score(w: Writer) -> Iterator[str]:
    """Who is decided alone, and who jointly: no choice, but it can be asked for."""
    yield from (w.fact("alone", block[0]) for block in w.graph.blocks if len(block) == 1)
    for i, block in enumerate((block for block in w.graph.blocks if len(block) > 1), start=1):
        yield from block_facts(w, i, block)
    yield from (SUPPORTED, EXCLUSIVE)
    if w.scene.situation.reconsider != "drop":
        yield CONCORDANT


def _posterior(w: Writer) -> Iterator[str]:
    yield from pixel_facts(w)
    for appearance in w.scene.claimants:
        yield w.fact("claimed", appearance)
        yield from (f"0.5::{chosen}." for _, chosen in possible_causes(w, appearance))
    yield CHOSEN


TRUE, FALSE = And(()), Or(())


@dataclass(frozen=True)
class Meaning:
    """``answers``: per goal, what to show of each answer and its key.

    ``single``: whether the goal has one answer, possible or not.

    ``given``: keys that the evidence makes true, the author's included; ``choices``: alternative of the author's →
    the number and the probability of each choice in it that is spoken of, by the names of the grounder ``by``.
    """

    nodes: tuple[tuple[str, Any], ...]
    answers: tuple[tuple[tuple[str, Key], ...], ...]
    single: tuple[bool, ...]
    given: tuple[Key, ...]
    choices: Mapping[str, Sequence[tuple[int, float]]] = field(default_factory=dict)
    by: str = ""

    @property
    def appearances(self) -> frozenset[str]:
        """Those whose cause is spoken of."""
        return frozenset(arguments[0][0] for kind, arguments in self.nodes if kind == "chosen")

    @property
    def footings(self) -> frozenset[str]:
        """Those whose footing is spoken of."""
        return frozenset(arguments[0][0] for kind, arguments in self.nodes if kind == "footing")

    @property
    def planes(self) -> bool:
        """Whether it is spoken of what things stand on."""
        return any(kind in ("support", "footing") for kind, _ in self.nodes)

    def formulas(self, keys: Iterable[Key], scene: "SceneGraph") -> list[Formula]:
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


def _literal(kind: str, arguments: list[Any], scene: "SceneGraph") -> Formula:
    """``present(h1)``, ``chosen(a1, h1/roof/apex)``, ``support(s1)``, ``footing(h1, s1, 2)``, or the author's."""
    if kind in ("present", "choice"):
        variable, state = (
            scene.place[arguments[0][0]] if kind == "present" else scene.choices[arguments[0], arguments[1]]
        )
        return Literal(variable, frozenset({state}))
    name, *rest = (label for argument in arguments for label in argument)
    if kind == "support" and scene.support is not None:
        return scene.support.literal(name)
    return (scene.footings if kind == "footing" else scene.causes)[name].literal(*rest)


def meaning(
    situation: Situation,
    goals: Sequence[str],
    given: Sequence[str] = (),
    *,
    limits: Limits | None = None,
) -> Meaning:
    """The meaning of goals and evidence.

    Raises OutsideError where they, or rules, speak of what the graph does not have; else what
    ``plogic.logic.served.engine.run`` raises.
    """
    direct = _direct(situation, goals, given) if situation.own is None else None
    if direct is not None:
        return direct
    asked = *goals, *given
    parts = _spoken(situation, asked, LOOKS), _spoken(situation, asked, DATA)
    program, atoms = _written(_Very(situation), *parts)
    return _ground(Text(program, own=added_to(situation)), atoms, tuple(goals), tuple(given), limits or Limits())


def _leading_to(fact: str) -> tuple[str, ...]:
    """A fact, and the words of the vocabulary that are defined by it; each word's own stand before it in the table."""
    words = [fact]
    for entry in VOCABULARY:
        if any(f"{word}(" in entry.clause for word in words):
            words.append(entry.name)
    return tuple(words)


LOOKS, DATA = _leading_to("type_look"), _leading_to("datum")
"""Words without which nobody speaks of how features look, or of what is in Γ: nothing else is a consequence of it."""


def _spoken(situation: Situation, asked: Sequence[str], words: Sequence[str]) -> bool:
    added = () if situation.own is None else (piece.text for piece in situation.own.pieces())
    return any(word in text for text in (*asked, situation.rules, *added) for word in words)


class _Very:
    """A situation, which has no hash: equal to no other object, though it says the same."""

    def __init__(self, situation: Situation) -> None:
        self.situation = situation

    def __hash__(self) -> int:
        return id(self.situation)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, _Very) and self.situation is other.situation


@lru_cache(maxsize=4)
def _written(very: _Very, looks: bool, data: bool) -> tuple[str, tuple[tuple[str, str], ...]]:  # noqa: FBT001 - keys
    """The program of a situation, for goal after goal, and the atom of each of its labels.

    With how features look, and with what is in Γ, or without: in a photo there are thousands of each.
    """
    whole, names = very.situation, names_of(very.situation)
    return free_program(whole if looks else _lookless(whole), names, data=data), tuple(names.atoms.items())


@lru_cache(maxsize=8)
def _ground(
    text: Text, atoms: tuple[tuple[str, str], ...], goals: tuple[str, ...], given: tuple[str, ...], limits: Limits
) -> Meaning:
    request = request_of([text], goals, given, Names.of(dict(atoms)))
    with told_in_words(text):
        reply = ask({**request, "task": "formula", "outside": [*OUTSIDE, *LOOKING]}, limits)
    if "outside" in reply:
        raise OutsideError(reply["outside"], file="goal")
    return Meaning(
        tuple((kind, arguments) for kind, arguments in reply["nodes"]),
        tuple(tuple((shown, key) for shown, key in found) for found in reply["answers"]),
        tuple(reply["single"]),
        tuple(reply["given"]),
        {name: tuple((number, share) for number, share in some) for name, some in reply["choices"].items()},
        reply["by"],
    )


def standing(situation: Situation) -> tuple[Meaning, ...]:
    """What the author, and who asks, observe and constrain; nothing where they do not. Raises as ``meaning``."""
    added = added_to(situation)
    own = situation.own is not None  # its mistakes are told when it is read
    observing = added is not None and any(own or observes(piece.text, piece.file) for piece in added.pieces())
    if not observing or added is None:
        return ()
    try:
        return (meaning(situation, ()),)
    except LimitError as error:
        files = ", ".join(dict.fromkeys(piece.file for piece in added.pieces()))
        raise LimitError(f"{files}: what is observed there cannot be weighed: {error}") from None


def _lookless(situation: Situation) -> Situation:
    return replace(situation, types={name: replace(fact, looks=()) for name, fact in situation.types.items()})


def _direct(situation: Situation, goals: Sequence[str], given: Sequence[str]) -> Meaning | None:
    """Where all that is said is present/1 of a hypothesis, or its negation, or ``present(H)``.

    Nothing has to be ground.
    """
    ids = [h.id for h in situation.hypotheses]
    said = _spellings(ids)
    known = {_squeezed(text) for text in (*goals, *given)} - {"present(H)"}
    if situation.rules.strip() or not known <= said.keys() or any(_squeezed(text) == "present(H)" for text in given):
        return None
    nodes: tuple[tuple[str, Any], ...] = tuple(("present", [[name]]) for name in ids)
    everyone = tuple((f"present({quoted(name)})", i) for i, name in enumerate(ids, 1))
    answers = tuple(everyone if _squeezed(g) == "present(H)" else (_shown(ids, said[_squeezed(g)]),) for g in goals)
    single = tuple(_squeezed(g) != "present(H)" for g in goals)
    return Meaning(nodes, answers, single, tuple(said[_squeezed(g)] for g in given))


def _shown(ids: list[str], key: int) -> tuple[str, int]:
    return ("" if key > 0 else "\\+ ") + f"present({quoted(ids[abs(key) - 1])})", key


def _spellings(ids: list[str]) -> dict[str, int]:
    r"""``present(h1)`` → 1, ``\+present('h1')`` → -1: as ``_squeezed`` leaves them."""
    found: dict[str, int] = {}
    for i, name in enumerate(ids, 1):
        for form in (name, f"'{name}'") if own_atom(name) else (quoted(name),):
            found[f"present({form})"], found[f"\\+present({form})"] = i, -i
    return found


def _squeezed(text: str) -> str:
    """Without the full stop, and without spaces before and after it and after the negation."""
    bare = text.strip().removesuffix(".").rstrip()
    return "\\+" + bare[2:].lstrip() if bare.startswith("\\+") else bare
