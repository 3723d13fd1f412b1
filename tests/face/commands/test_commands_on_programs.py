"""``plogic worlds`` and ``plogic query`` on programs: what is printed, and the exit status."""

from __future__ import annotations

import json

import pytest

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
    text, status = query_command(program, "burglary", (), Asking(deadline=1e-6), as_json=True)
    assert status == 3
    assert json.loads(text)["answers"] == [{"goal": "burglary", "probability": 0.5, "interval": [0.0, 1.0]}]
    shown, _ = query_command(program, None, (), Asking(deadline=1e-6), as_json=False)
    assert "The deadline was reached" in shown


def test_a_deadline_that_suffices_changes_nothing(program):
    exact = query_command(program, None, (), ASKED, as_json=True)
    assert query_command(program, None, (), Asking(deadline=60.0), as_json=True) == exact
    assert worlds(program, deadline=60.0) == worlds(program)


def test_trust_is_handed_down(tmp_path):
    (tmp_path / "more.pl").write_text("0.25::b.\n")
    path = tmp_path / "u.pl"
    path.write_text(":- consult('more.pl').\nquery(b).\n")
    with pytest.raises(UnsafeProgramError):
        query_command(str(path), None, (), ASKED, as_json=True)
    text, _ = query_command(str(path), None, (), Asking(trust=True), as_json=True)
    assert [(a["goal"], a["probability"]) for a in json.loads(text)["answers"]] == [("b", 0.25)]
