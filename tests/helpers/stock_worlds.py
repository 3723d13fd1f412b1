"""The worlds of a situation by stock ProbLog: its program text with a query for each subset of the hypotheses."""

from __future__ import annotations

import math
from itertools import product

import pytest

from plogic.facts.situation import names_of
from plogic.scene.text.program_text import program_text
from plogic.scene.worlds.ranked_worlds import ranked_worlds


def evaluated(text):
    """Query, a term of ProbLog's, → probability, by ProbLog's own Python interface."""
    from problog import get_evaluatable
    from problog.program import PrologString

    return get_evaluatable("ddnnf").create_from(PrologString(text)).evaluate()


def stock(text):
    """The same, each query as text."""
    return {str(goal): p for goal, p in evaluated(text).items()}


def worlds_program(subject):
    """The text, with a query for each subset of the hypotheses."""
    names = names_of(subject)
    atoms = [names.atom(h.id) for h in subject.hypotheses]
    lines = [program_text(subject)]
    for number, bits in enumerate(product((False, True), repeat=len(atoms))):
        body = ", ".join(
            f"present({atom})" if bit else f"\\+ present({atom})" for atom, bit in zip(atoms, bits, strict=True)
        )
        lines.append(f"world({number}) :- {body}.\nquery(world({number})).")
    return "\n".join(lines)


def subsets(subject):
    ids = [h.id for h in subject.hypotheses]
    return [
        tuple(h for h, bit in zip(ids, bits, strict=True) if bit) for bits in product((False, True), repeat=len(ids))
    ]


def assert_same_worlds(subject):
    ranking = ranked_worlds(subject, 10**6)
    ours = {w.present: w.probability for w in ranking.worlds}
    theirs = stock(worlds_program(subject))
    assert len(theirs) == 2 ** len(subject.hypotheses)
    for number, present in enumerate(subsets(subject)):
        assert theirs[f"world({number})"] == pytest.approx(ours.get(present, 0.0), abs=1e-9), present
    assert math.fsum(ours.values()) == pytest.approx(1.0, abs=1e-9)
    return ranking
