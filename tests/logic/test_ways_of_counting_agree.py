"""Tables, diagrams and the circuit give the probabilities that going through every total choice gives."""

from __future__ import annotations

import math

import pytest
from drawn_programs import programs as alternatives_programs
from hypothesis import given, settings
from hypothesis import strategies as st
from random_programs import ATOMS, programs, worlds

from plogic.base.errors import InconsistentError
from plogic.inference.order import elimination_order
from plogic.logic.answers import by_tables as by_tables_module
from plogic.logic.answers import ways
from plogic.logic.answers.answer import answers_of_text
from plogic.logic.answers.by_diagrams import Diagrams, GiveUpError, blocks
from plogic.logic.answers.by_tables import tables_of
from plogic.logic.dnnf.cnf import propagated
from plogic.logic.dnnf.compiled import compiled
from plogic.logic.grounding.ground_program import Gate
from plogic.logic.grounding.load import ground, request_from

GRAPH = (
    "0.4::e(a,b). 0.5::e(b,c). 0.6::e(c,a). 0.3::e(c,d). 0.2::e(d,b).\np(X,Y) :- e(X,Y).\np(X,Y) :- e(X,Z), p(Z,Y).\n"
)


def request(text):
    return request_from({"texts": [{"text": text, "file": "program"}]})


def by_tables(text):
    found = ground(request(text))
    return found, tables_of(found, known(found), 30.0)


def by_diagrams(text, *, cyclic):
    found = ground(request(text), cyclic=cyclic)
    return found, Diagrams(found, known(found), 10**6)


def by_circuit(text):
    found = ground(request(text))
    return found, compiled(found)


def known(found):
    made = propagated(found)
    if made is None:
        raise InconsistentError
    return made


WAYS = {
    "tables": by_tables,
    "diagrams": lambda text: by_diagrams(text, cyclic=False),
    "diagrams of cycles": lambda text: by_diagrams(text, cyclic=True),
    "circuit": by_circuit,
}


def answers(way, text):
    """None where the evidence is impossible."""
    try:
        found, counted = WAYS[way](text)
        values = counted.probabilities([literal for _, literal in found.asked])
    except InconsistentError:
        return None
    return {str(name): p for (name, _), p in zip(found.asked, values, strict=True)}


@pytest.mark.parametrize("way", WAYS)
@settings(derandomize=True, deadline=None, max_examples=80)
@given(alternatives_programs())
def test_of_programs_with_alternatives_and_evidence(way, drawn):
    held = drawn.held()
    mass = math.fsum(p for p, _ in held)
    expected = {a: math.fsum(p for p, true in held if a in true) / mass for a in drawn.queries} if held else None
    try:
        found = answers(way, drawn.text)
    except Exception as error:
        if held or type(error).__name__ != "InconsistentEvidenceError":
            raise
        found = None  # the evidence is a constant that contradicts it
    assert found == (None if expected is None else pytest.approx(expected, abs=1e-12))


@pytest.mark.parametrize("way", WAYS)
@settings(derandomize=True, deadline=None, max_examples=120)
@given(programs(), st.integers(0, ATOMS - 1), st.booleans())
def test_of_programs_with_cycles_and_evidence(way, clauses, atom, value):
    heads = {f"a{head}" for clause in clauses for head in clause.heads}
    undefined = "".join(f"a{i} :- fail.\n" for i in range(ATOMS) if f"a{i}" not in heads)
    asked = "".join(f"query(a{i}).\n" for i in range(ATOMS))
    text = (
        "\n".join(clause.text() for clause in clauses)
        + f"\n{undefined}{asked}evidence(a{atom},{str(value).lower()}).\n"
    )
    held = [(p, true) for p, _, true in worlds(clauses) if (atom in true) == value]
    mass = math.fsum(p for p, _ in held)
    expected = {f"a{i}": math.fsum(p for p, true in held if i in true) / mass for i in range(ATOMS)} if held else None
    try:
        found = answers(way, text)
    except Exception as error:
        if held or type(error).__name__ != "InconsistentEvidenceError":
            raise
        found = None
    assert found == (None if expected is None else pytest.approx(expected, abs=1e-12))


