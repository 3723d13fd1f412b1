"""Programs as strangers write them, and what goes wrong around them: through the console script."""

from __future__ import annotations

import json
import math
import os
import signal
import subprocess
import time

import pytest
from console import BIN, document, plogic

from plogic.base import children
from plogic.base.errors import LimitError
from plogic.logic.served import engine

WIDE = 3000


def written(folder, text, name="p.pl"):
    """A program's file."""
    path = folder / name
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    return path


def refusal(*args):
    """The one line of a command that refuses its input."""
    run = plogic(*args)
    assert (run.returncode, run.stdout) == (1, ""), run.stderr
    assert "Traceback" not in run.stderr
    assert "internal error" not in run.stderr
    return run.stderr.splitlines()[-1]


def answered(*args):
    """Goal → probability."""
    return {answer["goal"]: answer["probability"] for answer in document("query", *args, "--json")["answers"]}


def test_one_atom_of_thousands_of_facts(tmp_path):
    file = written(
        tmp_path,
        "".join(f"0.001::a({i}).\n" for i in range(WIDE)) + "0.5::b.\nx :- a(_).\ny :- x, b.\nquery(x). query(y).\n",
    )
    found = answered(file)
    assert found["x"] == pytest.approx(1 - 0.999**WIDE, abs=1e-12)
    assert found["y"] == pytest.approx(0.5 * (1 - 0.999**WIDE), abs=1e-12)


def test_thousands_of_facts_of_which_one_is_observed_to_hold(tmp_path):
    file = written(
        tmp_path, "".join(f"0.001::a({i}).\n" for i in range(WIDE)) + "x :- a(_).\nevidence(x).\nquery(a(7)).\n"
    )
    assert answered(file)["a(7)"] == pytest.approx(0.001 / (1 - 0.999**WIDE), rel=1e-9)


def test_a_path_of_a_thousand_edges(tmp_path):
    edges = "".join(f"0.99::e({i},{i + 1}).\n" for i in range(1000))
    file = written(tmp_path, edges + "p(X,Y) :- e(X,Y).\np(X,Y) :- e(X,Z), p(Z,Y).\nquery(p(0,1000)).\n")
    assert answered(file)["p(0,1000)"] == pytest.approx(math.exp(1000 * math.log(0.99)), rel=1e-9)


def test_a_choice_keeps_its_name_where_a_rules_head_is_nothing_else(tmp_path):
    text = ":- use_module(library(lists)).\n0.5::a.\nlast([X], X) :- a.\nb(N) :- length([1, 2], N), last([N], N).\nquery(b(N)).\n"
    worlds = document("worlds", written(tmp_path, text), "--json")["worlds"]
    assert [world["choices"] for world in worlds] == [["a"], ["\\+a"]]


def test_choices_with_the_same_head_are_told_apart_by_their_lines(tmp_path):
    text = ":- use_module(library(lists)).\n0.3::a.\n0.2::a.\nb(N) :- length([1], N), a.\nquery(b(N)).\n"
    first, *_ = document("worlds", written(tmp_path, text), "--json")["worlds"]
    assert first["choices"] == ["\\+a (line 2)", "\\+a (line 3)"]


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("x.\n 1.5::a :- x.\nquery(a).\n", "2:2: 1.5 is not a probability: it must be from 0 to 1"),
        ("t(0.5)::a.\nquery(a).\n", "1:1: t(0.5) is not a probability: it is to be learned"),
        ("q(1).q(2).\n", "1:5: Unexpected character '.'"),
        ("x.\nq(1).q(2).\n", "2:5: Unexpected character '.'"),
        (
            "0.7::a; 0.6::b.\nquery(a). query(b).\n",
            "the probabilities of an annotated disjunction add up to 1.3: they must not exceed 1",
        ),
    ],
)
def test_a_mistake_is_told_with_its_place(text, said, tmp_path):
    assert said in refusal("query", written(tmp_path, text))


def test_explain_refuses_what_query_refuses(tmp_path):
    assert "1:1: 1.5 is not a probability" in refusal("explain", written(tmp_path, "1.5::a.\n"), "a")


@pytest.mark.parametrize("command", ["query", "explain"])
def test_an_empty_goal(command, tmp_path):
    assert refusal(command, written(tmp_path, "0.5::a.\n"), "").endswith(
        "is empty; a goal is one term, like present(h1)"
    )


def test_a_byte_order_mark_is_no_part_of_a_program(tmp_path):
    assert answered(written(tmp_path, b"\xef\xbb\xbf0.5::a.\r\nquery(a).\r\n")) == {"a": 0.5}


def test_a_proof_too_deep_to_be_told_is_said_so(tmp_path):
    text = "0.5::a.\nn(0) :- a.\nn(N) :- N > 0, M is N - 1, n(M).\n"
    file = written(tmp_path, text)
    assert "nested too deeply" in refusal("explain", file, "n(5000)")
    told = plogic("explain", file, "n(500)", "-n", 1)
    assert (told.returncode, told.stdout.count("[rule]")) == (0, 501)


