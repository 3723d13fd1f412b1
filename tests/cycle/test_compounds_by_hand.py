"""Compounds written by hand (A1): detected by their parts, whose data they claim all; counted once."""

from __future__ import annotations

import re
from collections import Counter
from functools import cache

import numpy as np
import pytest
from box_kb import CAMERA, box_kb, corner_rows, feature_row, seen

from geometry.frames import look_at
from plogic.cycle.delta import Options
from plogic.facts.hypothesis import feature_nodes
from plogic.facts.interpretation import situation_of
from plogic.measures.distinctiveness import instance_counts
from plogic.run.measured import measured
from plogic.run.perceive import Perceiver
from plogic.scene.asking.presence import presence
from plogic.scene.text.program_text import program_text
from sensing.appearance import Appearance, Gamma

POSE = look_at((0.55, 0.4, 0.5), (0.0, 0.0, 0.0))
UP = (0.0, 0.0, 1.0)
DOTS = {"d0": (0.05, 0.02), "d1": (-0.06, 0.05), "d2": (0.02, -0.06)}
"""Places on the upper face, m."""
PARTS = {"left": (-0.012, 0.0), "right": (0.012, 0.004), "low": (0.0, -0.013)}
"""... of the parts of a compound in the place of d0, from there."""


@cache
def kb_with(*parts, look="dot"):
    """A box with corners and three dots, d0 a compound of these parts, each by name and place; without any, an atom."""
    rows = corner_rows(np.full(3, 0.1))
    rows += [
        feature_row(name, "dot", (x, y, 0.1), UP, 80) for name, (x, y) in DOTS.items() if not parts or name != "d0"
    ]
    if parts:
        rows.append(f"  - feature: d0\n    type: dot\n    at: {[*DOTS['d0'], 0.1]}\n    features:\n")
        rows += [feature_row(name, look, (x, y, 0.0), UP, 80, "      ") for name, (x, y) in parts]
    return box_kb("box", np.full(3, 0.1), rows)


@cache
def perceiver(*parts):
    return Perceiver(kb_with(*parts))


def gamma_of(kb, without=()):
    """Γ of all that is to be seen of the box, but for some features."""
    kept = [(f.type, tuple(uv.tolist())) for f, uv in seen(kb, POSE) if f.name not in without]
    return Gamma(CAMERA, tuple(Appearance(f"a{i}", *row, "made") for i, row in enumerate(kept)))


def found(parts, without=(), reading="score"):
    """The one accepted hypothesis, and the data that the most probable world calls noise."""
    document = perceiver(*parts)(gamma_of(kb_with(*parts), without), Options(reading=reading))
    (row,) = [h for h in document["hypotheses"] if h["status"] == "accepted"]
    assert np.allclose(row["T_camera_object"], POSE, atol=0.01)
    return row, sum(cause == "noise" for cause in document["worlds"][0]["causes"].values())


ONE, THREE = (("left", (0.0, 0.0)),), tuple(PARTS.items())


@pytest.mark.parametrize("reading", ["score", "posterior"])
def test_a_compound_of_one_member_is_that_member(reading):
    plain, of_one = found((), reading=reading)[0], found(ONE, reading=reading)[0]
    assert of_one["support"] == plain["support"]
    for key in ("ev", "ev_reconsidered", "p_ev", "probability", "log_likelihood_ratio"):
        assert of_one[key] == pytest.approx(plain[key], abs=1e-9), key
    plain, of_one = found((), ("d1",), reading)[0], found(ONE, ("d1",), reading)[0]
    assert of_one["support"] == plain["support"]  # ev differs by dv alone: each Feature node counts in S (§5.1)


def test_splitting_a_feature_into_parts_that_are_all_detected_changes_no_cell():
    plain, split = found(())[0], found(THREE)[0]
    assert split["support"] == plain["support"]
    assert split["ev"] == pytest.approx(1.0)


@pytest.mark.parametrize("lost", [("d0/left",), ("d0/right", "d0/low")])
def test_one_part_is_enough_and_no_datum_of_another_is_noise(lost):
    row, noise = found(THREE, lost)
    assert row["ev"] == pytest.approx(1.0)
    assert row["support"]["dot"]["expected_detected"] == 3
    assert noise == 0


@pytest.mark.parametrize("reading", ["score", "posterior"])
def test_the_parts_beside_the_one_that_stands_for_it_are_not_counted_as_none(reading):
    kb = kb_with(*THREE, look="knob")
    document = Perceiver(kb)(gamma_of(kb, ()), Options(reading=reading))
    (name,) = document["worlds"][0]["present"]
    lines = presence(situation_of(document), name, [name])
    assert any("corner" in line for line in lines)
    assert not any(re.search(r"\b0 \w+", line) for line in lines if "detected:" in line)


def test_in_the_posterior_it_is_missed_once_and_not_beside_a_part_that_is_found():
    """As if it had only the parts that are detected; and one without any is a feature that is missed."""
    names = tuple(f"d0/{part}" for part in PARTS)
    none, plain = found(THREE, names, "posterior")[0], found((), ("d0",), "posterior")[0]
    two, whole = found(THREE, ("d0/left",), "posterior")[0], found(THREE[1:], (), "posterior")[0]
    assert none["log_likelihood_ratio"] == pytest.approx(plain["log_likelihood_ratio"], abs=1e-9)
    assert two["log_likelihood_ratio"] == pytest.approx(whole["log_likelihood_ratio"], abs=1e-9)
    assert two["probability"] == pytest.approx(whole["probability"], abs=1e-9)
    (missed,) = [f for f in two["features"] if f["id"] == "d0/left"]
    assert (missed["hit_rate"], missed["stands_for"]) == (0.0, 0)


def test_without_any_of_its_parts_it_is_missed_once():
    row, _ = found(THREE, tuple(f"d0/{part}" for part in PARTS))
    assert row["support"]["dot"] == {
        "expected_detected": 2,
        "expected_missed": 1,
        "hidden_missed": 0,
        "hidden_detected": 0,
    }
    assert row["support"] == found((), ("d0",))[0]["support"]


def test_every_feature_node_counts_in_the_dv_over_instances_and_is_a_feature_of_the_program():
    """S of §5.1 counts a compound and its parts; the part that it is told by is a feature as well."""
    kb = kb_with(*THREE, look="knob")
    document = Perceiver(kb)(gamma_of(kb), Options(dv_over="instances"))
    _, over = measured(document)
    assert {row.type: row.over_instances for row in over} == pytest.approx(document["measures"]["dv"])
    (h,) = situation_of(document).hypotheses
    text = program_text(situation_of(document))
    for part in PARTS:
        assert f"type_feature(box, 'd0/{part}', knob)" in text
        assert f"type_part(box/'d0/{part}', box/d0)" in text
    nodes = feature_nodes(h.parts, [(f.id, f.type) for f in h.features])
    assert Counter(nodes.values()) == instance_counts(kb.types)
