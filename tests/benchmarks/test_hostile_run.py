"""Hostile programs: a short run through every kind of door, and that misdeeds are seen where they happen."""

from __future__ import annotations

import pytest

from benchmarks.fuzz.hostile.__main__ import FAMILIAR, Bench, attacked, corpus
from benchmarks.fuzz.hostile.doors import DOORS, HARMLESS, door_of
from benchmarks.fuzz.hostile.program import Hostile
from benchmarks.fuzz.hostile.run import Cost, run

SHORT = (
    "consult a program", "the library that reads tables", "a loader from its letters", "a loader swallowed by try_call",
    "the Python object behind a record", "behind a carriage return", "clear the screen by an answer", "the environment of other Prologs",
    "stand in for our goal", "a loader built in the goal", "a loader built as evidence", "a loader built in rules",
    "a loader in a knowledge base's rules", "brackets that are never closed", "a power in a rule's label", "a rule's sign in a comment",
    "a goal of a hundred thousand letters", "a knowledge base's rules with a large label", "a row that is just not too long",
    "mistakes, thousands",
)  # fmt: skip
"""Programs that end at once, or with their deadline."""


def test_a_short_run():
    programs = [program for program in corpus() if program.tries in SHORT]
    said: list[str] = []
    told, _ = attacked(programs, 2, said.append)
    assert {each.program.tries: each.misdeeds() for each in told} == {tries: [] for tries in SHORT}


def test_the_corpus_is_what_it_says():
    programs = corpus()
    assert len({program.tries for program in programs}) == len(programs)
    assert min(sum(program.bomb for program in programs), sum(not program.bomb for program in programs)) >= 100
    assert {door_of(program, i) for i, program in enumerate(programs)} == set(DOORS) - {"trusted"}
    assert set(HARMLESS) == set(DOORS)


LOADS = ":- use_module('{py}'). a. query(a)."
READS = ":- consult('{secret}'). a(X) :- token(X). query(a(_))."


@pytest.mark.parametrize("text", [LOADS, READS], ids=["loads", "reads"])
def test_misdeeds_are_seen_of_a_program_that_is_trusted(text, tmp_path):
    bench = Bench(tmp_path, 2)
    bench.measure(["trusted"], [FAMILIAR["libraries"]])
    (told,) = bench.attack([("trusted", Hostile("is trusted", text, "trusted"))])
    seen = [
        word
        for word in ("took bait", "opened or started", "told a secret", "left 1 processes")
        if any(word in m for m in told.misdeeds())
    ]
    assert seen == (
        ["took bait", "opened or started", "left 1 processes"]
        if text is LOADS
        else ["opened or started", "told a secret"]
    )


def test_a_run_is_killed_that_does_not_end(tmp_path, monkeypatch):
    monkeypatch.setattr("benchmarks.fuzz.hostile.run.PATIENCE", 0.0)
    assert run("explain", "a :- p(z). p(X) :- p(f(X)).", "a", tmp_path / "run", 0.5).status == -9


@pytest.mark.parametrize(
    ("cost", "beyond"),
    [
        (Cost(3.0, 0.5, 2.4), 0.0),  # in time
        (Cost(9.0, 0.5, 2.4), 0.0),  # it waited for others
        (Cost(9.0, 5.5, 7.4), 5.0),  # it went on by itself
        (Cost(9.0, 0.5, 8.5), 5.5),  # its inference went on
    ],
)
def test_what_is_beyond_a_limit(cost, beyond):
    assert cost.beyond(Cost(1.0, 0.5, 1.0), 2.0) == beyond
