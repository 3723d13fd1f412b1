"""The verbs as functions: what each answers, and that observations are as they should be."""

from __future__ import annotations

import itertools
import math

import pytest
from situations import towers

from geometry.errors import PlogicError
from plogic.base.errors import InconsistentError, InputError, LimitError, ProgramError
from plogic.face.python.sessions import Session as Opened
from plogic.face.session.session import Session
from plogic.logic.served.engine import Limits, Text
from plogic.scene.asking.query import answers

PROGRAM = """0.3::rain.
0.5::sprinkler(front); 0.2::sprinkler('Back yard').
wet(G) :- sprinkler(G).
wet(G) :- garden(G), rain.
garden(front). garden('Back yard').
"""
EVIDENT = PROGRAM + "evidence(\\+ sprinkler(front)).\n"


@pytest.fixture(scope="module")
def mind():
    """Whom all new sessions about the program ask: its process starts once."""
    with Session(Text(PROGRAM, "rain.pl")) as session:
        yield session._mind


@pytest.fixture
def session(mind):
    new = Session(Text(PROGRAM, "rain.pl"))
    new._mind = mind
    return new


def probabilities(result):
    return {a.goal: a.probability for a in result.answers}


def now(result):
    return {row.goal: row.now.probability for row in result.predictions}


def stock(text, given=()):
    """P of every wet/1 by ProbLog itself."""
    from problog import get_evaluatable
    from problog.program import PrologString

    program = PrologString("\n".join([text, "query(wet(_)).", *(f"evidence({literal})." for literal in given)]))
    return {str(goal): p for goal, p in get_evaluatable().create_from(program).evaluate().items()}


@pytest.mark.parametrize("text", [PROGRAM, EVIDENT], ids=["plain", "with evidence of its own"])
def test_predict_against_problog(text):
    with Session(Text(text)) as session:
        session.observe("wet(front)")
        session.observe("\\+ sprinkler('Back yard')")
        predicted = session.predict("wet(G)")
        assert now(predicted) == pytest.approx(stock(text, ["wet(front)", "\\+sprinkler('Back yard')"]), abs=1e-9)
        assert {row.goal: row.before.probability for row in predicted.predictions} == pytest.approx(
            stock(text), abs=1e-9
        )
        assert probabilities(session.ask("wet(G)")) == pytest.approx(stock(text), abs=1e-9)


def test_ask_is_without_what_was_observed(session):
    before = session.ask("wet(G)")
    session.observe("rain")
    assert session.ask("wet(G)") == before
    assert now(session.predict("wet(G)")) == {"wet('Back yard')": 1.0, "wet(front)": 1.0}


def test_observing_says_how_probable_it_was(session):
    assert session.observe("wet(G)").probability == pytest.approx(1 - 0.7 * 0.3)
    seen = session.observe("rain")
    assert (seen.probability, seen.observed) == (pytest.approx(0.3 / 0.79), ("wet(G)",))
    assert seen.surprise == pytest.approx(math.log2(0.79 / 0.3))
    assert "1.4 bits of surprise" in str(seen)
    assert "it was certain" in str(session.observe("garden(front)"))


def test_what_is_impossible_is_refused_and_changes_nothing(session):
    session.observe("sprinkler(front)")
    before = session.predict("wet(G)")
    with pytest.raises(
        InconsistentError,
        match=r"sprinkler\('Back yard'\) is impossible given sprinkler\(front\): its probability is 0",
    ):
        session.observe("sprinkler('Back yard')")
    with pytest.raises(InconsistentError, match=r"\\\+ wet\(front\) is impossible given"):
        session.observe("\\+ wet(front)")
    assert session.observed == ("sprinkler(front)",)
    assert session.predict("wet(G)") == before


def test_what_is_very_improbable_is_not_impossible():
    with Session(Text("1.0e-12::a. 0.5::b.")) as session:
        assert session.observe("a").probability == pytest.approx(1e-12, rel=1e-9)
        assert now(session.predict("a"))["a"] == pytest.approx(1.0)


@pytest.mark.parametrize("literal", ["zork(X)", "rain(", "consult('x.pl')"])
def test_a_literal_that_cannot_be_used_changes_nothing_and_is_told_with_its_place(session, literal):
    with pytest.raises(ProgramError, match=":1:"):
        session.observe(literal)
    assert session.observed == ()


