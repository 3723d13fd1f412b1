"""Features of a learned type that no world expects or detects are told as one.

Every probability stays, and the document says how many.
"""

from __future__ import annotations

import json

import numpy as np
import pytest
from painted_cube import CAMERA, CORNER, cloud, picture, pose_towards, seen, write_knowledge

import plogic.cycle.delta
import plogic.run.document
from kb.files.read import read_kb
from plogic.base.clock import Stopwatch
from plogic.cycle.delta import Options
from plogic.cycle.lumped import left_out, looked_at, told
from plogic.facts.interpretation import situation_of, text_of
from plogic.facts.situation import OTHERS
from plogic.run.perceive import Perceiver
from plogic.scene.asking.explanations import present
from plogic.scene.text.program_text import program_text
from plogic.scene.worlds.ranked_worlds import ranked_worlds
from sensing.detectors.detector import detect

WAYS = [("score", "to_B"), ("score", "drop"), ("score", "reassign"), ("posterior", "to_B")]


@pytest.fixture(scope="module")
def perceiver(tmp_path_factory):
    return Perceiver(read_kb(write_knowledge(tmp_path_factory.mktemp("kb"), {"cube": cloud(seen())})))


@pytest.fixture(scope="module")
def gamma(perceiver):
    image = picture([pose_towards(CORNER, 0.60, 0.0, (0.0, 0.0))], seed=3)
    return detect(image, CAMERA, perceiver.kb.appearance_types, perceiver.kb.words)


@pytest.fixture(scope="module")
def document(perceiver, gamma):
    return perceiver(gamma)


def _in_full(monkeypatch):
    for module in (plogic.cycle.delta, plogic.run.document):
        monkeypatch.setattr(module, "told", lambda posed: list(range(len(posed.uv))))
    monkeypatch.setattr(plogic.cycle.delta, "lumped", lambda _posed, _dv: ())


@pytest.mark.parametrize(("reading", "reconsider"), WAYS)
def test_telling_them_as_one_changes_no_probability(perceiver, gamma, monkeypatch, reading, reconsider):
    options = Options(reading, reconsider)
    short = perceiver(gamma, options)
    _in_full(monkeypatch)
    monkeypatch.setattr("plogic.run.document.OTHERS", "no such feature")
    full = perceiver(gamma, options)
    assert len(full["hypotheses"][0]["features"]) > len(short["hypotheses"][0]["features"]) + 20
    assert [w["present"] for w in full["worlds"]] == [w["present"] for w in short["worlds"]]
    for a, b in zip(full["worlds"], short["worlds"], strict=True):
        assert a["probability"] == pytest.approx(b["probability"], abs=1e-9)


def test_it_reads_back_to_the_same_probabilities(document):
    situation = situation_of(json.loads(text_of(document)))
    again = ranked_worlds(situation, 100)
    assert [(w["probability"], tuple(w["present"])) for w in document["worlds"]] == [
        (w.probability, w.present) for w in again.worlds
    ]
    others = [f for f in situation.hypotheses[0].features if f.id == OTHERS]
    assert len(others) == 1
    assert others[0].stands_for > 20
    assert program_text(situation).count(OTHERS) == 1


def test_the_document_says_how_many_are_left_out(perceiver, document):
    h = document["hypotheses"][0]
    (counts,) = h["support"].values()
    weights = counts["weights"]
    cells = [counts[key] for key in weights]
    assert sum(f.get("stands_for", 1) for f in h["features"] if f["in_image"]) == sum(cells)
    assert sum(f.get("stands_for", 1) for f in h["features"]) + h["left_out"]["outside_image"] == len(
        perceiver.kb.type("cube").features
    )
    good, bad = (
        weights["expected_detected"] + weights["hidden_missed"],
        weights["expected_missed"] + weights["hidden_detected"],
    )
    assert h["ev"] == pytest.approx((good - bad) / (good + bad), abs=1e-9)


def test_what_no_question_needs_is_not_carried(document, gamma):
    assert any(a.descriptor for a in gamma.appearances)
    assert not any("descriptor" in a for a in document["appearances"])
    assert document["causes_else"] == "noise"
    matched = {f["match"] for h in document["hypotheses"] for f in h["features"]}
    assert 0 < len(document["worlds"][0]["causes"]) <= len(matched)
    assert {f["type"] for f in document["hypotheses"][0]["features"] if f["id"] != OTHERS} <= document["measures"][
        "dv"
    ].keys()


def test_a_rejected_hypothesis_can_be_looked_at(perceiver, gamma):
    delta, _, _ = perceiver.delta(gamma, Options(), Stopwatch())
    posed = delta.beliefs["h1"]
    rows = looked_at(posed, [a.id for a in gamma.appearances], perceiver.dv)
    assert [row["stands_for"] for row in rows if row["id"] == OTHERS] == [
        sum(left_out(posed).values()) - left_out(posed)["outside_image"]
    ]
    assert len(rows) == len(told(posed)) + 1 == np.count_nonzero(posed.candidate | posed.detected) + 1
    assert sum(row["expected"] and row["detected"] for row in rows) == np.count_nonzero(
        posed.candidate & posed.detected
    )


def test_the_explanation_counts_all_and_stays_short(document):
    situation = situation_of(document)
    summary = present(situation, "present(h1)", given=()).summary
    in_image = sum(f.stands_for for f in situation.hypotheses[0].features if f.in_image)
    assert any(f"of {in_image} features in the image" in line for line in summary)
    assert max(len(line) for line in summary) < 400
