"""A learned compound counts once (A1): in the cells, in ev, in the valuation, and in what worlds are made of.

Whatever the number of its parts.
"""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from learned_scenes import gamma_at, one_sided, pose_before, ready
from painted_cube import CAMERA, CORNER, cloud, picture, pose_towards, seen, write_knowledge

import plogic.cycle.delta
import plogic.run.document
from kb.clouds.learned import LearnedCloud, numbered
from kb.files.read import read_kb
from plogic.base.clock import Stopwatch
from plogic.cycle.delta import Options
from plogic.cycle.lumped import looked_at, told
from plogic.cycle.perception import attend
from plogic.facts.interpretation import situation_of, text_of
from plogic.facts.situation import OTHERS
from plogic.measures.explanatory import case_of, explanatory_value
from plogic.run.perceive import Perceiver
from plogic.scene.text.program_text import program_text
from plogic.scene.worlds.ranked_worlds import ranked_worlds
from sensing.detectors.detector import detect

COUNT = 24
WAYS = [("score", "to_B"), ("score", "drop"), ("score", "reassign"), ("posterior", "to_B")]
seeds = st.integers(0, 9999)


def with_groups(cloud, groups):
    """The cloud with compounds as ``numbered`` counts them."""
    return replace(cloud, compound=numbered(np.asarray(groups)))


def posed_of(cloud, seed, found=12):
    """A hypothesis of a type of this cloud, some of whose features are not expected, some of them found."""
    rng, pose = np.random.default_rng(seed), pose_before(np.random.default_rng(5))
    thing = ready(cloud)
    posed = thing.index.settle(pose, gamma_at(cloud, range(found), pose), thing.kb, rounds=0)
    count = len(posed.uv)
    matches = np.where(rng.random(count) < 0.5, np.arange(count), -1)
    arrays = {name: rng.random(count) < 0.7 for name in ("in_image", "in_lobe")}
    return replace(posed, matches=np.where(arrays["in_image"], matches, -1), hit=rng.random(count), **arrays), thing


def cells_by_loop(posed, hidden):
    """Of each compound the surest part's case; of each other feature its own."""
    kind, counts = posed.object_type, {}
    for w, feature in enumerate(kind.features):
        rows = [f for f in range(len(posed.uv)) if kind.whole[f] == w]
        order = [(not posed.in_image[f], not posed.candidate[f], not posed.detected[f], -posed.hit[f], f) for f in rows]
        f = min(order)[-1]
        if posed.in_image[f]:
            cell = counts.setdefault(feature.type, dict.fromkeys("ACBD", 0))
            cell[case_of(expected=bool(posed.candidate[f] and not hidden[f]), detected=bool(posed.detected[f]))] += 1
    return counts


@settings(max_examples=40, deadline=None, derandomize=True)
@given(seeds, st.sampled_from([2, 5, 12]))
def test_the_cells_are_those_of_a_loop_over_maximal_features(seed, number):
    rng = np.random.default_rng(seed)
    posed, _ = posed_of(with_groups(one_sided(1, COUNT), rng.integers(0, number, COUNT)), seed)
    hidden = rng.random(COUNT) < 0.3
    assert {name: vars(cells) for name, cells in posed.support(hidden).items()} == cells_by_loop(posed, hidden)
    assert np.bincount(posed.object_type.whole[posed.stands]).tolist() == [1] * len(posed.object_type.features)


@settings(max_examples=20, deadline=None, derandomize=True)
@given(seeds)
def test_a_compound_is_expected_or_detected_with_any_of_its_parts(seed):
    posed, _ = posed_of(with_groups(one_sided(1, COUNT), np.random.default_rng(seed).integers(0, 6, COUNT)), seed)
    whole = posed.object_type.whole
    assert posed.stands.any()
    for f in np.flatnonzero(posed.stands):
        parts = whole == whole[f]
        assert posed.in_image[f] == posed.in_image[parts].any()
        assert posed.candidate[f] == posed.candidate[parts].any()
        assert posed.detected[f] == (posed.detected & (posed.candidate | ~posed.candidate[parts].any()))[parts].any()


def doubled(cloud, parts):
    """The cloud, of a lobe a feature, with these features a second time, in the same compound."""
    arrays = {
        name: np.concatenate([getattr(cloud, name), getattr(cloud, name)[parts]])
        for name in LearnedCloud.__dataclass_fields__
        if name != "words"  # of all features together
    }
    return LearnedCloud(**arrays | {"feature": np.arange(len(arrays["at"]))})


@settings(max_examples=15, deadline=None, derandomize=True)
@given(seeds)
def test_doubling_the_parts_of_a_compound_leaves_ev_and_valuation_alone(seed):
    rng = np.random.default_rng(seed)
    cloud = with_groups(one_sided(1, COUNT), rng.integers(0, 5, COUNT))
    parts = np.flatnonzero(cloud.compound == rng.integers(1, cloud.compounds + 1))
    posed, thing = posed_of(cloud, seed)
    again = np.append(np.arange(COUNT), parts)
    arrays = {
        name: getattr(posed, name)[again]
        for name in ("at", "uv", "in_image", "in_lobe", "self_hidden", "hit", "matches")
    }
    other = ready(doubled(cloud, parts))
    twice = replace(posed, known_type=other.kind, **arrays)
    dv = dict(zip(thing.kb.words.names, rng.random(len(thing.kb.words.names)), strict=True))
    assert twice.support() == posed.support()
    assert explanatory_value(twice.support(), dv) == explanatory_value(posed.support(), dv)
    types = rng.choice(thing.kb.words.names, 9).tolist()
    assert attend([other.index], types, other.kb) == attend([thing.index], types, thing.kb)


