"""``plogic query FILE GOAL GOAL2``: each as if it were asked alone, one after another, from one run."""

import json

import pytest
from situations import towers
from stock_worlds import stock

from plogic.base.errors import ProgramError
from plogic.face.commands.asking import query_command
from plogic.face.python.asking import Program
from plogic.face.shown.options import Asking
from plogic.logic.served import engine
from plogic.scene.asking.query import answers, answers_to_all, answers_to_all_until

PROGRAM = "0.3::a(1). 0.6::a(2). b :- a(1), a(2). c(X) :- a(X), \\+ b.\n"


@pytest.fixture
def program(tmp_path):
    path = tmp_path / "u.pl"
    path.write_text(PROGRAM)
    return str(path)


def asked(program, *goals, as_json=True, **options):
    return query_command(program, goals, (), Asking(**options), as_json=as_json)


def test_each_goal_has_a_line_in_their_order_with_what_problog_answers(program):
    text, status = asked(program, "c(X)", "b", "a(1)")
    documents = [json.loads(line) for line in text.splitlines()]
    assert (status, [document["asked"] for document in documents]) == (0, ["c(X)", "b", "a(1)"])
    found = [{row["goal"]: row["probability"] for row in document["answers"]} for document in documents]
    theirs = stock(f"{PROGRAM} query(c(_)). query(b). query(a(1)).")
    assert [*found[0], *found[1], *found[2]] == ["c(2)", "c(1)", "b", "a(1)"]
    assert {goal: p for some in found for goal, p in some.items()} == pytest.approx(theirs, abs=1e-9)


def test_one_goal_has_the_document_that_it_had(program):
    text, _ = asked(program, "b")
    row = f'{{"goal": "b", "probability": {0.3 * 0.6}, "interval": [{0.3 * 0.6}, {0.3 * 0.6}]}}'
    assert text == f'{{"format": "answers/1", "answers": [{row}]}}'


def test_tables_follow_one_another_and_each_says_what_it_answers(program):
    text, _ = asked(program, "b", "a(3)", "a(X)", as_json=False)
    lines = [line.strip() for line in text.splitlines()]
    assert [line for line in lines if line.startswith("answers")] == [
        "answers to b",
        "answers to a(3)",
        "answers to a(X)",
    ]
    assert lines.index("0.180   b") < lines.index("answers to a(3)") < lines.index("0.600   a(2)")


def test_all_are_ground_in_one_run(program, monkeypatch):
    runs, ask = [], engine._ask
    monkeypatch.setattr(engine, "_ask", lambda request, limits: runs.append(request) or ask(request, limits))
    found = Program.load(program).query_all(["b", "a(X)", "c(1)"])
    assert [answers.goal for answers in found] == ["b", "a(X)", "c(1)"]
    assert [request["goals"] for request in runs] == [["b", "a(X)", "c(1)"]]


@pytest.mark.parametrize("wrong", ["d(X)", "a(X", "", "b :- a"])
def test_a_mistake_says_in_which_goal_it_is(program, wrong):
    with pytest.raises(ProgramError, match=r"^goal 2(:\d+:\d+)?: "):
        asked(program, "b", wrong, "a(1)")


def test_a_deadline_is_for_all(program):
    assert asked(program, "b", "a(X)", deadline=60.0) == asked(program, "b", "a(X)")
    text, status = asked(program, "b", "a(1)", deadline=1e-6)
    documents = [json.loads(line) for line in text.splitlines()]
    assert (status, [d["deadline"] for d in documents]) == (3, ["reached", "reached"])
    assert [d["answers"][0]["interval"] for d in documents] == [[0.0, 1.0], [0.0, 1.0]]


@pytest.mark.usefixtures("served_here")
def test_a_goal_that_the_graph_cannot_say_leaves_the_others_to_it(monkeypatch):
    subject, texts = towers(), []
    goals = ["present(H)", "ev_holds(H, C)", "number_of_objects(N)"]
    alone = [answers(subject, goal) for goal in goals]
    run = engine.run
    monkeypatch.setattr(
        "plogic.scene.asking.query.run", lambda *given, **how: texts.append(given[1]) or run(*given, **how)
    )
    assert answers_to_all(subject, goals) == alone
    assert texts == [["ev_holds(H, C)"]]
    with pytest.raises(ProgramError, match=r"^goal 3:1:1: no clauses for presen/1"):
        answers_to_all(subject, ["present(H)", "ev_holds(H, C)", "presen(H)"])


@pytest.mark.usefixtures("served_here")
def test_a_scene_answers_several_by_a_deadline():
    subject, goals = towers(), ["present(H)", "number_of_objects(N)"]
    assert answers_to_all_until(subject, goals, seconds=60.0) == (answers_to_all(subject, goals), True)
