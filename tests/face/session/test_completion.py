"""What TAB offers, without a terminal."""

from __future__ import annotations

import pytest
from prompt_toolkit.completion import CompleteEvent
from prompt_toolkit.document import Document
from situations import towers

from plogic.face.session.prompt import GoalCompleter
from plogic.face.session.session import Session
from plogic.logic.served.engine import Text


@pytest.fixture(scope="module")
def scene():
    with Session(towers(rules="tall(H) :- present(H).\n")) as session:
        yield GoalCompleter(session)


@pytest.fixture(scope="module")
def program():
    with Session(
        Text("0.3::rain.\n0.5::sprinkler(front); 0.2::sprinkler('Back yard').\nwet(X) :- sprinkler(X).\nquery(rain).\n")
    ) as session:
        session.observe("wet(front)")
        yield GoalCompleter(session)


def offered(completer, text):
    """What each offer makes of the text, with its meaning."""
    document = Document(text)
    found = list(completer.get_completions(document, CompleteEvent(completion_requested=True)))
    return {text[: len(text) + c.start_position] + c.text: c.display_meta_text for c in found}


def test_verbs_and_predicates_at_the_beginning(scene):
    found = offered(scene, "pre")
    assert found == {
        "predict ": "P(goal | everything observed), beside P(goal)",
        "present(": "hypothesis H is in the world",
    }
    assert {"ask ", "observe ", "quit", "noise(", "tall("} <= set(offered(scene, ""))


def test_predicates_after_a_verb_and_after_a_comma(scene):
    assert set(offered(scene, "ask pre")) == {"ask present("}
    assert set(offered(scene, "observe \\+ pre")) == {"observe \\+ present("}
    assert set(offered(scene, "present(t1), (noi")) == {"present(t1), (noise("}


def test_names_inside_parentheses(scene):
    assert offered(scene, "ask present(t2_") == {"ask present(t2_distorted": "t2, a hypothesis"}
    assert offered(scene, "expected(t2, corner/a0".removesuffix("/a0")).keys() >= {
        "expected(t2, 'corner/a0'",
        "expected(t2, corner",
    }
    assert offered(scene, "why detected(t1, 'apex/a") == {"why detected(t1, 'apex/a0'": "apex, a feature"}
    assert offered(scene, "noise(x_apex") == {}
    assert offered(scene, "noise(y_apex") == {"noise('y_apex_A0'": "l_junction, an appearance"}


def test_a_programs_own_predicates_and_constants(program):
    assert offered(program, "ask w") == {"ask wet(": "1 clause"}
    assert set(offered(program, "ask sprinkler(B")) == {"ask sprinkler('Back yard'"}
    assert set(offered(program, "ask sprinkler(f")) == {"ask sprinkler(front"}
    assert "ask query(" not in offered(program, "ask ")


def test_what_each_verb_takes(program, tmp_path):
    assert set(offered(program, "unobserve ")) == {"unobserve wet(front)"}
    assert {"listing query/1", "listing wet/1"} <= set(offered(program, "listing "))
    assert {"help whynot", "help wet"} <= set(offered(program, "help w"))
    assert offered(program, "quit ") == {}
    (tmp_path / "mine.txt").touch()
    assert set(offered(program, f"save {tmp_path}/mi")) == {f"save {tmp_path}/mine.txt"}


def test_a_program_that_cannot_be_read_offers_the_verbs_no_less():
    with Session(Text("a :- b(.")) as session:
        assert offered(GoalCompleter(session), "ask a") == {}
