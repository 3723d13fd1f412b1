"""``plogic bench places`` end to end on few scenes; its types and its scenes."""

from __future__ import annotations

import json
from collections import Counter

import numpy as np
import pytest

from benchmarks.many.placing import meet
from benchmarks.places.bench import run
from benchmarks.places.scenes import APPEARANCES, OBJECTS, scene
from benchmarks.places.types import FEATURES, LOOKS, places_kb
from geometry.frames import transform_points


def test_a_real_run_finds_what_is_there():
    said = []
    text, _ = run(seed=0, quick=True, as_json=True, say=said.append, scenes=3, sizes=(12,))
    document = json.loads(text)
    row = document["rows"][0]
    assert document["bench"] == "places"
    assert (row["types"], row["scenes"], row["false"]) == (12, 3, 0)
    assert row["found"] == row["posed"] == row["there"] >= 4
    assert [line.split(":")[0] for line in said] == ["12 types, 1/3", "12 types, 2/3", "12 types, 3/3"]
    assert len(document["claims"]) == 4


@pytest.mark.parametrize("seed", range(3))
def test_types_are_polyhedra_with_stated_symmetries(seed):
    kb = places_kb(12, seed)
    assert kb.rates.sigma_angle is None
    assert LOOKS[0] <= len(kb.appearance_types) <= LOOKS[1]
    assert any(len(kind.symmetries) > 1 for kind in places_kb(50, seed).types)
    for kind in kb.types:
        assert FEATURES[0] <= len(kind.features) <= FEATURES[1]
        assert kind.surface is not None
        assert kind.surface.solid is not None
        at, looks = np.array([f.at for f in kind.features]), [f.type for f in kind.features]
        for motion in kind.symmetries:
            gap = np.linalg.norm(transform_points(motion, at)[:, None] - at, axis=2)
            assert gap.min(axis=1).max() < 1e-6
            assert [looks[i] for i in gap.argmin(axis=1)] == looks


def test_scenes_keep_their_bounds_and_are_the_same_again():
    kb = places_kb(12)
    counts = Counter()
    for seed in range(12):
        gamma, truths = scene(kb, seed)
        assert scene(kb, seed)[0] == gamma
        assert APPEARANCES[0] <= len(gamma.appearances) <= APPEARANCES[1]
        assert all(a.angle is None and not a.arms for a in gamma.appearances)
        counts[len(truths)] += 1
        bodies = [(kb.type(t.type), t.camera_from_object) for t in truths]
        assert not any(meet(*one, *other) for i, one in enumerate(bodies) for other in bodies[:i])
    assert min(counts) >= OBJECTS[0]
    assert max(counts) <= OBJECTS[1]
    assert len(counts) > 2
