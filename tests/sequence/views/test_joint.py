"""What several views say together: one Situation (§8), in the world."""

from __future__ import annotations

import numpy as np
import pytest
from sequences import BESIDE, POSTERIOR, turned, view
from synthetic import perceiver, towers

from geometry.frames import pose_error
from plogic.base.clock import Stopwatch
from plogic.match.gamma.data import data_of
from plogic.scene.worlds.ranked_worlds import ranked_worlds
from plogic.sequence.views.joint import joint
from plogic.sequence.views.standing import Seen, Standing, seen_alone, standing_of


def seen(*views):
    return [Seen(v, data_of(v.gamma.appearances, v.gamma.camera)) for v in views]


def standing(name, pose):
    return Standing(perceiver().models[name], pose)


def there():
    return [standing(name, pose) for name, pose in BESIDE.items()]


def lone(chance):
    return np.log(chance / (1.0 - chance))


def test_features_and_data_of_each_view_are_there_under_their_own_names():
    views = view(1, turned(0.0)), view(2, turned(8.0))
    found, _ = joint(seen(*views), there(), perceiver(), POSTERIOR)
    features = len(towers().type("t1").features)
    (t1,) = [h for h in found.situation.hypotheses if h.type == "t1"]
    assert len(t1.features) == 2 * features
    assert {f.id.split(":")[0] for f in t1.features} == {"v1", "v2"}
    assert len(found.situation.appearances) == sum(len(v.gamma.appearances) for v in views)


@pytest.mark.parametrize("seed", [0, 1])
def test_two_views_are_surer_than_either(seed):
    """Of a tower of which each view alone shows less than it should; what its pose owes is owed once."""
    views = [view(n, turned(4.0 * n), hit=0.3, patch_hit=0.3, seed=seed) for n in (1, 2)]
    some = [standing("t1", BESIDE["t1"])]
    chances = [
        joint(seen(*these), some, perceiver(), POSTERIOR)[1].marginals["h1"] for these in (views[:1], views[1:], views)
    ]
    assert max(chances[:2]) < 0.5 < chances[2]


def test_an_empty_second_view_elsewhere_changes_nothing():
    first, other = view(1, turned(0.0), hit=0.2, patch_hit=0.2), view(2, turned(100.0), clutter=0)
    found, both = joint(seen(first, other), [standing("t2", BESIDE["t2"])], perceiver(), POSTERIOR)
    alone = joint(seen(first), found.standing, perceiver(), POSTERIOR)[1]
    assert both.marginals == pytest.approx(alone.marginals, rel=1e-6)


def test_the_order_of_views_changes_no_probability():
    views = [view(n, turned(4.0 * n), hit=0.15, patch_hit=0.15) for n in (1, 2, 3)]
    wrong = BESIDE["t1"].copy()
    wrong[:2, 3] += 0.35
    some = [*there(), standing("t1", wrong)]
    one = joint(seen(*views), some, perceiver(), POSTERIOR)[1]
    other = joint(seen(*views[::-1]), some, perceiver(), POSTERIOR)[1]
    assert one.marginals == pytest.approx(other.marginals, abs=1e-6)


def test_poses_are_better_of_views_that_lie_apart():
    """From two sides the distance is known, which one view tells worst."""
    eyes = np.array([-4.0, -4.5, 2.2]), np.array([4.0, -4.5, 2.2])
    off = []
    for seed in range(4):
        views = [view(n, turned(0.0, eye), seed=seed, noise=1.0) for n, eye in enumerate(eyes, 1)]
        start = BESIDE["t2"].copy()
        start[:3, 3] += [0.02, -0.03, 0.02]
        for these in (views[:1], views):
            found, _ = joint(seen(*these), [standing("t2", start)], perceiver(), POSTERIOR)
            off.append(pose_error(found.standing[0].world_from_object, BESIDE["t2"], towers().type("t2").symmetries)[1])
    assert np.mean(off[1::2]) < 0.5 * np.mean(off[::2])


def test_of_one_view_the_joint_worlds_are_those_of_the_image():
    v = view(1, turned(4.0), hit=0.35, patch_hit=0.35, seed=1)
    delta, _, _ = perceiver().delta(v.gamma, POSTERIOR, Stopwatch())
    some = [standing_of(b, v, perceiver().models) for b in delta.beliefs.values()]
    found, ranking = joint(seen(v), some, perceiver(), POSTERIOR)
    order = [f"h{1 + next(i for i, one in enumerate(some) if one is mine)}" for mine in found.standing]
    image = ranked_worlds(delta.situation)
    assert order
    assert [lone(p) for p in ranking.marginals.values()] == pytest.approx(
        [lone(image.marginals[h]) for h in order], abs=0.2
    )


def test_without_a_view_there_is_nothing_to_judge():
    with pytest.raises(ValueError, match="no view"):
        joint([], there(), perceiver(), POSTERIOR)


def test_alone_a_hypothesis_is_matched_where_it_stands():
    v = view(1, turned(0.0))
    posed = seen_alone(standing("t1", BESIDE["t1"]), seen(v)[0], towers())
    assert posed.detected.sum() >= 10