def test_observed_twice_is_observed_once(session):
    session.observe("wet( front ).")
    again = session.observe("wet(front)")
    assert "observed already" in str(again)
    assert session.observed == ("wet( front )",)


def test_unobserve_one_or_all(session):
    session.observe("rain")
    session.observe("wet('Back yard')")
    session.observe("sprinkler(front)")
    assert session.unobserve(" wet('Back yard') .").literals == ("wet('Back yard')",)
    with pytest.raises(InputError, match=r"wet\(front\) is not observed \(observed: rain; sprinkler\(front\)\)"):
        session.unobserve("wet(front)")
    assert session.unobserve().literals == ("rain", "sprinkler(front)")
    assert str(session.unobserve()) == "nothing was observed"


def test_observe_then_unobserve_restores_every_byte(session):
    before = [str(session.predict("wet(G)")), str(session.worlds()), str(session.why("wet(front)"))]
    session.observe("wet(front)")
    assert str(session.worlds()) != before[1]
    session.unobserve("wet(front)")
    assert [str(session.predict("wet(G)")), str(session.worlds()), str(session.why("wet(front)"))] == before


def test_the_order_of_observations_changes_no_byte():
    literals = ["wet(front)", "\\+ sprinkler('Back yard')", "rain"]
    found = set()
    for order in itertools.permutations(literals):
        with Session(Text(PROGRAM)) as session:
            for literal in order:
                session.observe(literal)
            found.add(
                (
                    session.predict("sprinkler(X)").predictions,
                    session.worlds().worlds,
                    session.why("wet('Back yard')").account,
                )
            )
    assert len(found) == 1


def test_the_worlds_of_a_program_sum_to_one_and_follow_what_is_observed(session):
    session.observe("wet(front)")
    ranking = session.worlds(100)
    assert ranking.unlisted == pytest.approx((0.0, 0.0), abs=1e-12)
    assert sum(row.probability for row in ranking.worlds) == pytest.approx(1.0)
    few = session.worlds(1)
    assert len(few.worlds) == 1
    assert few.worlds[0].probability + few.unlisted[0] == pytest.approx(1.0)


def test_without_a_goal_as_query(rain):
    with Opened.open(rain) as session:
        assert list(probabilities(session.ask())) == [a.goal for a in answers(Text(rain.read_text()))]
        session.observe("rain")
        assert set(now(session.predict()).values()) == {1.0}


def test_listing_shows_clauses_as_they_were_written(session):
    assert session.listing("wet").clauses == ("wet(G) :- sprinkler(G).", "wet(G) :- garden(G), rain.")
    assert session.listing("sprinkler/1").clauses == ("0.5::sprinkler(front); 0.2::sprinkler('Back yard').",)
    assert dict(session.listing().contents)["garden/1"] == "2 clauses"
    with pytest.raises(InputError, match="listing zork"):
        session.listing("zork")


def test_a_session_is_saved_and_loaded(session, tmp_path):
    session.observe("wet(front)")
    session.predict("rain  % a comment\n")
    assert session.save(tmp_path / "s.txt").lines == ("observe wet(front)", "predict rain")
    with Session(Text(PROGRAM)) as other:
        replayed = other.load(tmp_path / "s.txt")
        assert other.observed == session.observed
        assert str(replayed.results[-1]) == str(session.predict("rain"))
    session.save(tmp_path / "s.txt")  # over a saved session
    (tmp_path / "mine.pl").write_text(PROGRAM)
    with pytest.raises(InputError, match="is there already and is no saved session"):
        session.save(tmp_path / "mine.pl")
    assert (tmp_path / "mine.pl").read_text() == PROGRAM


def test_a_line_that_fails_stops_a_load_and_is_told_with_its_number(session, tmp_path):
    (tmp_path / "s.txt").write_text("% x\nobserve rain\nobserve \\+ rain\nask wet(G)\n")
    with pytest.raises(InputError, match=r"s\.txt:3: \\\+ rain is impossible given rain"):
        session.load(tmp_path / "s.txt")
    assert session.observed == ("rain",)


def test_a_question_that_takes_too_long_ends_its_process_and_no_more():
    slow = "slow :- between(1, 300, X), between(1, 300, Y), between(1, 300, Z), X + Y + Z < 0.\n"
    with Session(Text(PROGRAM + slow), limits=Limits(seconds=3)) as session:
        session.observe("wet(front)")
        with pytest.raises(LimitError, match="3 s"):
            session.ask("slow")
        assert now(session.predict("wet(front)")) == {"wet(front)": 1.0}


