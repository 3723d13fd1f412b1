"""``plogic bench scale`` on a few types.

The index of the first ones, the limit on entries, exchanged looks, and the tables.
"""

from __future__ import annotations

import json
from functools import partial

import numpy as np
import pytest

from benchmarks.clutter.scenes import trial
from benchmarks.clutter.types import EASY
from benchmarks.scale.bench import Plan, run
from benchmarks.scale.types import bodies, first, made_ready
from benchmarks.scale.votes import capped, entries, falsely_accepted, seen, standing, under_cap, with_more
from plogic.match.gamma.grid import part_of_circle

LOOKS = 10
"""So few that each of the types has them all."""


@pytest.fixture(scope="module")
def made():
    return bodies(4, 5000)


@pytest.fixture(scope="module")
def ready(made):
    return made_ready(made.alike(LOOKS), made.cells, LOOKS)


@pytest.fixture(scope="module")
def posed(ready):
    return trial(ready.kb.types[1], ready.kb, EASY, np.random.default_rng(5000), appearances=200)


def test_the_first_of_many_are_what_they_are_alone(made, ready):
    some, alone = first(ready, 2), made_ready(made.alike(LOOKS)[:2], made.cells[:2], LOOKS)
    assert some.shared.looks == alone.shared.looks
    for name in ("key", "entry", "turned"):
        np.testing.assert_array_equal(getattr(some.shared, name), getattr(alone.shared, name))
    assert some.dv == alone.dv


def test_fewer_looks_are_the_same_bodies(made):
    types = made.alike(LOOKS)
    assert {name for kind in types for name in kind.lobes.types} == {f"a{i:03d}" for i in range(LOOKS)}
    np.testing.assert_array_equal(types[0].lobes.at, made.types[0].lobes.at)
    assert made.alike(3000) == list(made.types)


def test_a_limit_leaves_entries_out(ready, posed):
    asked = entries(ready, [posed]) * len(ready.indices)
    whole, none = standing(ready, posed), under_cap(ready, posed, 0)
    assert asked > whole.others.sum() > 0
    assert (none.right, none.others.sum()) == (0, 0)
    assert under_cap(ready, posed, int(asked) + 1).right == whole.right
    assert under_cap(ready, posed, int(asked) // 4).others.sum() < whole.others.sum()


def test_entries_are_counted_as_they_are_looked_up(ready):
    index, angles, both = capped(ready.shared, None), (np.array([0.3]), np.array([2.0])), (np.array([2]), np.array([5]))
    index.found(both, angles, 0.0)
    pair = ready.shared.key // 1024 == 2 * LOOKS + 5
    parts = [(ready.shared.key // 32 % 32), ready.shared.key % 32]
    near = [
        (np.abs((part - part_of_circle(angle, 32) + 16) % 32 - 16) <= 2)
        for part, angle in zip(parts, angles, strict=True)
    ]
    assert index.asked == [int((pair & near[0] & near[1]).sum())]


def test_exchanged_looks_are_more_types_and_nothing_of_theirs_is_there(ready, posed):
    before = standing(ready, posed)
    after = with_more(ready, posed, before, 3, np.random.default_rng(0))
    assert after.types == before.types + 12
    assert after.right == before.right
    assert 2.0 < after.others.sum() / before.others.sum() < 8.0
    few = trial(ready.kb.types[1], ready.kb, EASY, np.random.default_rng(5000), appearances=120)
    assert falsely_accepted(ready, few.gamma, np.random.default_rng(1)) == 0


def test_the_object_is_laid_and_found(ready, posed):
    one = seen(ready, posed)
    assert one.laid
    assert one.found
    assert min(one.stages) >= 0.0


def test_all_tables_are_there(monkeypatch):
    """In images of fewer data than the benchmark's."""
    monkeypatch.setattr("benchmarks.scale.bench.trial", partial(trial, appearances=120))
    plan = Plan((2, 4, 8), (100,), frames=1, trials=2, caps=1, deep=1, passes=(2,), built=4, kept=4)
    said: list[str] = []
    document = json.loads(run(seed=50, quick=True, as_json=True, say=said.append, plan=plan)[0])
    tables = {row["table"] for row in document["rows"]}
    assert len(tables) == 8
    recall = [row for row in document["rows"] if row["table"] == "recall"]
    assert [row["types"] for row in recall] == [100, 1000, 10**4, 10**5, 10**6]
    assert all(row["laid 2000"] <= row["laid 20000"] <= row["laid 200000"] for row in recall)
    assert recall[-1]["limited"] == 0.0
    assert [row["types"] for row in document["rows"] if "predicted" in row] == [8, 24]
    assert len(document["claims"]) == 3
    assert said[-1] == "100 looks: done"
