"""The program with its choices left open: what a goal means in terms of present/1 and, in the posterior reading, chosen/2.

Layers 1, 2 and 4 are those of ``program_text``; layer 3 says only what can be chosen, not how probable it is. Given the
evidence that every appearance is explained, chosen(A, H/F) holds exactly where F of H causes A: it hits, and no other
claimant does. So the goals of the vocabulary need no hits, and given that nothing floats without an excuse they need no
excuses. What speaks of other choices (``OUTSIDE``) has no meaning here, and is left to the program itself.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from plogic.facts.dependence import Scene, dependence
from plogic.facts.names import names_of
from plogic.logic.safety.author import author_rules
from plogic.scene.readings.posterior_reading import causes_of
from plogic.scene.text import fact_layers as facts
from plogic.scene.text.contexts import context_clauses, contexts, ev_facts
from plogic.scene.text.layout import Writer
from plogic.scene.text.rules import (
    COMMON,
    CONCORDANT,
    EXCLUSIVE,
    FOUND,
    FOUND_REASSIGN,
    SUPPORTED,
    VIOLATED,
    defined,
    fallbacks,
    vocabulary_rules,
)

if TYPE_CHECKING:
    from collections.abc import Iterator

    from plogic.facts.situation import Situation

OUTSIDE = ("hit/2", "pick/2", "luck/2", "ok/2", "joint/3", "agrees/1", "excused/1")
"""Choices that the factor graph has summed out, and what is said in terms of them."""

CHOSEN = r"""
hitting(A, H, F) :- match(H, F, A), chosen(A, H/F).
other_hit(A, H, F) :- match(G, E, A), G/E \= H/F, hitting(A, G, E).
any_hit(A) :- hitting(A, _, _).
missed(H, F) :- hitting(_, H, F).
explained(A) :- chosen(A, _).
explained(A) :- claimed(A).
claimed(_) :- fail. chosen(_, _) :- fail.
"""


def free_program(situation: Situation) -> str:
    """Its text: every present/1, and every chosen/2 that the alternatives of causes have, is a choice with a label of no meaning."""
    scene = Scene(situation)
    return "\n".join(_lines(Writer(scene, dependence(scene), names_of(situation)))) + "\n"


def _lines(w: Writer) -> Iterator[str]:
    situation = w.scene.situation
    score = situation.reading == "score"
    yield "present(_) :- fail."
    yield from facts.trees(w)
    yield from facts.geometry(w)
    yield from ev_facts(w)
    yield from ("0.5::" + w.fact("present", h.id) for h in situation.hypotheses)
    yield from _score(w) if score else _posterior(w)
    yield from (f"{s.split('/')[0]}({', '.join('_' * int(s[-1]))}) :- fail." for s in OUTSIDE)
    yield fallbacks()
    reassigned = score and situation.reconsider == "reassign"
    yield from (COMMON, FOUND_REASSIGN if reassigned else FOUND, VIOLATED)
    yield from vocabulary_rules(situation.reading)
    yield from author_rules(situation.rules, w.names, defined())


def _score(w: Writer) -> Iterator[str]:
    """Who is decided alone, and who jointly: no choice, but it can be asked for."""
    yield "alone(_) :- fail. member_of(_, _) :- fail. includes(_, _) :- fail."
    joint = [block for block in w.graph.blocks if len(block) > 1]
    yield from (w.fact("alone", block[0]) for block in w.graph.blocks if len(block) == 1)
    for i, block in enumerate(joint, start=1):
        yield from (f"member_of({w.names.atom(name)}, block({i}))." for name in block)
        yield from (f"includes({w.list(state)}, {w.names.atom(name)})." for state in contexts(block) for name in state)
        yield from context_clauses(w, f"block({i})", w.graph.outside(block))
    yield from (SUPPORTED, EXCLUSIVE)
    if w.scene.situation.reconsider != "drop":
        yield CONCORDANT


def _posterior(w: Writer) -> Iterator[str]:
    for appearance in w.scene.claimants:
        causes = causes_of(w.scene, appearance)
        named = [(p, w.node(h, f.id)) for p, (h, f) in zip(causes.shares, causes.claimants, strict=True)]
        yield w.fact("claimed", appearance)
        yield from (
            f"0.5::chosen({w.names.atom(appearance)}, {cause})."
            for p, cause in [*named, (causes.noise, "noise")]
            if p > 0
        )
    yield CHOSEN