def test_the_towers():
    with Session(towers()) as session:
        assert [round(row.probability, 3) for row in session.worlds().worlds] == [0.961, 0.029, 0.010]
        session.observe("\\+ present(t2)")
        assert now(session.predict("present(t2_distorted)"))["present(t2_distorted)"] == pytest.approx(
            (1 - 0.508046) / 2, abs=1e-6
        )
        worlds = session.worlds()
        assert [row.present for row in worlds.worlds] == [("t1",), ("t1", "t2_distorted")]
        with pytest.raises(InconsistentError, match="impossible given"):
            session.observe("present(t2)")
        assert session.listing("hidden").clauses
        assert "present(H) :-" in "\n".join(session.listing("present/1").clauses)
        assert session.listing("3").title == "The choices"
        assert ("t2_distorted", "t2, a hypothesis") in session.names()
        assert ("'corner/a0'", "corner, a feature") in session.names()


def test_evidence_that_only_the_text_can_speak_of():
    subject = towers(mode="to_B")
    with Session(subject) as session:
        session.observe("pick(t2, 'corner/a0')")
        session.observe("\\+ present(t2_distorted)")
        given = list(session.observed)
        expected = {a.goal: a.probability for a in answers(subject, "present(H)", given=given)}
        assert {goal: p for goal, p in now(session.predict("present(H)")).items() if p} == pytest.approx(
            expected, abs=1e-9
        )
        worlds = session.worlds()
        for name in ("t1", "t2"):
            mass = sum(row.probability for row in worlds.worlds if name in row.present)
            assert mass == pytest.approx(expected[f"present({name})"], abs=1e-9)
        assert worlds.unlisted == (0.0, 0.0)


def test_why_and_whynot_are_given_what_was_observed(session):
    session.observe("\\+ rain")
    account = session.why("wet(front)").account
    assert [e.choices for e in account.why] == [("sprinkler(front)",)]
    assert account.why[0].given_evidence == pytest.approx(0.5)
    first, *rest = str(session.why("wet(front)")).splitlines()
    assert (first, rest[:2]) == ("P(wet(front)) = 0.5 given \\+ rain", ["", rest[1]])
    assert rest[1].startswith("why 1: ")
    assert "why not 1" not in "".join(rest)
    assert "why not 1" in str(session.whynot("wet(front)"))
    assert "why 1" not in str(session.whynot("wet(front)"))
    session.observe("wet(front)")
    assert session.why("wet(front)").account.probability == pytest.approx(1.0)


def test_a_number_of_explanations(session, tmp_path):
    assert len(session.why("wet(front)", 1).account.why) == 1
    assert len(session.why("wet(front)").account.why) == 2
    assert session.lines == ("why 1 wet(front)", "why wet(front)")
    session.save(tmp_path / "s.txt")
    counts = [len(result.account.why) for result in session.load(tmp_path / "s.txt").results]
    assert counts == [1, 2]
    (tmp_path / "is.txt").write_text("why 5 is 2 + 3\n")
    assert session.load(tmp_path / "is.txt").results[0].account.probability == 1.0


@pytest.mark.parametrize(
    ("text", "wrong"),
    [
        ("% A session\nsave {}/new\n", r"s\.txt:2: a saved session saves nothing"),
        ("load {}/s.txt\n", r"s\.txt:1: a saved session loads nothing"),
        ("help\n" * 1001, r"s\.txt: has 1001 lines, more than the 1000 that are done"),
    ],
)
def test_a_strangers_session_writes_nothing_and_ends(session, tmp_path, text, wrong):
    (tmp_path / "s.txt").write_text(text.format(tmp_path))
    with pytest.raises(InputError, match=wrong):
        session.load(tmp_path / "s.txt")
    assert [path.name for path in tmp_path.iterdir()] == ["s.txt"]


@pytest.mark.parametrize(("place", "wrong"), [("~nosuch/x", "nobody knows that home"), ("a" * 300, "name")])
def test_a_place_that_cannot_be_is_a_mistake(session, place, wrong):
    for verb in (session.save, session.load):
        with pytest.raises(PlogicError, match=wrong):
            verb(place)
