"""``plogic worlds`` and ``plogic query`` on programs: what is printed, and the exit status."""

from __future__ import annotations

import json

import pytest
from in_process import told

from plogic.base.errors import InconsistentError, UnsafeProgramError
from plogic.face.commands.asking import query_command, worlds_command
from plogic.face.shown.options import Asking

PROGRAM = """0.1::burglary. 0.2::earthquake.
0.7::alarm :- burglary.
0.3::alarm :- earthquake.
0.5::calls(mary) :- alarm.
evidence(calls(mary)).
query(burglary). query(earthquake).
"""
ASKED = Asking()


@pytest.fixture
def program(tmp_path):
    path = tmp_path / "alarm.pl"
    path.write_text(PROGRAM)
    return str(path)


def worlds(source, number=10, given=(), **options):
    text, status = worlds_command(source, number, given, Asking(**options), as_json=True)
    return json.loads(text), status


def test_worlds_of_a_program(program):
    found, status = worlds(program)
    assert (found["format"], status, found["unlisted_mass"]) == ("worlds/1", 0, [0.0, 0.0])
    assert [world["true"] for world in found["worlds"]] == [["burglary"], ["earthquake"], ["burglary", "earthquake"]]
    assert found["worlds"][0]["choices"] == [
        "burglary",
        "\\+earthquake",
        "alarm (line 2)",
        "\\+alarm (line 3)",
        "calls(mary)",
    ]
    assert found["worlds"][1]["choices"] == [
        "\\+burglary",
        "earthquake",
        "alarm (line 2)",
        "alarm (line 3)",
        "calls(mary)",
    ]
    assert sum(world["probability"] for world in found["worlds"]) == pytest.approx(1.0)
    few, _ = worlds(program, 1)
    assert few["unlisted_mass"] == pytest.approx([1 - found["worlds"][0]["probability"]] * 2)


def test_worlds_given_more_evidence(program):
    found, _ = worlds(program, given=["\\+ burglary"])
    assert [world["true"] for world in found["worlds"]] == [["earthquake"]]
    with pytest.raises(InconsistentError):
        worlds(program, given=["\\+ burglary", "\\+ earthquake"])


def test_the_table_says_what_is_not_listed(program):
    text, _ = worlds_command(program, 1, (), ASKED, as_json=False)
    assert "not listed" in text
    assert "earthquake" in text


def test_a_deadline_that_is_over_is_said(program):
    found, status = worlds(program, deadline=1e-6)
    assert (found["worlds"], found["unlisted_mass"], status, found["deadline"]) == ([], [1.0, 1.0], 3, "reached")
    text, status = query_command(program, ["burglary"], (), Asking(deadline=1e-6), as_json=True)
    assert status == 3
    assert json.loads(text)["answers"] == [{"goal": "burglary", "probability": 0.5, "interval": [0.0, 1.0]}]
    shown, _ = query_command(program, [], (), Asking(deadline=1e-6), as_json=False)
    assert "The deadline was reached" in shown


def test_a_deadline_that_suffices_changes_nothing(program):
    exact = query_command(program, [], (), ASKED, as_json=True)
    assert query_command(program, [], (), Asking(deadline=60.0), as_json=True) == exact
    assert worlds(program, deadline=60.0) == worlds(program)


def test_trust_is_handed_down(tmp_path):
    (tmp_path / "more.pl").write_text("0.25::b.\n")
    path = tmp_path / "u.pl"
    path.write_text(":- consult('more.pl').\nquery(b).\n")
    with pytest.raises(UnsafeProgramError):
        query_command(str(path), [], (), ASKED, as_json=True)
    text, _ = query_command(str(path), [], (), Asking(trust=True), as_json=True)
    assert [(a["goal"], a["probability"]) for a in json.loads(text)["answers"]] == [("b", 0.25)]


CONSTRAINED = "0.5::a. 0.5::b.\n{}\nquery(a). query(b).\n"


@pytest.mark.parametrize(
    ("clause", "said"),
    [
        (
            ":- a, b.",
            "2:5: a clause without a head excludes no world: write excluded :- a, b. evidence(\\+ excluded).",
        ),
        (
            "constraint(both) :- a, b.",
            "2:1: constraint(both) excludes no world in a plain program: move it to a file of rules, --rules FILE, where it does",
        ),
    ],
)
@pytest.mark.parametrize("command", [("query",), ("worlds",), ("explain", "a")], ids=lambda c: c[0])
def test_what_only_looks_like_a_constraint_is_said_to_exclude_nothing(tmp_path, command, clause, said):
    path = tmp_path / "u.pl"
    path.write_text(CONSTRAINED.format(clause))
    name, *goal = command
    assert f"{path}:{said}" in told(name, path, *goal)


def test_a_recursion_that_cannot_end_is_told_of_a_program_and_of_rules_though_nobody_asks_it(tmp_path):
    plain, rules = tmp_path / "u.pl", tmp_path / "rules.pl"
    rules.write_text("fact(0, 1).\nfact(N, F) :- M is N - 1, fact(M, G), F is N * G.\n")
    plain.write_text("0.5::a.\nquery(a).\n")
    assert f"{rules}:2:27: fact/2 calls itself without end" in "\n".join(told("query", plain, "--rules", rules))
    plain.write_text(f"0.5::a.\nquery(a).\n{rules.read_text()}")
    assert f"{plain}:4:27: fact/2 calls itself without end" in "\n".join(told("query", plain))


def test_a_findall_is_answered_as_a_goal_and_as_a_rule(tmp_path):
    path, rules = tmp_path / "u.pl", tmp_path / "rules.pl"
    path.write_text("0.25::a(1).\na(2).\n")
    goal = "findall(X, a(X), L), length(L, N)"
    rules.write_text(f"n(N) :- {goal}.\n")
    (one, two) = (row for row in told("query", path, goal) if row.strip().startswith("0."))
    assert one.split(maxsplit=1) == ["0.750", "findall(X,a(X),[2]), length([2],1)"]
    assert two.split(maxsplit=1) == ["0.250", "findall(X,a(X),[1, 2]), length([1, 2],2)"]
    rows = [line.split() for line in told("query", path, "n(N)", "--rules", rules)]
    assert [row for row in rows if row[1:] and row[1].startswith("n(")] == [["0.750", "n(1)"], ["0.250", "n(2)"]]


def test_a_findall_whose_answers_keep_a_variable_open_is_told_what_to_write(tmp_path):
    path = tmp_path / "u.pl"
    path.write_text("0.25::a(1).\na(2).\n")
    assert "write it as a rule, n(N) :- findall(...)" in told("query", path, "findall(X-Y, a(X), L)")[-1]


def test_what_is_advised_instead_excludes_worlds(tmp_path):
    plain, advised, rules = (tmp_path / name for name in ("plain.pl", "advised.pl", "rules.pl"))
    plain.write_text(CONSTRAINED.format(""))
    advised.write_text(CONSTRAINED.format("excluded :- a, b. evidence(\\+ excluded)."))
    rules.write_text("constraint(both) :- a, b.\n")
    for args in ((advised,), (plain, "--rules", rules)):
        lines = told("query", *args)
        assert not [line for line in lines if "excludes no world" in line]
        assert [line.split() for line in lines if " a" in line or " b" in line][-2:] == [["0.333", "a"], ["0.333", "b"]]


def test_a_library_that_is_loaded_is_no_such_thing(tmp_path):
    path = tmp_path / "u.pl"
    path.write_text(":- use_module(library(lists)).\n0.5::a :- member(x, [x]).\nquery(a).\n")
    assert not [line for line in told("query", path) if "excludes no world" in line]
