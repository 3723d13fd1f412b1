"""Laws of observing, on random scenes: order is nothing, taking back restores every byte, refusing changes nothing."""

from __future__ import annotations

import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from situations import random_situations

from plogic.base.errors import InconsistentError
from plogic.face.session.session import Session
from plogic.scene.asking.query import answers


def shown(session):
    """Everything that a session says of who is present."""
    return [str(session.worlds(1000)), str(session.predict()), str(session.ask()), session.observed]


@st.composite
def scenes_with_evidence(draw):
    """A scene that is possible, and literals about its hypotheses, one each."""
    situation = draw(random_situations(most=4))
    try:
        with Session(situation) as session:
            session.worlds(1)
    except InconsistentError:
        assume(condition=False)
    names = draw(st.permutations([h.id for h in situation.hypotheses]))
    signs = draw(st.lists(st.sampled_from(["", "\\+ "]), min_size=len(names), max_size=len(names)))
    return situation, [f"{sign}present({name})" for sign, name in zip(signs, names, strict=True)]


def observe_what_is_possible(session, literals):
    """The literals that were taken; of a refused one nothing is left."""
    taken = []
    for literal in literals:
        before = shown(session)
        try:
            session.observe(literal)
            taken.append(literal)
        except InconsistentError:
            assert shown(session) == before
    return taken


@settings(max_examples=40, deadline=None, derandomize=True)
@given(scenes_with_evidence(), st.randoms(use_true_random=False))
def test_any_order_and_any_detour_come_to_the_same_bytes(drawn, random):
    situation, literals = drawn
    with Session(situation) as first, Session(situation) as second, Session(situation) as untouched:
        taken = observe_what_is_possible(first, literals)
        again = random.sample(taken, len(taken))
        for literal in again:
            second.observe(literal)
        assert shown(second)[:3] == shown(first)[:3]
        for literal in random.sample(taken, len(taken)):
            first.unobserve(literal)
        second.unobserve()
        assert shown(first) == shown(second) == shown(untouched)


@settings(max_examples=8, deadline=None, derandomize=True)
@given(scenes_with_evidence())
def test_predict_against_the_program_text(drawn):
    situation, literals = drawn
    with Session(situation) as session:
        taken = observe_what_is_possible(session, literals[:2])
        predicted = {row.goal: row.now.probability for row in session.predict("present(H)").predictions}
        expected = {a.goal: a.probability for a in answers(situation, "present(H)", given=taken)}
        assert {goal: p for goal, p in predicted.items() if p > 0} == pytest.approx(expected, abs=1e-9)


@settings(max_examples=40, deadline=None, derandomize=True)
@given(scenes_with_evidence())
def test_surprises_add_up_to_the_improbability_of_it_all(drawn):
    """P(a) P(b | a) ... is the mass, at first, of the worlds that are left."""
    situation, literals = drawn
    with Session(situation) as session:
        everything = session.worlds(1000)
        taken = [session.observe(literal) for literal in observe_what_is_possible(Session(situation), literals)]
        left = {row.present for row in session.worlds(1000).worlds}
        mass = sum(row.probability for row in everything.worlds if row.present in left)
        product = 1.0
        for result in taken:
            product *= result.probability
        assert product == pytest.approx(mass, abs=1e-9)
