"""Negations and arithmetic of goals, of evidence and of rules that calls leave open are told before they mislead."""

from __future__ import annotations

import pytest
from in_process import told as said

from plogic.logic.safety.notes import notes, notes_on_goals
from plogic.logic.served.program_child import reply_to

WORLD = "0.5::sick(ann). 0.3::sick(bob). person(ann). person(bob). age(ann, 4).\n"


@pytest.mark.parametrize(
    ("goal", "told"),
    [
        (
            "\\+ sick(X), person(X)",
            "goal:1:1: \\+ sick(X) is asked before X has a value, of all values at once: write it",
        ),
        ("(\\+ sick(X), person(X)) ; sick(X)", "goal:1:2: \\+ sick(X) is asked before X has a value"),
        ("person(Y), (\\+ sick(X) ; age(X, 4)), person(X)", "goal:1:13: \\+ sick(X) is asked before X has a value"),
        ("call(\\+ sick(X)), person(X)", "goal:1:6: \\+ sick(X) is asked before X has a value"),
        ("not(sick(X)), person(X).", "not(sick(X)) is asked before X has a value"),
        ("X \\= ann, person(X)", "X\\=ann is asked before X has a value"),
    ],
)
def test_a_negation_in_a_goal_that_is_asked_too_early_is_told(goal, told):
    (line,) = notes_on_goals({"goal": goal})
    assert told in line
    assert line.endswith("write it after person(X)")


@pytest.mark.parametrize(
    "goal",
    ["person(X), \\+ sick(X)", "\\+ sick(X)", "\\+ sick(ann), person(X)", "\\+ sick(X", "a ; \\+ sick(_)", "sick(X)"],
)
def test_a_goal_that_may_be_meant_is_not_told(goal):
    assert notes_on_goals({"goal": goal}) == []


@pytest.mark.parametrize(
    ("rules", "goals"),
    [
        ("well(X) :- \\+ sick(X).\nsome :- well(Y), person(Y).", ("some",)),
        ("well(X) :- \\+ sick(X).", ("well(Y), person(Y)",)),
        ("well(X) :- \\+ sick(X).\nfine(X) :- well(X).\nsome :- fine(Y), person(Y).", ("some",)),
    ],
)
def test_a_rule_that_is_called_before_its_variable_has_a_value_is_told_what_binds_it(rules, goals):
    (line,) = notes(WORLD + rules, "u.pl", goals)
    where = "u.pl:2:12: \\+ sick(X) is asked before X has a value, of all values at once: "
    assert line == f"{where}write the call of well(X) after person(Y)"


@pytest.mark.parametrize(
    ("rules", "goals"),
    [
        ("well(X) :- \\+ sick(X).\nsome :- person(Y), well(Y).", ("some",)),
        ("well(X) :- \\+ sick(X).", ("well(ann), person(Y)",)),
        ("none(X) :- \\+ sick(X).\nquery(none(_)).", ()),
    ],
)
def test_a_rule_that_is_called_with_a_value_or_that_nothing_binds_is_not_told(rules, goals):
    assert notes(WORLD + rules, "u.pl", goals) == []


def reason(text, *goals):
    request = {"texts": [{"text": WORLD + text, "file": "u.pl"}], "goals": goals, "given": [], "names": None}
    error = reply_to(request)["error"]
    return f"{error['file']}:{error['line']}:{error['column']}: {error['reason']}"


@pytest.mark.parametrize(
    ("text", "goals", "told"),
    [
        (
            "",
            ["X is Y + 1, age(ann, Y)"],
            "goal:1:3: X is Y+1 is computed before Y has a value: write it after age(ann,Y)",
        ),
        ("", ["Y > 3, age(ann, Y)"], "goal:1:3: Y>3 is computed before Y has a value: write it after age(ann,Y)"),
        (
            "",
            ["person(X) ; X is Y + 1, age(X, Y)"],
            "goal:1:15: X is Y+1 is computed before Y has a value: write it after",
        ),
        (
            "old(N) :- N is M + 1, age(_, M).",
            ["old(N)"],
            "u.pl:2:13: N is M+1 is computed before M has a value: write it after",
        ),
        (
            "old(N) :- N > 3.",
            ["old(N)"],
            "u.pl:2:13: N>3 is computed before N has a value, and no goal of this body gives it",
        ),
        ("", ["X is Y + 1"], "goal:1:3: X is Y+1 is computed before Y has a value, and no goal of this body gives it"),
    ],
)
def test_what_is_computed_too_early_is_told_in_words(text, goals, told):
    assert reason(text, *goals).startswith(told)


def test_commands_tell_it_of_goals_and_of_evidence(tmp_path):
    path = tmp_path / "u.pl"
    path.write_text(WORLD)
    lines = said("query", path, "\\+ sick(X), person(X)", "person(X)", "--given", "\\+ sick(Z), person(Z)")
    early = [line for line in lines if "is asked before" in line]
    assert [line.partition(": ")[0] for line in early] == ["goal 1:1:1", "given:1:1"]


def test_a_variable_of_only_some_alternatives_is_named(tmp_path):
    path = tmp_path / "u.pl"
    path.write_text(WORLD)
    lines = said("query", path, "person(Y), (\\+ sick(X) ; age(X, 4))")
    assert lines[-1].endswith(
        "the goal keeps a variable that nothing binds; only some of its alternatives give X a value"
    )
