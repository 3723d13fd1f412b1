"""A gate of hundreds of ways, as ``findall`` makes them, is counted right, and no tables are planned for it."""

from math import comb

import pytest
from stock_worlds import stock

from plogic.logic.answers import by_tables
from plogic.logic.served.program_child import reply_to, serve

PROGRAM = "0.3::h(X) :- between(1,{},X). n(K) :- {}(X,h(X),L), length(L,K). query(n(_))."


def asked(text, goals=()):
    return {"texts": [{"text": text, "file": "program.pl"}], "goals": list(goals), "given": [], "names": None}


@pytest.mark.parametrize(("collect", "choices"), [("findall", 9), ("findall", 13), ("all_or_none", 9)])
def test_lists_of_many_choices_are_counted_without_tables(monkeypatch, collect, choices):
    def planned(*_):
        raise AssertionError

    monkeypatch.setattr(by_tables, "tables_of", planned)
    (answers,) = serve(asked(PROGRAM.format(choices, collect)))["answers"]
    wanted = {f"n({k})": comb(choices, k) * 0.3**k * 0.7 ** (choices - k) for k in range(choices + 1)}
    assert dict(answers) == pytest.approx(wanted, abs=1e-12)


@pytest.mark.parametrize(
    ("collect", "said"),
    [
        ("findall", "findall/3 collects an answer once for each proof: h(X1) has 40 proofs that may each hold or not"),
        ("all", "h(X1) has 40 answers that may each hold or not, which make 2^40 lists; at most 2^14 are written"),
        ("all_or_none", "h(X1) has 40 answers that may each hold or not, which make 2^40 lists"),
    ],
)
def test_more_lists_than_can_be_written_are_refused_at_once_with_their_place(collect, said):
    error = reply_to(asked(f"0.3::h(X) :- between(1,40,X).\nn(K) :- {collect}(X,h(X),L), length(L,K).\nquery(n(_))."))[
        "error"
    ]
    assert (error["kind"], error["file"], error["line"], error["column"]) == ("ProgramError", "program.pl", 2, 9)
    assert error["reason"].startswith(said)


def test_more_proofs_than_can_be_looked_at_are_refused_before_they_are():
    many = " ".join(f"p{i} :- c({i},X), X > 0." for i in range(6))
    text = f"0.5::c(I,X) :- between(0,5,I), between(1,40,X). {many} all :- p0, p1, p2, p3, p4, p5. n(L) :- findall(x,all,L). query(n(_))."
    assert f"has {40**6} proofs" in reply_to(asked(text))["error"]["reason"]


def test_what_is_certain_makes_no_lists_of_its_own():
    text = "f(X) :- between(1,5000,X). g(X) :- f(X), \\+ h(X). 0.25::h(1). n(N) :- findall(X,g(X),L), length(L,N). query(n(_))."
    assert dict(serve(asked(text))["answers"][0]) == pytest.approx({"n(5000)": 0.75, "n(4999)": 0.25})


COLLECTED = {
    "one proof each": "0.3::h(1). 0.6::h(2). h(3).",
    "two proofs of one answer": "0.3::a. 0.6::b. h(1) :- a. h(1) :- b. 0.5::h(2).",
    "alternatives": "0.3::h(1); 0.6::h(2).",
    "nothing": "h(1) :- fail.",
    "an answer that excludes another": "0.3::h(1). h(2) :- \\+ h(1).",
}


@pytest.mark.parametrize("program", COLLECTED.values(), ids=COLLECTED)
@pytest.mark.parametrize("collect", ["findall", "all", "all_or_none"])
def test_lists_are_those_of_problog(collect, program):
    text = f"{program} n(L) :- {collect}(X,h(X),L)."
    theirs = {goal: p for goal, p in stock(f"{text} query(n(_)).").items() if p > 0}
    assert dict(serve(asked(text, ["n(L)"]))["answers"][0]) == pytest.approx(theirs, abs=1e-12)
    of_goal = dict(serve(asked(text, [f"{collect}(X,h(X),L)"]))["answers"][0])
    assert of_goal == pytest.approx({f"{collect}(X,h(X),{g[2:-1]})": p for g, p in theirs.items()}, abs=1e-12)
