"""A program is read once for many questions: what one question brings is not there for the next."""

from __future__ import annotations

import pytest

from plogic.logic.grounding.indexed_clauses import Reader, UnsupportedError
from plogic.logic.grounding.load import by_problog, quickly, request_from
from plogic.logic.safety.check import parse
from plogic.logic.served.program_child import serve

PROGRAM = """
0.5::a(1). 0.2::a(2). b(X) :- a(X), \\+ c(X). 0.3::c(1).
constraint(one) :- a(2). 0.5::constraint_may_fail(one). constraint_may_fail(_) :- fail.
unlawful :- constraint(N), \\+ constraint_may_fail(N). evidence(\\+ unlawful).
"""
RULES = "0.9::d(X) :- b(X). constraint(two) :- a(1), a(2). evidence(a(1))."


def asked(*texts, goals=("b(X)",), given=()):
    return {
        "texts": [{"text": text, "file": f"{i}.pl"} for i, text in enumerate(texts)],
        "goals": goals,
        "given": given,
    }


def test_what_is_added_for_one_question_is_gone_with_the_next():
    """A constraint more, of a predicate that the program has; evidence; an observation; other goals."""
    alone, more = asked(PROGRAM), asked(PROGRAM, RULES, goals=("b(X)", "d(1)", "constraint(N)"))
    before = serve(alone)
    assert len(before["answers"][0]) == 2
    first = serve(more)
    assert first["answers"][0] != before["answers"][0]
    assert serve(asked(PROGRAM, given=("c(1)",)))["answers"] != before["answers"]
    assert serve(alone) == before
    assert serve(more) == first


@pytest.mark.parametrize("texts", [(PROGRAM,), (PROGRAM, RULES)], ids=["alone", "with rules"])
def test_asked_again_it_is_ground_as_by_problog(texts):
    def ground(by):
        found = by(request_from(asked(*texts)))
        return sorted(str(name) for name, literal in found.asked if literal is not None), len(found.observed)

    assert ground(quickly) == ground(quickly) == ground(by_problog)
    assert len(ground(quickly)[0]) == 2


def test_a_reader_that_goes_on_leaves_the_other_as_it_was():
    before = Reader()
    for statement in parse("p(a). p(b). q(X) :- p(X).").statements:
        before.add(statement)
    p = before.predicates["p", 1]
    assert len(p.matching((0,), ("a",))) == 1
    after = Reader(before)
    for statement in parse("p(a) :- q(c). 0.5::r('a b').").statements:
        after.add(statement)
    assert (len(p.rules), len(p.matching((0,), ("a",))), p.facts) == (2, 1, True)
    assert before.predicates.keys() == {("p", 1), ("q", 1)}
    mine = after.predicates["p", 1]
    assert (len(mine.rules), len(mine.matching((0,), ("a",))), mine.facts) == (3, 2, False)
    assert after.predicates["q", 1] is before.predicates["q", 1]
    with pytest.raises(UnsupportedError):
        after.add(parse("'p'(c).").statements[0])
    before.add(parse("p(c).").statements[0])
