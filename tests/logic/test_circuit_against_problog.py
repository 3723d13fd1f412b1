"""Answers from the circuit: against stock ProbLog, and against every total choice."""

from __future__ import annotations

import pytest
from drawn_programs import programs
from hypothesis import given, settings

from plogic.base.errors import InconsistentError
from plogic.logic.answers.answer import answers_of_text
from plogic.logic.dnnf import nnf
from plogic.logic.dnnf.compiled import compiled
from plogic.logic.grounding.load import by_problog, ground, quickly, request_from


def stock(text, *, sdd=False):
    from problog.ddnnf_formula import DDNNF
    from problog.engine import DefaultEngine
    from problog.program import PrologString
    from problog.sdd_formula import SDD

    engine = DefaultEngine()
    formula = engine.ground_all(engine.prepare(PrologString(text)))
    return {str(goal): p for goal, p in (SDD if sdd else DDNNF).create_from(formula).evaluate().items()}


def document(text):
    return {"texts": [{"text": text, "file": "program"}]}


def of(found):
    program = compiled(found)
    values = program.probabilities([literal for _, literal in found.asked])
    return {str(name): p for (name, _), p in zip(found.asked, values, strict=True)}


@settings(derandomize=True, deadline=None, max_examples=150)
@given(programs())
def test_answers_equal_those_of_every_total_choice(drawn):
    held = drawn.held()
    if not held:
        with pytest.raises(InconsistentError):
            answers_of_text(drawn.text)
        return
    mass = sum(p for p, _ in held)
    expected = {atom: sum(p for p, true in held if atom in true) / mass for atom in drawn.queries}
    assert answers_of_text(drawn.text) == pytest.approx(expected, abs=1e-9)


@settings(derandomize=True, deadline=None, max_examples=60)
@given(programs())
def test_our_grounder_and_problogs_ground_to_the_same(drawn):
    request = request_from(document(drawn.text))
    if drawn.held():
        assert of(quickly(request)) == pytest.approx(of(by_problog(request)), abs=1e-12)


PROGRAMS = {
    "smokers": """person(1). person(2). person(3). friend(1,2). friend(2,1). friend(2,3). friend(3,2).
        0.3::stress(X) :- person(X). 0.2::influences(X,Y) :- person(X), person(Y), X \\= Y.
        smokes(X) :- stress(X). smokes(X) :- friend(X,Y), influences(Y,X), smokes(Y).
        0.4::asthma(X) :- smokes(X). evidence(smokes(2)). query(smokes(X)) . query(asthma(_)).""",
    "body variables make choices": "0.4::a(X) :- b(X,Y). b(1,1). b(1,2). 0.5::b(2,1). query(a(1)). query(a(2)).",
    "labels from the body": "p(a,0.2). p(b,0.7). P::x(A) :- p(A,P). (P*P)::y(A) :- p(A,P). query(x(_)). query(y(_)).",
    "disjunctions in bodies": "0.3::a. 0.4::b. 0.5::c. d :- (a ; b, \\+ c), \\+ (a, c). query(d). evidence(\\+ (x)). x :- a, b, c.",
    "terms": "0.3::e(f(1,g(X))) :- d(X). d(u). d(v-w). k(X) :- e(f(_,g(X))). query(k(X)). query(e(f(1,g(v-w)))).",
    "repeated variables": "0.5::q(X,Y) :- d(X), d(Y). d(1). d(2). same(X) :- q(X,X). query(same(Z)). t :- q(A,A), \\+ q(A,B), d(B). query(t).",
    "arithmetic": "n(1). n(2). n(3). 0.5::k(N) :- n(N). s(S) :- k(A), k(B), A < B, S is A*10+B. query(s(X)).",
    "big alternative": "; ".join(f"0.05::a({i})" for i in range(18))
    + ". b :- a(X), X > 3. evidence(b). query(a(3)). query(a(17)). query(b).",
    "certain": "a. b :- a, \\+ c. 0.0::c. 1.0::d. query(a). query(b). query(c). query(d).",
    "evidence by value": "0.3::a. 0.4::b. c :- a. c :- b. evidence(c, true). evidence(b, false). query(a).",
    "negative query": "0.3::a. query(\\+ a). query(a).",
    "contradictions": """0.3::h. 0.4::p(1). 0.5::p(2). d(1). d(2). r(X) :- d(X), \\+ h, p(X), (h ; X = 2).
        s(X) :- p(X), \\+ p(X). query(r(1)). query(s(1)).""",
    "plain word": "0.3::a('B c'). query(a(X)).",
}


@pytest.mark.parametrize("name", PROGRAMS)
def test_answers_equal_stock_problogs(name):
    assert answers_of_text(PROGRAMS[name]) == pytest.approx(stock(PROGRAMS[name]), abs=1e-9)


@pytest.mark.parametrize("name", ["smokers", "big alternative", "terms"])
def test_where_dsharp_fails_the_sdd_gives_the_same(name, monkeypatch):
    monkeypatch.setattr(nnf, "_dsharp", lambda bundles: [None] * len(bundles))
    assert answers_of_text(PROGRAMS[name]) == pytest.approx(stock(PROGRAMS[name], sdd=True), abs=1e-9)


def test_one_compilation_answers_under_any_conditions():
    drawn = "0.3::a. 0.4::b. 0.2::c; 0.5::d. e :- a, \\+ c. f :- b. f :- d. query(a). query(b). query(c). query(d). query(e). query(f)."
    found = ground(request_from(document(drawn)))
    program, literal = compiled(found), {str(name): key for name, key in found.asked}
    conditions = [("e", True), ("f", False), ("d", True), ("c", False)]
    for name, value in conditions:
        expected = stock(drawn + f" evidence({name}, {str(value).lower()}).")
        given_literal = literal[name] if value else -literal[name]
        values = program.probabilities([literal[key] for key in expected], given=[given_literal])
        assert dict(zip(expected, values, strict=True)) == pytest.approx(expected, abs=1e-9)
    masses = program.log_mass([[literal["e"]], [-literal["e"]], [literal["c"], literal["d"]]])
    assert sum(2.718281828459045 ** float(m) for m in masses) == pytest.approx(1.0)


def test_deep_programs_ground_without_recursion_errors():
    chain = "0.999::s(0). " + " ".join(f"s({i + 1}) :- s({i})." for i in range(3000)) + " query(s(3000))."
    assert answers_of_text(chain)["s(3000)"] == pytest.approx(0.999)
