"""``--withhold``, ``Interpretation.withhold``: relations of the demo's towers without one pose, by what is detected."""

from __future__ import annotations

import json

import pytest
from console import plogic
from stock_worlds import stock

from geometry.files.documents import Document
from geometry.visibility.roc import converse
from plogic import Error, Interpretation
from plogic.facts.interpretation import interpretation_in, situation_of
from plogic.facts.pixel_table import PixelTable
from plogic.sequence.unposed.elsewhere import with_elsewhere
from plogic.sequence.unposed.reading import beside, doubts_weighed, evidence, withheld


@pytest.fixture(scope="module")
def file(demo):
    return demo / "interpretation.json"


@pytest.fixture(scope="module")
def document(file):
    return json.loads(file.read_text())


@pytest.fixture(scope="module")
def without(document):
    return withheld(document, ["h2"])


def asked(*arguments):
    run = plogic("query", *arguments, "--json")
    assert run.returncode == 0, run.stderr
    return {a["goal"]: a["probability"] for a in json.loads(run.stdout)["answers"]}


def test_the_relation_that_the_pose_had_told_is_the_most_probable(file, document):
    (known,) = (f for f in document["facts"] if f["fact"] == "relation")
    found = asked(file, "roc(R, h1, h2)", "--withhold", "h2")
    assert next(iter(found)) == f"roc({known['roc']}, h1, h2)"
    both = asked(file, "present(h1), present(h2)", "--withhold", "h2").popitem()[1]
    assert sum(found.values()) == pytest.approx(both, abs=1e-9)


def test_where_it_is_nobody_says(file):
    assert asked(file, "left_of(X, Y)", "--withhold", "h2") == {}
    without = Interpretation.load(file).withhold("h2")
    assert [a.probability for a in without.query("near(h1, h2, 100)")] == [0.0]
    assert not list(without.query("behind(X, Y)"))


def test_stock_problog_agrees_on_the_written_program(file):
    run = plogic("program", file, "--withhold", "h2")
    text = run.stdout.replace("query(present(h1)).", "query(roc(R, X, Y)).").replace("query(present(h2)).", "")
    theirs = {goal.replace(",", ", "): p for goal, p in stock(text).items() if p > 0}
    assert asked(file, "roc(R, X, Y)", "--withhold", "h2") == pytest.approx(theirs, abs=1e-9)


def test_python_answers_the_same(file):
    found = Interpretation.load(file).withhold("h2").query("partially_occludes(X, Y)")
    shown = {a.goal: a.probability for a in found}
    assert shown == pytest.approx(asked(file, "partially_occludes(X, Y)", "--withhold", "h2"), abs=1e-12)


def test_what_is_no_hypothesis_cannot_be_withheld(file, tmp_path):
    run = plogic("query", file, "--withhold", "h9")
    assert (run.returncode, run.stderr) == (1, "plogic: withhold: h9: should be among h1, h2\n")
    (tmp_path / "a.pl").write_text("0.5::a.\nquery(a).\n")
    run = plogic("query", tmp_path / "a.pl", "--withhold", "h1")
    assert run.returncode == 1
    assert "a program has no poses to withhold" in run.stderr
    with pytest.raises(Error, match="h9"):
        Interpretation.load(file).withhold("h9")


def test_it_is_written_and_read_again(without):
    again = interpretation_in(Document("again", json.loads(json.dumps(without))))
    assert situation_of(again) == situation_of(without)
    assert situation_of(again).withheld == {"h2"}
    assert all("h2" not in f.hidden_by for h in situation_of(again).hypotheses for f in h.features)


def test_both_of_two_may_be_withheld(document):
    fact = evidence(document, ["h1", "h2"])
    assert fact.pairs == (("h1", "h2"),)
    assert sum(p for p, _ in fact.states) == pytest.approx(1.0)


def test_one_that_is_seen_in_another_image_stands_somewhere(file, demo, document):
    """It is h3 here, as probable as there; by what it would hide it is likely before nothing that is all detected."""
    found = asked(file, "roc(R, h1, h3)", "--withhold", f"{file}:h2")
    both = asked(file, "present(h1), present(h3)", "--withhold", f"{file}:h2").popitem()[1]
    assert sum(found.values()) == pytest.approx(both, abs=1e-9)
    assert asked(file, "at(h3, X, Y, Z)", "--withhold", f"{file}:h2") == {}
    run = plogic("query", file, "--withhold", f"{file}:h8")
    assert (run.returncode, run.stderr) == (1, "plogic: h8: should be among the other image's h1, h2\n")
    other = {**document, "kb": {"name": "x", "digest": "y"}}
    with pytest.raises(Error, match="another knowledge base"):
        with_elsewhere(document, other, "h2")


def test_duplicates_change_nothing(document):
    """A second hypothesis of h1 that was not accepted: who stands around is Δi."""
    h1 = next(h for h in document["hypotheses"] if h["id"] == "h1")
    twice = {**document, "hypotheses": [*document["hypotheses"], {**h1, "id": "h7", "status": "rival"}]}
    assert evidence(twice, ["h2"]) == evidence(document, ["h2"])


def test_evidence_beside_two_poses_says_the_same_of_both_orders(document):
    alone = [evidence(document, [name]) for name in ("h1", "h2")]
    one, other = beside(*alone, "h1", "h2"), beside(*alone[::-1], "h2", "h1")
    assert sum(p for p, _ in one.states) == pytest.approx(1.0)
    assert {r: p for p, (r,) in one.states} == pytest.approx({converse(r): p for p, (r,) in other.states}, abs=1e-12)


def test_what_poses_tell_stays_and_evidence_is_beside_it(file):
    found = asked(file, "roc(R, h1, h2), evidence_roc(E, h1, h2)")
    assert {goal.split(",")[0] for goal in found} == {"roc(partially_occludes_po"}
    assert next(iter(found)) == "roc(partially_occludes_po, h1, h2), evidence_roc(partially_occludes_po, h1, h2)"


def test_a_doubt_gets_the_number_that_evidence_gives_its_relation(document):
    said = {"relation": "partially_occludes", "args": ["h1", "h2"], "expected": "x", "found": "y", "why": "z"}
    against = {**said, "relation": "totally_occludes", "args": ["h2", "h1"]}
    rows = doubts_weighed({**document, "doubts": [said, against]})["doubts"]
    assert rows[0]["evidence"] > 0.9
    assert rows[1]["evidence"] < 0.05


def test_pixels_are_told_without_those_that_nobody_located(document):
    """Who stands nowhere is before nobody, and nobody is before it."""
    keys = {"pixels_beside": [{"present": [], "pixels": 4.0}, {"present": ["h1"], "pixels": 1.0}]}
    told = {
        **document,
        "hypotheses": [{**h, **keys} if h["id"] == "h2" else h for h in document["hypotheses"]],
    }
    alone = PixelTable((), (4.0,))
    assert table_in(told) == PixelTable(("h1",), (4.0, 1.0))
    assert table_in(withheld(told, ["h1"])) == alone
    assert table_in(withheld(told, ["h2"])) == alone
    both, new = with_elsewhere(told, told, "h2")
    assert table_in(both, new) == alone
    assert table_in(both) == table_in(told)


def table_in(document, name="h2"):
    (found,) = (h.pixel_table for h in situation_of(document).hypotheses if h.id == name)
    return found
