"""The ranked worlds of programs: against every total choice, and by their laws."""

from __future__ import annotations

import math
from itertools import pairwise

import pytest
from drawn_programs import programs
from hypothesis import assume, given, settings

from plogic.base.errors import InconsistentError
from plogic.logic.answers.state_ranking import ranked
from plogic.logic.served.engine import Text
from plogic.logic.served.program_worlds import program_worlds


def worlds(text, number=10_000, **options):
    return ranked({"texts": [{"text": text, "file": "program"}], "number": number, **options})["worlds"]


def grouped(drawn):
    """Total mass, the best total choice's probability and the mass of each set of query atoms."""
    groups: dict[frozenset[str], list[float]] = {}
    for p, true in drawn.held():
        groups.setdefault(frozenset(atom for atom in drawn.queries if atom in true), []).append(p)
    mass = sum(sum(ps) for ps in groups.values())
    return (
        mass,
        {atoms: sum(ps) / mass for atoms, ps in groups.items()},
        {atoms: max(ps) for atoms, ps in groups.items()},
    )


@settings(derandomize=True, deadline=None, max_examples=120)
@given(programs())
def test_worlds_equal_those_of_every_total_choice(drawn):
    assume(drawn.held())
    _, expected, _ = grouped(drawn)
    found = worlds(drawn.text)
    assert {frozenset(world["holds"]): world["p"] for world in found} == pytest.approx(expected, abs=1e-9)
    assert len(found) == len(expected)
    assert all(a["p"] >= b["p"] * (1 - 1e-10) for a, b in pairwise(found))


@settings(derandomize=True, deadline=None, max_examples=60)
@given(programs())
def test_the_choices_of_a_world_are_possible_and_lead_to_it(drawn):
    assume(drawn.held())
    found = worlds(drawn.text)
    assert found
    _, _, best = grouped(drawn)
    for world in found:
        chosen = set(world["choices"])
        fitting = [
            p
            for p, true in drawn.held()
            if _made(chosen, true) and {q for q in drawn.queries if q in true} == set(world["holds"])
        ]
        assert fitting
        assert sum(fitting) >= best[frozenset(world["holds"])] * (1 - 1e-9)


def _made(choices, true):
    return all((text.removeprefix("\\+") in true) != text.startswith("\\+") for text in choices)


@settings(derandomize=True, deadline=None, max_examples=60)
@given(programs())
def test_a_shorter_list_is_the_beginning_of_the_longer(drawn):
    assume(drawn.held())
    everything = worlds(drawn.text)
    for number in (1, 2, 5):
        assert [w["holds"] for w in worlds(drawn.text, number)] == [w["holds"] for w in everything[:number]]


def test_many_independent_atoms_are_ranked_without_going_through_all():
    n = 60
    text = "".join(f"0.6::a({i}). query(a({i})).\n" for i in range(n))
    found = worlds(text, 100)
    assert len(found) == 100
    assert found[0]["p"] == pytest.approx(0.6**n)
    assert all(world["p"] == pytest.approx(0.6 ** (n - 1) * 0.4) for world in found[1 : n + 1])
    assert [len(world["holds"]) for world in found] == [n] + [n - 1] * n + [n - 2] * (99 - n)
    assert "a(59)" not in found[1]["holds"]


def test_evidence_and_the_mass_that_is_not_listed():
    text = Text("0.3::a. 0.4::b. c :- a. c :- b. query(a). query(b).", "u.pl")
    ranking = program_worlds(text, 2, given=["c"])
    mass = 1 - 0.7 * 0.6
    assert [(w.holds, w.choices) for w in ranking.worlds] == [(("b",), ("\\+a", "b")), (("a",), ("a", "\\+b"))]
    assert [w.probability for w in ranking.worlds] == pytest.approx([0.28 / mass, 0.18 / mass])
    assert ranking.unlisted == pytest.approx((0.12 / mass,) * 2)
    assert ranking.log_evidence == pytest.approx(math.log(mass))
    assert ranking.complete
    with pytest.raises(InconsistentError):
        program_worlds(text, given=["c", "\\+ a", "\\+ b"])


def test_a_program_that_asks_nothing_is_asked_for_what_is_probable():
    ranking = program_worlds(Text("0.3::a(1). 0.6::b; 0.4::c. d :- a(1)."), 10)
    assert ranking.worlds[0].holds == ("b",)
    assert ranking.unlisted == (0.0, 0.0)
    assert len(ranking.worlds) == 4


def test_goals_distinguish_worlds():
    ranking = program_worlds(Text("0.3::a(1). 0.6::a(2). b(X) :- a(X), X > 1. query(a(1))."), 10, goals=["b(X)"])
    assert [(w.holds, w.probability) for w in ranking.worlds] == [
        (("b(2)",), pytest.approx(0.6)),
        ((), pytest.approx(0.4)),
    ]


def test_a_choice_whose_head_other_clauses_give_too_is_told_with_its_line():
    """Alarm may hold though its own choice fell: the bare head would not tell which of the two is meant."""
    text = "0.1::burglary.\n0.2::quake.\nalarm :- burglary.\n0.3::alarm :- quake.\nevidence(alarm).\nquery(burglary).\n"
    best = program_worlds(Text(text), 1).worlds[0]
    assert best.holds == ("burglary",)
    assert "\\+alarm (line 4)" in best.choices
    assert "burglary" in best.choices


def test_choices_that_have_nothing_to_do_with_what_is_asked_are_not_listed():
    alone = "0.5::d. 0.9::e. f :- d. f :- e. evidence(f).\n"
    tied = "0.3::a. 0.4::b; 0.1::c. t :- a. t :- c. evidence(t).\n"
    found = worlds(f"{alone}{tied}query(a).")
    assert [world["choices"] for world in found] == [["a", "\\+c"], ["\\+a", "c"]]