def test_choices_of_a_consulted_file_are_answered_and_not_explained(tmp_path):
    written(tmp_path, "0.4::extra.\n", "other.pl")
    file = written(tmp_path, ":- consult('other.pl').\n0.5::a.\nb :- a, extra.\nquery(b).\n")
    assert answered(file, "--trust") == {"b": pytest.approx(0.2)}
    assert "cannot be explained" in refusal("explain", file, "b", "--trust")


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP], ids=lambda s: s.name)
def test_nothing_is_left_of_a_command_that_is_told_to_end(number, tmp_path):
    scratch = tmp_path / "scratch"
    scratch.mkdir()
    file = written(tmp_path, "0.5::a.\nn(X) :- n(s(X)).\nn(_) :- a.\nquery(n(z)).\n")
    environment = {**os.environ, "TMPDIR": str(scratch)}
    with subprocess.Popen([BIN / "plogic", "query", file], env=environment, stderr=subprocess.PIPE) as run:
        while not list(scratch.iterdir()):
            time.sleep(0.05)
        time.sleep(0.3)
        run.send_signal(number)
        _, said = run.communicate(timeout=20)
    assert run.returncode > 0
    assert b"Traceback" not in said
    assert list(scratch.iterdir()) == []


def test_a_process_that_cannot_start_is_not_called_a_limit_of_memory(tmp_path, monkeypatch):
    broken = written(tmp_path, "#!/bin/sh\necho 'no such module' >&2\nexit 3\n", "python")
    broken.chmod(0o755)
    monkeypatch.setattr(children.sys, "executable", str(broken))
    with pytest.raises(LimitError, match=r"^the process of the inference could not work: no such module$"):
        engine.run([engine.Text("0.5::a. query(a).")])


@pytest.mark.parametrize("piece", [":-", ":- ", "( ", ":- ( "])
def test_signs_of_rules_are_looked_through_once(piece, tmp_path):
    file = written(tmp_path, "a. query(a). % " + ":-" * 100_000 + piece * 1_000_000)
    assert answered(file) == {"a": 1.0}


@pytest.fixture(scope="module")
def scene(demo):
    """The demo's interpretation."""
    return demo / "interpretation.json"


def test_worlds_given_evidence_by_a_deadline(scene):
    run = plogic("worlds", scene, "--given", "present(h1)", "--deadline", "0.000001", "--json")
    answer = json.loads(run.stdout)
    exact = {
        tuple(w["present"]): w["probability"]
        for w in document("worlds", scene, "--given", "present(h1)", "--json")["worlds"]
    }
    assert (run.returncode, answer["deadline"]) == (3, "reached")
    for world in answer["worlds"]:
        low, high = world["interval"]
        assert low <= exact[tuple(world["present"])] <= high
    assert answer["worlds"]


def test_worlds_given_what_a_scenes_graph_sums_out(scene):
    answer = document("worlds", scene, "--given", "pick(h1, X)", "--json")
    sure = document("worlds", scene, "--given", "pick(h1, X), present(h1)", "--json")
    assert sum(w["probability"] for w in answer["worlds"]) + answer["unlisted_mass"][1] == pytest.approx(1)
    assert [w["present"] for w in sure["worlds"]] == [["h1", "h2"], ["h1"]]


def test_a_name_that_occurs_nowhere_is_told_below_an_empty_table(tmp_path):
    file = written(tmp_path, "kind(h1, tower).\n0.5::there(h1).\nobject(X, T) :- kind(X, T), there(X).\n")
    lines = plogic("query", file, "object(X, towr)").stdout.splitlines()
    assert lines[-2:] == [
        "no answer: nothing of this form holds with positive probability",
        "towr is unknown as argument 2 of object/2; closest are tower",
    ]
    assert document("query", file, "object(X, towr)", "--json") == {"format": "answers/1", "answers": []}


@pytest.mark.parametrize("command", ["query", "worlds"])
def test_a_program_of_another_name_is_told_what_names_programs_have(command, tmp_path):
    file = written(tmp_path, "0.4::a.\nquery(a).\n", "coins.txt")
    assert refusal(command, file).endswith(
        "coins.txt:1:4: is no JSON: Extra data; a program's name ends in .pl, .problog or .pro"
    )


def test_given_with_a_variable_is_of_some_instance_and_a_programs_evidence_of_all(tmp_path):
    coins = "0.5::heads(a).\n0.5::heads(b).\nquery(heads(a)).\n"
    assert answered(written(tmp_path, coins), "--given", "heads(X)") == {"heads(a)": pytest.approx(2 / 3)}
    assert answered(written(tmp_path, f"{coins}evidence(heads(X)).\n")) == {"heads(a)": 1.0}
