"""Stock ProbLog in its child process: the right answers, or the reason why there are none."""

import pytest

from benchmarks.worlds.stock import fastest, stock

COINS = "0.6::heads(c1). 0.4::heads(c2). both :- heads(c1), heads(c2). evidence(\\+ both). query(heads(C)).\n"
ENDLESS = "p(X) :- q(X), p(s(X)). q(_). query(p(a)).\n"


@pytest.mark.parametrize("knowledge", ["ddnnf", "sdd"])
def test_answers_given_the_evidence_and_times_of_each_stage(knowledge):
    run = stock(COINS, knowledge, 60.0)
    assert run.why == ""
    assert run.answers == pytest.approx({"heads(c1)": 0.36 / 0.76, "heads(c2)": 0.16 / 0.76})
    assert min(run.parse, run.ground, run.infer) > 0
    assert run.whole == run.parse + run.ground + run.infer


def test_our_way_from_the_text_remembers_nothing_between_runs(monkeypatch):
    """Each run is a process of its own: a remembered program would answer in no time at all and be no measurement."""
    from benchmarks.worlds import stock as worlds_stock

    commands = []
    reply = worlds_stock._reply
    monkeypatch.setattr(
        worlds_stock, "_reply", lambda command, *rest: commands.append(command) or reply(command, *rest)
    )
    run = fastest(COINS, "plogic", 60.0)
    assert run.answers == pytest.approx({"heads(c1)": 0.36 / 0.76, "heads(c2)": 0.16 / 0.76})
    assert len(commands) == 3


def test_over_the_limit_of_time_is_said_and_repeats_are_not_begun():
    run = fastest(ENDLESS, "ddnnf", 0.5)
    assert run.timed_out
    assert run.why == "> 0.5"
    assert run.answers == {}
    assert (run.parse, run.ground, run.infer) == (0.0, 0.0, 0.0)  # it never came to the end of grounding


def test_what_was_cut_off_in_compilation_has_the_stages_before_and_what_it_had_used():
    pigeons = "".join(f"0.5::in({i}, {j}).\n" for i in range(14) for j in range(14))
    clash = (
        "clash :- in(I, J), in(K, J), I < K.\nlone(I) :- \\+ placed(I), between(0, 13, I).\nplaced(I) :- in(I, _).\n"
    )
    run = stock(f"{pigeons}{clash}evidence(\\+ clash).\nquery(placed(3)).\n", "sdd", 2.5)
    assert run.timed_out
    assert min(run.parse, run.ground) > 0.0
    assert 0.5 < run.infer < 6.0


@pytest.mark.parametrize(
    ("text", "why"),
    [
        ("0.5::a. evidence(a). evidence(\\+a). query(a).", "InconsistentEvidenceError"),
        ("a :- nowhere(x). query(a).", "UnknownClause"),
        ("a :- . query(a).", "ParseError"),
    ],
)
def test_a_refusal_is_told_by_its_name(text, why):
    run = stock(text, "ddnnf", 60.0)
    assert (run.why, run.timed_out, run.answers) == (why, False, {})


def test_the_limit_of_memory_holds():
    run = stock("q :- length(L, 200000000). query(q).", "ddnnf", 60.0, megabytes=400)
    assert (run.why, run.answers) == ("out of memory", {})
