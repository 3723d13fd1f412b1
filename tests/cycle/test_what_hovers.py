"""From a simulated camera's Γ to probabilities.

A false hypothesis that hovers loses by gravity, and what stands does not.
"""

from __future__ import annotations

import json
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from synthetic import CAMERA, cycle_of, data, perceiver, scene, side_by_side, towers, upright

from geometry.frames import inverse
from plogic.cycle.delta import Options, delta_of
from plogic.cycle.planes import FREE
from plogic.facts.interpretation import situation_of, text_of
from plogic.run.document import document_of
from plogic.run.perceive import Perceiver
from plogic.scene.asking.live import scene_answers
from plogic.scene.asking.presence import presence
from plogic.scene.text.program_text import program_text
from plogic.scene.worlds.ranked_worlds import ranked_worlds

HIGH = 0.6
"""Metres above the floor that the false tower begins: the picture of one on a wall, say."""


@cache
def shot():
    """Two towers on the floor, and between them, farther away, the appearances of a third that hovers.

    The world is the first's frame.
    """
    rng = np.random.default_rng(7411)
    poses = side_by_side(rng)
    camera = replace(CAMERA, world_from_camera=inverse(poses["t1"]))
    eye, other = camera.world_from_camera[:2, 3], (camera.world_from_camera @ poses["t2"])[:2, 3]
    away = (other / 2 - eye) / np.linalg.norm(other / 2 - eye)
    hovering = upright(*(other / 2 + 1.5 * away), 0.7)
    hovering[2, 3] = HIGH
    real = scene(rng, poses, camera=camera)
    false = scene(rng, {"t2": poses["t1"] @ hovering}, camera=camera, hit=0.7, patch_hit=0.6, clutter=0)
    more = tuple(replace(a, id=f"b{i}") for i, a in enumerate(false.gamma.appearances))
    return replace(real, gamma=replace(real.gamma, appearances=(*real.gamma.appearances, *more)))


@cache
def found():
    return cycle_of(shot().gamma)


def told(reading="score", **said):
    """The situation of what was found, by a KB that says so of gravity."""
    return delta_of(found(), data(shot()), replace(towers(), **said), perceiver().dv, Options(reading)).situation


def false_one(situation):
    """The id of the hypothesis that hovers: by its place, half a metre up or more."""
    world = shot().gamma.camera.world_from_camera
    (name,) = [h.id for h in situation.hypotheses if (world @ np.array(h.camera_from_object))[2, 3] > 0.5]
    return name


@pytest.mark.parametrize("ground", [None, 0.0])
def test_what_hovers_loses_and_what_stands_does_not(ground):
    before, held = ranked_worlds(told()).marginals, told(gravity=True, ground=ground)
    after, false = ranked_worlds(held).marginals, false_one(held)
    assert len(after) == 3
    assert after[false] < 0.6 * before[false]
    for name in after.keys() - {false}:
        assert after[name] == pytest.approx(before[name], abs=0.005), (
            "but for what the false one's cells and the unknown ground make of it"
        )
    assert {answer.goal for answer in scene_answers(held, ["floats(X)"])[0] if answer.probability > 0.05} == {
        f"floats({false})"
    }


def test_the_posterior_odds_fall_by_the_chance_of_an_unknown_support():
    """Where the ground is told and nothing may hold it, whatever else is there."""
    before, after = (
        ranked_worlds(told("posterior", **said))
        for said in ({}, {"gravity": True, "ground": 0.0, "unknown_support": 0.01})
    )
    without = {w.present for w in before.worlds}
    assert without == {w.present for w in after.worlds}
    assert after.log_evidence == pytest.approx(before.log_evidence + np.log(0.01), abs=1e-6), (
        "it is as good as sure, so all worlds pay"
    )


def test_without_gravity_not_a_byte_is_another():
    plain, said = told(), told(unknown_support=0.5, ground=1.0)
    assert program_text(said) == program_text(plain)
    assert "body_rests(h" not in program_text(plain)


def test_the_document_has_the_facts_and_gives_them_back():
    said = {"gravity": True, "unknown_support": 0.2, "ground": 0.0}
    delta = delta_of(found(), data(shot()), replace(towers(), **said), perceiver().dv, Options())
    held, cycle = delta.situation, found()
    ranking = ranked_worlds(held, 10)
    document = json.loads(
        text_of(document_of(towers(), shot().gamma, delta, cycle.rejected, cycle.trace.document(), ranking, None))
    )
    assert document["gravity"] == {"unknown_support": 0.2, "ground": 0.0}
    kinds = [fact["fact"] for fact in document["facts"]]
    assert kinds.count("foot") == 3
    grounded = [[h.id, "ground"] for h in held.hypotheses if h.id != false_one(held)]
    assert [fact["args"] for fact in document["facts"] if fact["fact"] == "rests_on"] == grounded
    assert situation_of(document) == held
    old = {key: value for key, value in document.items() if key != "gravity"}
    assert situation_of(old).gravity is None


def test_why_says_who_is_held_and_who_floats():
    held = told(gravity=True)
    world, false = tuple(h.id for h in held.hypotheses), false_one(held)
    assert set(world) > {false}
    for name in world:
        lines = presence(held, name, world)
        assert any("held by the ground" in line for line in lines) == (name != false)
        assert any("against: it floats" in line and "0.1" in line for line in lines) == (name == false)


def test_a_perceiver_says_it_in_the_file_and_keeps_silent_without_an_up():
    kb, gamma = replace(towers(), gravity=True), shot().gamma
    with_up, unknown, plain = (
        Perceiver(some)(seen) for some, seen in ((kb, gamma), (kb, replace(gamma, camera=CAMERA)), (towers(), gamma))
    )
    assert [fact["fact"] for fact in with_up["facts"]].count("foot") == 3
    assert "which way is up" in unknown["gravity"]["silent"]
    assert [h["probability"] for h in unknown["hypotheses"]] == [h["probability"] for h in plain["hypotheses"]]
    assert "gravity" not in plain


def test_either_gravity_or_support_weighs_what_a_hypothesis_rests_on():
    kb = perceiver().kb

    def of(shown, **said):
        models = perceiver().models
        return delta_of(
            found(), shown, replace(kb, **said), perceiver().dv, Options("posterior"), models=models
        ).situation

    speaking = of(data(shot()), gravity=True)
    assert speaking.gravity.feet
    assert speaking.support is None
    maybe = of(data(shot()), gravity=False, maybe=True)
    assert maybe.gravity is None
    assert maybe.support is not None
    gamma = replace(shot().gamma, camera=replace(shot().gamma.camera, world_from_camera=None))
    silent = of(data(replace(shot(), gamma=gamma)), gravity=True)
    assert silent.gravity.silent
    assert silent.support.by_chance == tuple((h.id, FREE.on) for h in silent.hypotheses)