def test_a_graph_is_grounded_with_its_cycles_and_answered_without_unrolling_them(monkeypatch):
    text = GRAPH + "query(p(a,d)). query(p(d,d))."
    assert ground(request(text), cyclic=True).cyclic
    assert not ground(request(text)).cyclic
    expected = answers("circuit", text)
    monkeypatch.setattr(by_tables_module, "tables_of", None)
    assert answers_of_text(text) == pytest.approx(expected, abs=1e-12)


def test_diagrams_that_grow_too_large_give_up_at_the_same_place_and_another_way_answers(monkeypatch):
    text = GRAPH + "query(p(a,d)). evidence(p(b,a))."
    expected = answers("circuit", text)
    found = ground(request(text), cyclic=True)
    with pytest.raises(GiveUpError):
        Diagrams(found, known(found), 2)
    monkeypatch.setattr(ways, "MANY", 2)
    assert answers_of_text(text + "% again") == pytest.approx(expected, abs=1e-12)
    monkeypatch.setattr(ways, "FIRST", 2)
    monkeypatch.setattr(ways, "FEW", 2)
    monkeypatch.setattr(by_tables_module, "tables_of", lambda *_: None)
    assert answers_of_text(text + "% and again") == pytest.approx(expected, abs=1e-12)


def test_a_grid_that_no_circuit_manages_is_summed_over_tables():
    side = 9
    cells = [(i, j) for i in range(side) for j in range(side)]
    edges = [f"0.5::e({i},{j},{i},{j + 1})." for i, j in cells if j + 1 < side]
    edges += [f"0.5::e({i},{j},{i + 1},{j})." for i, j in cells if i + 1 < side]
    text = "\n".join(edges) + "\np(0,0). p(K,L) :- e(I,J,K,L), p(I,J).\n" + f"query(p({side - 1},{side - 1}))."
    chance = answers_of_text(text)[f"p({side - 1},{side - 1})"]
    assert chance == pytest.approx(_reached(side), abs=1e-12)


def _reached(side):
    """P(the last cell of the grid is reached), swept diagonal by diagonal over the sets of cells that are reached."""
    states = {frozenset({(0, 0)}): 1.0}
    for total in range(1, 2 * side - 1):
        cells = [(i, total - i) for i in range(side) if 0 <= total - i < side]
        after = {}
        for true, p in states.items():
            options = {frozenset(): p}
            for i, j in cells:
                open_ = ((i - 1, j) in true) + ((i, j - 1) in true)
                holds = 1.0 - 0.5**open_
                grown = {}
                for some, q in options.items():
                    grown[some | {(i, j)}] = grown.get(some | {(i, j)}, 0.0) + q * holds
                    grown[some] = grown.get(some, 0.0) + q * (1.0 - holds)
                options = {some: q for some, q in grown.items() if q}
            for some, q in options.items():
                after[some] = after.get(some, 0.0) + q
        states = after
    return sum(p for true, p in states.items() if true)


def test_blocks_come_after_those_that_they_depend_on():
    gates = {
        1: Gate("or", (2, 5)),
        2: Gate("and", (3, 4)),
        3: Gate("or", (2, 6)),
        4: Gate("or", (7, None)),
        8: Gate("and", (1, -4)),
    }
    found = blocks(gates)
    assert [sorted(block) for block in found] == [[4], [2, 3], [1], [8]]


def test_an_order_past_the_limit_is_refused_before_it_is_found():
    from itertools import combinations

    from plogic.base.errors import WidthError

    everything = list(combinations(range(12), 2))
    assert elimination_order((2,) * 12, everything, most=12.0).width == 12.0
    with pytest.raises(WidthError, match=r"12\.0 bits; the limit is 11"):
        elimination_order((2,) * 12, everything, most=11.0)
