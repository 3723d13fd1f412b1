"""The posterior of a learned hypothesis.

Its log odds are its prior's, the evidence that the cycle counted, and the share of poses (§8).
"""

from __future__ import annotations

from dataclasses import replace
from math import log

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from learned_scenes import gamma_at, one_sided, pose_before, ready
from made_meshes import CORNERS, box_triangles

from geometry.frames import from_rotation_translation, transform_points
from kb.surfaces.surface import Surface
from plogic.cycle.delta import Options, delta_of
from plogic.cycle.state import Cycle, Trace
from plogic.logic.safety.author import load_problog
from plogic.match.judged.evidence import CLEAR, clarity, evidence, hit_rates, log_share
from plogic.match.judged.expectation import hidden_by
from plogic.scene.text.program_text import program_text, query_lines
from plogic.scene.worlds.ranked_worlds import ranked_worlds

SURE = 25.0
"""Log odds that doubles can tell from certainty."""
FEATURES = 30
POSTERIOR = Options(reading="posterior")


def stand(seed, wide, found):
    """A thing of 30 features, so much as wide as usual, ``found`` of them detected a pixel off.

    Its belief, Γ and knowledge base.
    """
    rng = np.random.default_rng(seed)
    cloud = one_sided(seed, FEATURES)
    cloud = replace(cloud, at=cloud.at * wide)
    thing, pose = ready(cloud), pose_before(rng)
    of = gamma_at(cloud, rng.permutation(FEATURES)[:found], pose)
    of.uv[:] += rng.normal(0, 1.0, of.uv.shape)
    return thing, believed(thing.index.settle(pose, of, thing.kb, rounds=0), thing, of), of


def believed(posed, thing, of):
    told = evidence(posed, of, thing.kb)
    return posed.told(worth=told.ratio, surplus=told.surplus, ev=0.5, ev_reconsidered=0.5, status="accepted")


def situation_of(beliefs, of, kb):
    return delta_of(
        Cycle(tuple(beliefs), (), (), (), Trace()), of, kb, dict.fromkeys(kb.words.names, 0.5), POSTERIOR
    ).situation


def said(posed, of, kb, hidden=None):
    """What the posterior adds to the prior's log odds.

    The evidence without its prior of clarity, and the share of poses that fit as well.

    It never says less than if all that was found had been missed.
    """
    expected = posed.candidate & (True if hidden is None else ~hidden)
    used = expected & posed.detected
    share = log_share(posed.at[used], posed.counted[used] / posed.sigma[used] ** 2, posed.middle, of.camera)
    least = float((posed.counted * np.log(1 - hit_rates(posed, kb, hidden)))[expected].sum())
    ratio = evidence(posed, of, kb, hidden).ratio - CLEAR * log(clarity(posed, hidden))
    return max(ratio + share, least)


def log_odds(p):
    return log(p / (1 - p))


@settings(max_examples=30, deadline=None, derandomize=True)
@given(st.integers(0, 999), st.sampled_from([0.01, 0.03, 0.05, 0.1]), st.integers(0, 16), st.floats(0.05, 0.95))
def test_log_odds_are_prior_plus_what_a_fitted_pose_says(seed, wide, found, prior):
    thing, belief, of = stand(seed, wide, found)
    kb = replace(thing.kb, rates=replace(thing.kb.rates, prior={"thing": prior}))
    ratio = said(belief, of, kb)
    assume(abs(ratio + log_odds(prior)) < SURE)
    assert belief.counted.min() < 0.5, "features crowd, so that shares make a difference"
    p = ranked_worlds(situation_of([belief], of, kb)).marginals["h1"]
    assert log_odds(p) == pytest.approx(log_odds(prior) + ratio, abs=1e-3)


@pytest.mark.parametrize(("seed", "wide", "found"), [(1, 0.05, 15), (6, 0.05, 9), (11, 0.02, 3), (3, 1.0, 2)])
def test_a_stock_problog_says_the_same_of_the_text(seed, wide, found):
    load_problog()
    from problog import get_evaluatable
    from problog.program import PrologString

    thing, belief, of = stand(seed, wide, found)
    situation = situation_of([belief], of, thing.kb)
    ratio = said(belief, of, thing.kb)
    assert abs(ratio) < SURE
    text = program_text(situation) + query_lines(situation)
    (p,) = get_evaluatable("ddnnf").create_from(PrologString(text)).evaluate().values()
    assert log_odds(p) == pytest.approx(log_odds(situation.priors["thing"]) + ratio, abs=1e-3)
    assert p == pytest.approx(ranked_worlds(situation).marginals["h1"], abs=1e-9)


def test_behind_an_accepted_plate_they_are_those_of_what_is_to_be_seen():
    """Given that the plate is there: hidden features neither count, nor make the image unclear."""
    seed = 5
    thing, belief, of = stand(seed, 0.05, 12)
    at = transform_points(belief.camera_from_object, thing.cloud.at)
    edge = float(np.median(0.3 * at[:, 0] / at[:, 2]))
    wall = ready(one_sided(2, 12), Surface(CORNERS * (2.0, 2.0, 0.001), box_triangles()), name="plate")
    kb = replace(thing.kb, types=(thing.kind, wall.kind))
    plate = wall.index.settle(
        from_rotation_translation(np.eye(3), [edge - 2.0, -1.0, 0.3]),
        of.only(np.zeros(12, bool)),
        kb,
        rounds=0,
    )
    hidden = hidden_by(belief, plate)
    left = ~np.isin(np.arange(12), belief.matches[hidden])
    of = of.only(left)
    posed = thing.index.settle(belief.camera_from_object, of, kb, rounds=0)
    assert 5 < hidden.sum() < FEATURES - 5
    assert not (hidden & posed.detected).any()
    situation = situation_of([believed(posed, thing, of), believed(plate, wall, of)], of, kb)
    both, plate_alone = (present(situation, ids) for ids in (("h1", "h2"), ("h2",)))
    ratio = said(posed, of, kb, hidden)
    assert abs(ratio) < SURE
    prior = situation.priors["thing"]
    assert log(both / plate_alone) == pytest.approx(log_odds(prior) + ratio, abs=1e-3)


def present(situation, ids):
    """Probability of the world in which these are present."""
    return next(world.probability for world in ranked_worlds(situation).worlds if world.present == ids)
