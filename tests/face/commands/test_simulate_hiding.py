"""``plogic simulate --hiding``, what it says at its end, and an empty answer in words."""

from __future__ import annotations

import json

from in_process import told


def test_one_hides_a_part_of_the_other_and_the_next_command_is_told(tmp_path):
    out = tmp_path / "scene"
    lines = told("simulate", "--kb", "towers", "--hiding", "--gamma", "--seed", "1", "-o", str(out))
    assert lines[-1] == f"wrote {out}"
    assert lines[-2].endswith(f"there; next: plogic perceive {out / 'gamma.json'} --kb towers -o out.json")
    shares = [one["visible_fraction"] for one in json.loads((out / "truth.json").read_text())["objects"]]
    assert min(shares) < 0.92
    assert max(shares) > 0.9


def test_an_empty_answer_is_said_in_words(tmp_path):
    program = tmp_path / "coin.pl"
    program.write_text("0.5::heads.\n", encoding="utf-8")
    assert any("it has no query/1" in line for line in told("query", str(program)))
    program.write_text("0.5::p(a).\nq(X) :- p(X), X = b.\n", encoding="utf-8")
    assert any(line.startswith("no answer: ") for line in told("query", str(program), "q(X)"))


def test_what_a_label_that_is_no_number_is_for(tmp_path):
    program = tmp_path / "learn.pl"
    program.write_text("t(0.5)::a.\nquery(a).\n", encoding="utf-8")
    assert "problog lfi learns them" in told("query", str(program))[-1]
