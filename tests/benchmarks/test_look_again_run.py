"""`plogic bench look-again`: its scenes hide the difference, its policies go where they say, a few scenes run whole."""

from __future__ import annotations

import json
from types import SimpleNamespace

import numpy as np
import pytest

from benchmarks.clutter.scenes import visible
from benchmarks.look_again import bench as module
from benchmarks.look_again.episode import fixed, widest
from benchmarks.look_again.scenes import scene
from benchmarks.look_again.table import Counted, claims, interval
from benchmarks.look_again.types import MARK, look_alikes
from geometry.frames import inverse
from plogic.sequence.next_view.moves import Candidate

SEED = 3


@pytest.fixture(scope="module")
def kb():
    return look_alikes(SEED)


def test_twins_differ_in_their_mark_alone_and_turned_ones_look_the_same_turned(kb):
    a, b = kb.type("twin0_a"), kb.type("twin0_b")
    assert np.array_equal(a.lobes.at, b.lobes.at)
    differs = np.array([x != y for x, y in zip(a.lobes.types, b.lobes.types, strict=True)])
    assert np.flatnonzero(differs).tolist() == list(range(len(differs) - MARK, len(differs)))
    turned = kb.type("turned0")
    own = turned.lobes.at[:-MARK]
    half = {(*np.round(p * [-1, -1, 1], 6), t) for p, t in zip(own, turned.lobes.types, strict=False)}
    assert half == {(*np.round(p, 6), t) for p, t in zip(own, turned.lobes.types, strict=False)}


@pytest.mark.parametrize("seed", [0, 3, 5, 8])
def test_the_first_view_does_not_show_a_mark_that_is_turned_away(kb, seed):
    one = scene(kb, seed)
    assert one.sort in ("behind", "two")
    for standing in one.objects:
        shown = visible(standing.kind, inverse(one.first) @ standing.pose, kb.f_ref)
        assert shown[-MARK:].sum() <= 1
        assert shown.sum() > 10


def test_the_same_place_shows_the_same_again_and_another_place_something_else(kb):
    one = scene(kb, 4)
    first, again, other = (one.view("v", one.first, n).gamma.appearances for n in (0, 0, 1))
    assert first == again
    assert first != other


def test_policies_go_to_places_that_are_left():
    places = [Candidate(str(i), _around(30 * i)) for i in range(12)]
    begun = SimpleNamespace(places=places)
    assert widest(begun, [0]) == 6
    assert widest(begun, [0, 6]) in (3, 9)
    assert fixed(3)(begun, [0]) == 3
    assert fixed(3)(begun, [0, 3, 6, 9]) == 1


def _around(degrees):
    pose = np.eye(4)
    pose[:2, 3] = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    return pose


def test_claims_are_about_views_saved_beyond_chance():
    found = [Counted("behind", 0.5, {"ours": 2, "same": 2, "worse": 2 + i % 2}, i) for i in range(60)]
    by_name = {claim.claim: claim for claim in claims(found, "ours", 0)}
    assert by_name["ambiguous scenes"].met
    assert not by_name["views saved over same, low end"].met
    assert by_name["views saved over worse, low end"].met
    of_few = {claim.claim: claim.met for claim in claims(found, "worse", 0, 60)}
    assert of_few == {"ambiguous scenes": True, "views saved over ours": False, "views saved over same": False}
    low, high = interval(np.array([1.0, 2.0, 3.0] * 20), 0)
    assert low < 2.0 < high


def test_a_scene_runs_whole(monkeypatch):
    monkeypatch.setattr(module, "POLICIES", {name: module.POLICIES[name] for name in (module.OURS, "widest baseline")})
    said = []
    text, met = module.run(seed=SEED, quick=True, as_json=True, say=said.append, scenes=1)
    document = json.loads(text)
    assert len(said) == 1
    assert document["bench"] == "look-again"
    assert [row["policy"] for row in document["rows"]] == [module.OURS, "widest baseline"]
    assert all(2 <= row["views"] <= 7 for row in document["rows"])
    assert not met
