"""Rank orders what is costly (§7.2.2): types are refined in its order, and only where they could explain better."""

from __future__ import annotations

from functools import cache

import pytest

from benchmarks.places.scenes import scene
from benchmarks.places.types import places_kb
from plogic.cycle.perception import attended, perceive
from plogic.cycle.state import Task, among
from plogic.match.gamma.data import data_of
from plogic.match.hand.hand_models import WAVE, HandSearch
from plogic.run.perceive import Perceiver

TYPES = 40
SCENES = range(6)


@cache
def perceiver():
    return Perceiver(places_kb(TYPES))


@cache
def asked_in(seed, way):
    """The outcome of a scene, what stands there, and the types of each wave: of one order, for all that ask of it."""
    gamma, truths = scene(perceiver().kb, seed, (3, 3))
    waves, propose = [], HandSearch.propose
    task = Task(data_of(gamma.in_order().appearances, gamma.camera), perceiver().kb, perceiver().models, perceiver().dv)
    with pytest.MonkeyPatch.context() as patched:
        patched.setattr(HandSearch, "propose", lambda *given: waves.append(given[1]) or propose(*given))
        cycle = perceive(task, attended(task)[::way])
    return cycle, {truth.type for truth in truths}, [wave for wave in waves if wave]


@pytest.mark.parametrize("seed", SCENES)
def test_what_is_there_is_tried_first_and_not_all_others_after_it(seed):
    cycle, there, waves = asked_in(seed, 1)
    accepted = {h.type for h in cycle.accepted}
    assert accepted == there & accepted
    assert all(len(wave) <= WAVE for wave in waves)
    order = [row.type for row in cycle.attention]
    first = [name for name in order if name in waves[0]]
    assert waves[0] == first
    assert len(set(first) & accepted) >= len(accepted) - 1
    assert len({name for wave in waves for name in wave}) < TYPES


def test_the_reversed_order_refines_more_types_for_the_same_answer():
    work = {1: 0, -1: 0}
    for seed in SCENES:
        found = {}
        for way in work:
            found[way], _, waves = asked_in(seed, way)
            work[way] += sum(map(len, waves))
        assert len(found[1].accepted) == len(found[-1].accepted)
        assert all(among(hypothesis, found[-1].accepted) for hypothesis in found[1].accepted)
    assert work[1] < work[-1]


def test_a_type_that_no_data_left_vote_for_is_not_refined(monkeypatch):
    gamma, _ = scene(perceiver().kb, 0, (3, 3))
    asked, propose = [], HandSearch.propose
    monkeypatch.setattr(HandSearch, "propose", lambda *given: asked.extend(given[1]) or propose(*given))
    monkeypatch.setattr(HandSearch, "promising", lambda *_: [])
    task = Task(data_of(gamma.in_order().appearances, gamma.camera), perceiver().kb, perceiver().models, perceiver().dv)
    assert not perceive(task).accepted
    assert not asked
