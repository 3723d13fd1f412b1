"""Relations between parts: of which pairs, and what is left out (§3.5-3.7)."""

from itertools import combinations

import numpy as np
import pytest
from synthetic import belief_at, data, one_before_the_other, scene

from geometry.visibility.roc import ROC20
from plogic.cycle import delta as relations
from plogic.cycle.delta import part_relations_of, relations_of
from plogic.facts.situation import both_ways


@pytest.fixture(scope="module")
def shown():
    """Three posed towers: two true ones, and one moved behind them."""
    rng = np.random.default_rng(7411)
    shot = scene(rng, one_before_the_other(rng))
    of = data(shot)
    posed = {name: belief_at(name, pose, of) for name, pose in shot.poses.items()}
    far = shot.poses["t1"].copy()
    far[2, 3] += 1.5
    return posed | {"far": belief_at("t1", far, of)}, list(combinations([*posed, "far"], 2)), shot.gamma.camera


def told(facts):
    """(node of x, node of y) → the relations told of them, both ways."""
    found = {}
    for fact in facts:
        ends = ((fact.x, fact.parts[0]), (fact.y, fact.parts[1]))
        for relation, pair in zip(both_ways(fact), (ends, ends[::-1]), strict=False):
            found.setdefault(pair, []).append(relation)
    return found


def test_every_pair_of_nodes_of_two_hypotheses_has_one_relation_each_way(shown):
    found = told(part_relations_of(*shown))
    assert len(found) == 3 * 2 * (3 * 3 - 1)
    assert {len(some) for some in found.values()} == {1}
    assert all(some[0] in ROC20 for some in found.values())
    assert all(x != y for (x, _), (y, _) in found)
    assert all(part or other for (_, part), (_, other) in found)


def test_where_the_whole_is_apart_the_parts_are(shown):
    whole, parts = told(relations_of(*shown)), told(part_relations_of(*shown))
    apart = {(x, y) for ((x, _), (y, _)), (relation,) in whole.items() if relation == "non_occludes_dc"}
    inside = [relation for ((x, _), (y, _)), (relation,) in parts.items() if (x, y) in apart]
    assert set(inside) <= {"non_occludes_dc"}
    in_front = {
        (x, y)
        for ((x, _), (y, _)), (relation,) in whole.items()
        if relation.startswith(("partially_occludes", "totally_occludes"))
    }
    assert in_front
    some = [relation for ((x, _), (y, _)), (relation,) in parts.items() if (x, y) in in_front]
    assert not [relation for relation in some if "occluded_by" in relation]


def test_beyond_the_most_pairs_nothing_is_told(shown, monkeypatch):
    everything = part_relations_of(*shown)
    monkeypatch.setattr(relations, "MOST_PART_PAIRS", 5)
    assert len(told(part_relations_of(*shown))) == 2 * 5
    assert part_relations_of(*shown) == everything[: len(part_relations_of(*shown))]
