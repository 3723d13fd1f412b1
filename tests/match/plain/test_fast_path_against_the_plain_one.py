"""The fast search is held to the paper's plain one, which tries every set of four: what it accepts explains no less.

Evidence is a step function of the pose at two edges: where a viewpoint leaves a lobe, and where a datum lies just
within the match tolerance. Two refined poses about one optimum, some tenths of a degree apart, may lie on either side
of one of them. So of each object the fast search may explain less by what *one* match says at most, and an object of
which one match fewer is too few to be accepted is no part of the law.
"""

import numpy as np
import pytest
from plain_scenes import ANGLES, PLACES, apart, claimed, interpreted, world

from plogic.cycle.judging import FEWEST

SEEDS = range(8)
SCENES = [(objects, seed, angles) for objects in (1, 2) for seed in SEEDS for angles in (ANGLES, PLACES)]
MISSED = {
    (
        2,
        14,
        PLACES,
    ): "without angles: it comes to within a degree, but three of five data lie within the tolerance there, where four are demanded",
}
MORE = [(1, 36, ANGLES), (1, 49, ANGLES), (1, 49, PLACES), (2, 30, ANGLES), (2, 46, ANGLES), (2, 54, PLACES)]
"""Of the first sixty seeds, scenes in which the fast search misses what the plain one finds; and in which it once did,
or is at an edge."""
LAW = [
    *SCENES,
    *MORE,
    *(pytest.param(*scene, marks=pytest.mark.xfail(reason=why, strict=True)) for scene, why in MISSED.items()),
]
UNLIKE = {
    (2, 4, ANGLES): "the fast one accepts an object more: of its four data POSIT makes no pose",
    (2, 6, ANGLES): "at the edge: three of four expected features detected, where four are demanded",
}


def one_match(kb):
    """The most that one match says: right in the middle, at the very angle."""
    hit, clutter = max(kb.rates.hit.values()), min(kb.rates.clutter.values()) / (640 * 480)
    near = 1.0 / (2.0 * np.pi * kb.rates.sigma**2)
    if kb.rates.sigma_angle is not None:
        near *= np.sqrt(2.0 * np.pi) / kb.rates.sigma_angle
    return np.log((hit * near + (1.0 - hit) * clutter) / clutter)


def clear(belief):
    """Whether it would be accepted without one of its matches, too."""
    return (belief.candidate & belief.detected).sum() > FEWEST


@pytest.mark.parametrize(("objects", "seed", "angles"), LAW)
def test_the_fast_path_explains_no_less_than_the_plain_one(objects, seed, angles):
    fast, plain = (interpreted(objects, seed, angles, generator)[0] for generator in ("index", "quadruples"))
    edge = one_match(world(objects, seed, angles)[0])
    some = [belief for belief in plain if clear(belief)]
    assert sum(b.worth for b in fast) >= sum(b.worth for b in some) - edge * len(some)
    for belief in some:
        (same,) = [b for b in fast if b.object_type is belief.object_type]
        assert same.worth >= belief.worth - edge


def alike(fast, plain):
    """Whether each has its like: one of its type within one degree and one percent, or that claims the same data."""
    near = [[apart(one, other)[0] <= 1.0 and apart(one, other)[1] <= 0.01 for other in plain] for one in fast]
    same = [[claimed(one) == claimed(other) and apart(one, other)[0] < np.inf for other in plain] for one in fast]
    return len(fast) == len(plain) and all(any(np.logical_or(a, b)) for a, b in zip(near, same, strict=True))


@pytest.mark.parametrize(("objects", "seed", "angles"), [scene for scene in SCENES if scene not in UNLIKE])
def test_both_accept_the_same(objects, seed, angles):
    fast, plain = (interpreted(objects, seed, angles, generator)[0] for generator in ("index", "quadruples"))
    assert alike(fast, plain)


def test_the_scenes_have_something_to_accept():
    counts = [len(interpreted(*scene, "quadruples")[0]) for scene in SCENES]
    assert sum(count > 0 for count in counts) >= 26
    assert sum(count > 1 for count in counts) >= 6


def test_what_posit_makes_no_pose_of_the_fast_path_has_more():
    fast, plain = (interpreted(2, 4, ANGLES, generator)[0] for generator in ("index", "quadruples"))
    assert sum(b.worth for b in fast) > sum(b.worth for b in plain) + 50.0
    (more,) = [b for b in fast if b.object_type.name not in {other.object_type.name for other in plain}]
    assert (more.candidate & more.detected).sum() == FEWEST


def test_what_only_the_plain_one_accepts_the_fast_one_proposed_and_judged_at_the_edge():
    accepted, rejected = interpreted(2, 6, ANGLES, "index")
    (missed,) = [
        b
        for b in interpreted(2, 6, ANGLES, "quadruples")[0]
        if not any(apart(b, other)[0] < 90.0 for other in accepted)
    ]
    (near,) = [b for b in rejected if apart(b, missed)[0] < 3.0]
    assert not clear(missed)
    assert "only 3 of its expected features detected" in near.why


@pytest.mark.parametrize("seed", SEEDS)
def test_what_either_accepts_is_there(seed):
    _, _, truths = world(2, seed, ANGLES)
    for generator in ("index", "quadruples"):
        assert {b.object_type.name for b in interpreted(2, seed, ANGLES, generator)[0]} <= {
            truth.type for truth in truths
        }
