"""What an interpretation carries of how a learned type is seen.

The surest lobes of each direction, up to a stated number, and what was left out.
"""

from __future__ import annotations

import numpy as np
import pytest
from learned_scenes import ready
from random_cloud import random_cloud

from plogic.run import carried
from plogic.run.carried import types_document


@pytest.fixture(scope="module")
def thing():
    return ready(random_cloud())


def _table(thing):
    return types_document({"thing": thing.kind}, thing.kb)["thing"]


def test_all_lobes_are_carried_where_they_are_few_enough(thing):
    table, lobes = _table(thing), np.array(_table(thing)["lobes"])
    assert len(lobes) == len(thing.cloud.hit)
    assert "left_out" not in table
    assert np.allclose(lobes[:, 8], thing.cloud.hit, atol=1e-4)
    names = [row[0] for row in table["features"]]
    assert [names[int(f)] for f in lobes[:, 0]] == [thing.kind.seen_features[f].name for f in thing.cloud.feature]


def test_of_more_the_surest_of_each_direction_are_and_the_rest_is_counted(thing, monkeypatch):
    direction = (thing.cloud.axis @ carried.DIRECTIONS.T).argmax(axis=1)
    most = len(set(direction.tolist()))
    monkeypatch.setattr(carried, "MOST_LOBES", most)
    table = _table(thing)
    kept = np.array(table["lobes"])
    assert len(kept) == most
    assert table["left_out"] == {"lobes": len(thing.cloud.hit) - most}
    surest = {d: thing.cloud.hit[direction == d].max() for d in set(direction.tolist())}
    assert most < len(thing.cloud.hit)
    assert sorted(kept[:, 8]) == pytest.approx(sorted(surest.values()), abs=1e-4)
    assert kept[:, 0].max() == len(table["features"]) - 1