@pytest.fixture(scope="module")
def perceiver(tmp_path_factory):
    """Of a painted cube; whose neighbours in space are said to be compounds."""
    flat = cloud(seen())
    cells = np.unique(np.floor(flat.at / 0.012), axis=0, return_inverse=True)[1].ravel() + 1
    return Perceiver(read_kb(write_knowledge(tmp_path_factory.mktemp("kb"), {"cube": with_groups(flat, cells)})))


@pytest.fixture(scope="module")
def gamma(perceiver):
    image = picture([pose_towards(CORNER, 0.60, 0.0, (0.0, 0.0))], seed=3)
    return detect(image, CAMERA, perceiver.kb.appearance_types, perceiver.kb.words)


@pytest.fixture(scope="module")
def document(perceiver, gamma):
    return perceiver(gamma)


def test_worlds_count_a_compound_once(perceiver, document):
    (h,) = (h for h in document["hypotheses"] if h["status"] == "accepted")
    (counts,) = h["support"].values()
    cells = [counts[key] for key in counts["weights"]]
    assert sum(f.get("stands_for", 1) for f in h["features"] if f["in_image"]) == sum(cells)
    assert sum(f.get("stands_for", 1) for f in h["features"]) + h["left_out"]["outside_image"] == len(
        perceiver.kb.type("cube").features
    )
    inner = [f for f in h["features"] if f.get("stands_for", 1) == 0]
    assert len(inner) > 5
    assert all(
        f["dv"] == 0.0 and "/" in f["id"] and f["id"].rpartition("/")[0] in {g["id"] for g in h["features"]}
        for f in inner
    )
    good = sum(f["dv"] for f in h["features"] if f["in_image"] and f["case"] in {"A", "B"})
    assert h["ev"] == pytest.approx(2.0 * good / sum(f["dv"] for f in h["features"] if f["in_image"]) - 1.0, abs=1e-9)
    assert len(document["hypotheses"]) > 1 or h["probability"] == pytest.approx(h["p_ev"], abs=1e-9)


def test_the_program_knows_the_parts_of_compounds_and_reads_back_the_same(document):
    situation = situation_of(json.loads(text_of(document)))
    again = ranked_worlds(situation, 100)
    assert [(w["probability"], tuple(w["present"])) for w in document["worlds"]] == [
        (w.probability, w.present) for w in again.worlds
    ]
    compounds = [part for part in situation.hypotheses[0].parts if part.kind == "feature"]
    text = program_text(situation)
    kind = situation.hypotheses[0].type
    told_parts = [f for f in situation.hypotheses[0].features if f.stands_for == 0]
    assert {part.id for part in compounds} >= {f.id.rpartition("/")[0] for f in told_parts}
    for compound in compounds:
        assert f"type_part({kind}/{compound.id}, {kind})." in text
        assert f"type_feature({kind}, {compound.id}, " in text
        assert f"::pick(h1, {compound.id})" in text
    for f in told_parts:
        assert f"type_part({kind}/'{f.id}', {kind}/{f.id.rpartition('/')[0]})." in text
        assert f"::pick(h1, '{f.id}')" not in text


@pytest.mark.parametrize(("reading", "reconsider"), WAYS)
def test_telling_what_is_left_out_changes_no_probability(perceiver, gamma, monkeypatch, reading, reconsider):
    short = perceiver(gamma, Options(reading, reconsider))
    for module in (plogic.cycle.delta, plogic.run.document):
        monkeypatch.setattr(module, "told", lambda posed: list(range(len(posed.uv))))
    monkeypatch.setattr(plogic.cycle.delta, "lumped", lambda _posed, _dv: ())
    full = perceiver(gamma, Options(reading, reconsider))
    assert len(full["hypotheses"][0]["features"]) > len(short["hypotheses"][0]["features"]) + 20
    assert [w["present"] for w in full["worlds"]] == [w["present"] for w in short["worlds"]]
    for a, b in zip(full["worlds"], short["worlds"], strict=True):
        assert a["probability"] == pytest.approx(b["probability"], abs=1e-9)


def test_a_rejected_hypothesis_tells_its_parts_too(perceiver, gamma):
    posed = perceiver.delta(gamma, Options(), Stopwatch())[0].beliefs["h1"]
    rows = looked_at(posed, [a.id for a in gamma.appearances], perceiver.dv)
    assert len(rows) == len(told(posed)) + 1
    assert sum(row.get("stands_for", 1) == 0 for row in rows) == sum(not posed.stands[f] for f in told(posed)) > 5
    assert rows[-1]["id"] == OTHERS
