"""``plogic bench calibration``.

Its scenes, its truth, its forecasts, and end to end through the command line on few scenes.
"""

from __future__ import annotations

import json
from dataclasses import replace
from itertools import combinations
from xml.etree import ElementTree as ET

import numpy as np
import pytest
from click.testing import CliRunner

from benchmarks.calibration import bench as calibration
from benchmarks.calibration.bench import FIRST_OF_TRAINING, Plan, learned_on
from benchmarks.calibration.forecasts import CYCLE, GATE, P_EV, POSTERIOR, READINGS, Forecast, forecasts_of, gated
from benchmarks.calibration.scenes import CAMERA, DETECTOR, OWN, SIBLINGS, random_world, scene
from benchmarks.calibration.table import claims, rows
from benchmarks.calibration.truth import true_ones
from cli import cli
from geometry.frames import from_rotation_translation, rotation_from_quat_xyzw, transform_points
from plogic.cycle.judging import FEWEST
from plogic.cycle.state import same_hypothesis
from plogic.match.gamma.data import data_of
from plogic.match.judged.rivals import SAME_ROTATION
from plogic.rates.scene_records import TrueObject
from plogic.run.perceive import Perceiver


@pytest.fixture(scope="module")
def world():
    return random_world(0)


@pytest.fixture(scope="module")
def perceiver(world):
    return Perceiver(world.kb)


def test_siblings_have_one_body_and_share_most_looks(world):
    assert len(world.kb.types) % SIBLINGS == 0
    for first in range(0, len(world.kb.types), SIBLINGS):
        family = world.kb.types[first : first + SIBLINGS]
        for one, other in combinations(family, 2):
            assert np.array_equal(one.lobes.at, other.lobes.at)
            shared = np.mean([a == b for a, b in zip(one.lobes.types, other.lobes.types, strict=True)])
            assert 1 - 3 * OWN < shared < 1


def test_a_scene_is_the_same_again_and_holds_what_is_said_to_stand_there(world):
    one, again = scene(world, 3), scene(world, 3)
    assert one.gamma.appearances == again.gamma.appearances
    assert one.gamma.appearances != scene(world, 4).gamma.appearances
    uv = one.gamma.uv
    assert CAMERA.contains(uv).all()
    assert one.truth.complete
    for true in one.truth.objects:
        kind = world.kb.type(true.label)
        shown = CAMERA.project(transform_points(true.camera_from_object, kind.lobes.at))
        near = np.linalg.norm(shown[:, None] - uv[None], axis=2) < 4 * DETECTOR.sigma
        right = np.array(kind.lobes.types)[:, None] == np.array([a.type for a in one.gamma.appearances])[None]
        assert (near & right).any(axis=1).sum() >= 0.1 * true.visible_fraction * len(shown)


def poses(world, *angles):
    """The first type before the camera, turned by so many radians from a common pose; and the type itself."""
    kind = world.kb.types[0]
    turns = [rotation_from_quat_xyzw([np.sin(a / 2), 0, 0, np.cos(a / 2)]) for a in angles]
    return kind, [from_rotation_translation(R, [0.0, 0.0, 1.0]) for R in turns]


def test_the_nearest_of_the_right_type_and_about_the_pose_is_true_and_no_other(world):
    kind, (near, nearer, far, true) = poses(world, 0.6 * SAME_ROTATION, -0.3 * SAME_ROTATION, 1.2 * SAME_ROTATION, 0.0)
    objects = [TrueObject(kind.name, true, 1.0)]
    assert true_ones({"h1": (kind, near), "h2": (kind, nearer), "h3": (kind, far)}, objects) == {"h2"}
    assert true_ones({"h3": (kind, far)}, objects) == frozenset()
    assert true_ones({"h1": (world.kb.types[1], true)}, objects) == frozenset()
    assert true_ones({"h1": (kind, near), "h2": (kind, nearer)}, objects * 2) == {"h1", "h2"}


def test_hypotheses_passed_the_gate_and_are_merged(world, perceiver):
    gamma = scene(world, 5).gamma
    delta = gated(perceiver, data_of(gamma.appearances, gamma.camera))
    posed = list(delta.beliefs.values())
    assert len(posed) > 1
    assert all((p.candidate & p.detected).sum() >= FEWEST for p in posed)
    assert not any(same_hypothesis(one, other) for one, other in combinations(posed, 2))


def test_forecasts_are_probabilities_of_every_reading_and_the_same_again(world, perceiver):
    shown = scene(world, 2)
    found = forecasts_of(perceiver, shown, 2)
    assert found == forecasts_of(perceiver, shown, 2)
    assert {f.among for f in found} == {GATE, CYCLE}
    assert all(list(f.said) == list(READINGS) and 0.0 <= p <= 1.0 for f in found for p in f.said.values())
    assert sum(f.true for f in found if f.among == GATE) <= len(shown.truth.objects)


def test_rates_are_learned_about_as_they_are(world):
    kb = learned_on(world, range(FIRST_OF_TRAINING, FIRST_OF_TRAINING + 40))
    hit, clutter = (
        np.array([table[name] for name in world.kb.appearance_types]) for table in (kb.rates.hit, kb.rates.clutter)
    )
    assert np.abs(hit - world.hit).mean() < 0.06
    assert np.abs(clutter / world.clutter - 1).max() < 0.25
    assert replace(kb, rates=world.kb.rates).types == world.kb.types


def test_what_is_printed_is_that_of_the_forecasts():
    """One scene a forecast: half say 0.75 and three of four are true, half say 0.25 and one of four is.

    P(ev) says 1 of all.
    """
    rows_of = [(0.75, i % 4 != 0) for i in range(40)] + [(0.25, i % 4 == 0) for i in range(40)]
    found = [Forecast(i, GATE, true, dict.fromkeys(READINGS, p) | {P_EV: 1.0}) for i, (p, true) in enumerate(rows_of)]
    table = {row["reading"]: row for row in rows(found)}
    assert (table[POSTERIOR]["hypotheses"], table[POSTERIOR]["true"], table[POSTERIOR]["open"]) == (80, 40, 80)
    assert (table[POSTERIOR]["ECE"], table[POSTERIOR]["Brier"], table[POSTERIOR]["skill"]) == (0.0, 0.1875, 0.25)
    assert (table[P_EV]["ECE"], table[P_EV]["skill"], table[P_EV]["open"]) == (0.5, -1.0, 0)
    assert [c.met for c in claims(found)] == [False, False, True, True]
    assert [c.met for c in claims(found, 0.08)] == [True, True, True, True]


def test_the_command_learns_judges_and_draws(monkeypatch, tmp_path):
    monkeypatch.setattr(calibration, "QUICK", Plan(training=4, judged=3))
    picture = tmp_path / "calibration.svg"
    command = ["bench", "calibration", "--quick", "--json", "--picture", str(picture)]
    done = CliRunner().invoke(cli, command)
    document = json.loads(done.stdout)
    assert done.exit_code == (0 if all(claim["met"] for claim in document["claims"]) else 1)
    assert document["bench"] == "calibration"
    assert [row["reading"] for row in document["rows"] if row["among"] == GATE] == list(READINGS)
    assert [claim["bar"] for claim in document["claims"]][:2] == [">= 5", ">= 1"], "three scenes of six hundred"
    assert ET.parse(picture).getroot().tag.endswith("svg")  # noqa: S314 - our own file
