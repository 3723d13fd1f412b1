"""Oracle: every total choice of small random programs.

Minimal, entailing, right in probability, and the best ones first.
"""

from __future__ import annotations

import itertools
import math

import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from random_programs import ATOMS, explanations, programs, worlds

from plogic.base.errors import InconsistentError
from plogic.logic.safety.author import load_problog

load_problog()

from problog.engine import DefaultEngine  # noqa: E402 - ProbLog is loaded first, without its warnings
from problog.eval_nodes import NegativeCycle  # noqa: E402
from problog.program import PrologString  # noqa: E402

from plogic.logic.grounding.load import goal_in, parsed, read  # noqa: E402
from plogic.logic.proof.cone import Steps  # noqa: E402
from plogic.logic.proof.goal_account import Accountant, Asked, Options  # noqa: E402
from plogic.logic.proof.relevant_evidence import numbers_of  # noqa: E402
from plogic.logic.served import prove  # noqa: E402

LAW = settings(derandomize=True, deadline=None, max_examples=60)


def ground_goal(program, goal, given):
    """A program's text, a goal and evidence, grounded: what ``account`` takes."""
    _, statements, known = read([{"text": program, "file": "program"}], None, trust=False, marked=False)
    wanted, *conditions = (goal_in(parsed(text, "goal"), None, known, trust=False) for text in (goal, *given))
    return prove._ground(statements, wanted, conditions, trust=False)


def accountant(text, goal, evidence, most):
    assume(stock_grounds(text, goal, evidence))
    ground, ask, shown = ground_goal(text, goal, evidence)
    instances = ground.ask(ask)
    asked = Asked(shown, ask, instances, ground.exists(ask))
    steps = Steps(10**7)
    numbers = numbers_of(ground, [*(key for _, key in instances), asked.any], steps)
    return Accountant(ground, asked, numbers, Options(most, 10**7, None))


def stock_grounds(text, goal, evidence):
    """ProbLog takes some positive cycles beside a negation for a negative one.

    What it does not ground, nobody has to explain.
    """
    observed = [f"e{i} :- {literal}. query(e{i})." for i, literal in enumerate(evidence)]
    try:
        DefaultEngine().ground_all(PrologString("\n".join([text, f"query({goal}).", *observed])))
    except NegativeCycle:
        return False
    return True


def written(found):
    return frozenset((choice.rule - 1, taken) for choice, taken in found.selection.items())


@LAW
@given(
    programs(),
    st.integers(0, ATOMS - 1),
    st.booleans(),
    st.dictionaries(st.integers(0, ATOMS - 1), st.booleans(), max_size=2),
)
def test_the_explanations_are_the_minimal_sets_of_choices_that_entail_the_goal(clauses, goal, wanted, evidence):
    text = "\n".join(clause.text() for clause in clauses)
    given_goals = [f"a{a}" if value else f"\\+ a{a}" for a, value in evidence.items()]
    expected = explanations(clauses, goal, wanted=wanted, evidence=evidence.items())
    if expected is None:
        with pytest.raises(InconsistentError):
            accountant(text, f"a{goal}", given_goals, 1)
        return
    expected = {choices: p for choices, p in expected.items() if p > 1e-13}
    teller = accountant(text, f"a{goal}", given_goals, 1000)
    chances = teller.numbers.compiled.probabilities(teller.numbers.literals)[:-1]
    found, stopped = teller.why(chances) if wanted else teller.search(None, wanted=False)
    assert not stopped
    assert {written(f): math.exp(f.log_given) for f in found} == pytest.approx(expected, abs=1e-9)
    ranked = [f.log_given for f in found]
    assert all(x >= y - 1e-9 for x, y in itertools.pairwise(ranked)), "best first"


@LAW
@given(programs(), st.integers(0, ATOMS - 1), st.integers(1, 3))
def test_the_first_k_are_the_k_best(clauses, goal, k):
    text = "\n".join(clause.text() for clause in clauses)
    best = sorted(explanations(clauses, goal, wanted=True, evidence=()).values(), reverse=True)[:k]
    teller = accountant(text, f"a{goal}", [], k)
    found, _ = teller.why(teller.numbers.compiled.probabilities(teller.numbers.literals)[:-1])
    assert [math.exp(f.log_given) for f in found] == pytest.approx(best, abs=1e-9)


@LAW
@given(programs(), st.integers(0, ATOMS - 1))
def test_what_all_explanations_cover_is_the_goal(clauses, goal):
    text = "\n".join(clause.text() for clause in clauses)
    truth = math.fsum(p for p, _, true in worlds(clauses) if goal in true)
    teller = accountant(text, f"a{goal}", [], 1000)
    chances = teller.numbers.compiled.probabilities(teller.numbers.literals)
    assert chances[-1] == pytest.approx(truth, abs=1e-9)
    covered = teller.covered(teller.why(chances[:-1])[0], chances[-1])
    assert covered["listed"] == pytest.approx([truth, truth], abs=1e-9)
    assert covered["unlisted"] == pytest.approx(0.0, abs=1e-9)


@LAW
@given(programs(), st.integers(0, ATOMS - 1), st.booleans())
def test_every_tree_ends_in_the_choices_of_its_explanation(clauses, goal, wanted):
    text = "\n".join(clause.text() for clause in clauses)
    teller = accountant(text, f"a{goal}", [], 3)
    chances = teller.numbers.compiled.probabilities(teller.numbers.literals)[:-1]
    found, _ = teller.why(chances) if wanted else teller.search(None, wanted=False)
    expected = explanations(clauses, goal, wanted=wanted, evidence=())
    assert bool(found) == any(p > 1e-13 for p in expected.values())
    for data in map(teller.data, found):
        nodes = list(flattened(data["tree"]))
        assert not any("plogic" in node["goal"] for node in nodes)
        if not any(node["kind"] == "cases" for node in nodes):
            used = {node["goal"] for node in nodes if node["kind"] == "choice"}
            heads = {choice.split(" :- ")[0] for choice in data["choices"]}
            assert heads <= used | {choice.split(" :- ")[0] for choice in used}, (
                "no choice without its place in the proof"
            )


def flattened(node):
    yield node
    for child in node["children"]:
        yield from flattened(child)
