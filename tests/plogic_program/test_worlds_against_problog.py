"""The exact worlds equal the program text, run by stock ProbLog (§8: the text is the definition)."""

from __future__ import annotations

import math
from itertools import product

import pytest
from hypothesis import HealthCheck, given, settings
from situations import random_situations, situation, towers

from plogic.base.errors import InconsistentError
from plogic.facts.names import names_of
from plogic.scene.text.program_text import program_text
from plogic.scene.worlds.ranked_worlds import ranked_worlds

QUICK = settings(max_examples=60, deadline=None, derandomize=True, suppress_health_check=list(HealthCheck))


def stock(text):
    """Query → probability, by ProbLog's own Python interface."""
    from problog import get_evaluatable
    from problog.program import PrologString

    results = get_evaluatable("ddnnf").create_from(PrologString(text)).evaluate()
    return {str(goal): p for goal, p in results.items()}


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


@QUICK
@given(random_situations(readings=("score",)))
def test_score_worlds_equal_problog(subject):
    try:
        assert_same_worlds(subject)
    except InconsistentError:
        assert_problog_finds_none(subject)


@QUICK
@given(random_situations(readings=("posterior",)))
def test_posterior_worlds_equal_problog(subject):
    assert_same_worlds(subject)


def assert_problog_finds_none(subject):
    from problog.errors import InconsistentEvidenceError

    with pytest.raises(InconsistentEvidenceError):
        stock(worlds_program(subject))


@settings(QUICK, max_examples=25)
@given(random_situations(most=4))
def test_marginals_and_causes_equal_problog(subject):
    try:
        ranking = ranked_worlds(subject, 10**6)
    except InconsistentError:
        return
    names = names_of(subject)
    text = (
        program_text(subject) + "\nquery(present(_)). query(cause(_, _, _)). query(noise(_)). query(case(_, _, _)).\n"
    )
    theirs = stock(text)
    for h in subject.hypotheses:
        assert theirs.get(f"present({names.atom(h.id)})", 0.0) == pytest.approx(ranking.marginals[h.id], abs=1e-9)
    for a in subject.appearances:
        noise = theirs[f"noise({a.id})"]
        caused = [p for goal, p in theirs.items() if goal.startswith(f"cause({a.id},")]
        assert noise + math.fsum(caused) == pytest.approx(1.0, abs=1e-8), "exactly one cause per appearance (trap a)"
        if subject.reading == "score":
            assert noise == pytest.approx(
                sum(w.probability for w in ranking.worlds if w.causes[a.id] == "noise"), abs=1e-9
            )
    assert_one_case_per_feature(subject, names, theirs, ranking)


def assert_one_case_per_feature(subject, names, theirs, ranking):
    """A present feature in the image is in exactly one of the four cases (§4); one that projects outside it is in none."""
    for h in subject.hypotheses:
        for f in h.features:
            total = math.fsum(
                p for goal, p in theirs.items() if goal.startswith(f"case({names.atom(h.id)},{names.atom(f.id)},")
            )
            assert total == pytest.approx(ranking.marginals[h.id] if f.in_image else 0.0, abs=1e-8)


@pytest.mark.parametrize(
    ("reading", "mode"), [("score", "drop"), ("score", "to_B"), ("score", "reassign"), ("posterior", "to_B")]
)
def test_two_towers_equal_problog(reading, mode):
    assert_same_worlds(towers(reading, mode))


def test_no_hypothesis_is_one_empty_world():
    empty = ranked_worlds(situation(()))
    assert [(w.probability, w.present) for w in empty.worlds] == [(1.0, ())]
    assert list(stock(program_text(situation(())) + "query(noise(a1)).").values()) == [0.0]
