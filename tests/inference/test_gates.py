"""Formulas made part of a graph, against their truth in every joint state."""

import itertools
import math

import numpy as np
import pytest
from factor_graphs import log_weight
from hypothesis import given, settings
from hypothesis import strategies as st

from plogic.inference.gates import And, Literal, Not, Or, observed, probability, with_formulas
from plogic.inference.graph import Factor, FactorGraph
from plogic.inference.marginals import beliefs

LAW = settings(derandomize=True, deadline=None, max_examples=100)
CARDS = (2, 3, 2, 1, 4)

literals = st.builds(
    Literal,
    st.integers(0, len(CARDS) - 1),
    st.frozensets(st.integers(0, 3), max_size=3),
)
formulas = st.recursive(
    literals,
    lambda part: st.one_of(
        part.map(Not),
        st.lists(part, max_size=4).map(lambda parts: And(tuple(parts))),
        st.lists(part, max_size=4).map(lambda parts: Or(tuple(parts))),
    ),
    max_leaves=8,
)


def holds(formula, states):
    match formula:
        case Literal(variable, inside):
            return states[variable] in inside
        case Not(part):
            return not holds(part, states)
        case And(parts):
            return all(holds(part, states) for part in parts)
        case Or(parts):
            return any(holds(part, states) for part in parts)


def weighed():
    numbers = np.random.default_rng(5)
    factors = [Factor((a, b), numbers.normal(size=(CARDS[a], CARDS[b]))) for a, b in ((0, 1), (1, 4), (2, 3))]
    factors[0].table[1, 2] = -np.inf
    return FactorGraph(CARDS, tuple(factors), -7.0)


def masses(graph, formula):
    """(Σ weights where the formula holds, Σ weights), by enumeration."""
    every = [(math.exp(log_weight(graph, s)), s) for s in itertools.product(*(range(c) for c in CARDS))]
    return math.fsum(w for w, s in every if holds(formula, s)), math.fsum(w for w, _ in every)


@LAW
@given(formulas)
def test_probability_of_a_formula(formula):
    graph, (literal,) = with_formulas(weighed(), (formula,))
    found = beliefs(graph)
    true, total = masses(weighed(), formula)
    assert probability(found, literal) == pytest.approx((true / total,) * 2, abs=1e-12)
    assert found.log_z[0] == pytest.approx(math.log(total), abs=1e-11)


@LAW
@given(formulas)
def test_holding_a_formula_true_conditions_on_it(formula):
    graph, (literal,) = with_formulas(weighed(), (formula,))
    found = beliefs(observed(graph, [literal]))
    true, _ = masses(weighed(), formula)
    assert found.log_z[0] == (pytest.approx(math.log(true), abs=1e-11) if true else -math.inf)
    if true:
        again = masses(weighed(), And((formula, Literal(4, frozenset({2})))))[0]
        assert found.low[4][2] == pytest.approx(again / true, abs=1e-12)


@LAW
@given(formulas, formulas)
def test_formulas_together_are_as_they_are_apart(left, right):
    graph, (one, other) = with_formulas(weighed(), (left, right))
    found = beliefs(graph)
    alone = [with_formulas(weighed(), (formula,)) for formula in (left, right)]
    for literal, (single, (expected,)) in zip((one, other), alone, strict=True):
        assert probability(found, literal) == pytest.approx(probability(beliefs(single), expected), abs=1e-12)


def test_equal_steps_are_made_once_and_no_factor_is_wide():
    parts = [Literal(v, frozenset({1})) for v in (0, 1, 2, 4)]
    graph, made = with_formulas(
        weighed(), (And(tuple(parts)), Not(And(tuple(reversed(parts)))), Or(tuple(Not(p) for p in parts)))
    )
    assert len(graph.cards) == len(CARDS) + 3
    assert made == (Literal(7, frozenset({1})), Literal(7, frozenset({0})), Literal(7, frozenset({0})))
    assert max(len(f.scope) for f in graph.factors) == 3


def test_a_deep_formula_needs_no_recursion():
    formula = Literal(0, frozenset({1}))
    for _ in range(5000):
        formula = Not(Or((formula,)))
    graph, (literal,) = with_formulas(weighed(), (formula,))
    assert (graph.cards, literal) == (CARDS, Literal(0, frozenset({1})))


def test_certain_formulas_are_answered_by_a_variable_of_one_state():
    graph, (true, false) = with_formulas(weighed(), (And(()), Or(())))
    found = beliefs(graph)
    assert graph.cards == (*CARDS, 1)
    assert (probability(found, true), probability(found, false)) == ((1.0, 1.0), (0.0, 0.0))
