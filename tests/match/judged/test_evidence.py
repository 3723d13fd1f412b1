"""The evidence of one hypothesis: the log-likelihood ratios of §8."""

from math import exp, log, pi

import numpy as np
import pytest
from synthetic import (
    CAMERA,
    belief_at,
    camera_pose,
    cycle_of,
    data,
    one_before_the_other,
    posed_at,
    scene,
    side_by_side,
    towers,
)

from plogic.cycle.delta import Options, delta_of
from plogic.match.gamma.data import data_of
from plogic.match.judged.evidence import FIXED_BY, clutter_density, density, evidence, hit_rates, log_share, sigmas
from plogic.match.judged.expectation import hidden_by
from plogic.run.perceive import Perceiver
from plogic.scene.worlds.ranked_worlds import ranked_worlds
from sensing.appearance import Appearance


@pytest.fixture(scope="module")
def view():
    rng = np.random.default_rng(7100)
    pose = camera_pose(rng, (3.0, 5.0))
    of = data(scene(rng, {"t1": pose}))
    return posed_at("t1", pose, of), of


def by_hand(posed, of, hidden=None):
    """Gains of the hits, penalties of the misses, feature by feature."""
    kb = towers()
    hits, misses = [], []
    for f, feature in enumerate(posed.object_type.features):
        if not posed.candidate[f] or (hidden is not None and hidden[f]):
            continue
        h = kb.rates.hit[feature.type]
        if posed.matches[f] < 0:
            misses.append(log(1 - h))
            continue
        sigma = kb.rates.sigma_of(posed.object_type.features[f].type)
        n = exp(-0.5 * (posed.residual[f] / sigma) ** 2) / (2 * pi * sigma**2)
        clutter = kb.rates.clutter[of.types[posed.matches[f]]] / (640 * 480)
        relative = clutter / n
        hits.append(log((h + relative - h * relative) / relative))
    return hits, misses


def test_the_ratio_is_the_sum_of_the_formulas(view):
    posed, of = view
    hits, misses = by_hand(posed, of)
    assert len(hits) > 10
    assert misses
    assert evidence(posed, of, towers()).ratio == pytest.approx(sum(hits) + sum(misses))


def test_the_surplus_leaves_out_the_three_best_matches(view):
    posed, of = view
    hits, misses = by_hand(posed, of)
    assert evidence(posed, of, towers()).surplus == pytest.approx(sum(sorted(hits)[:-FIXED_BY]) + sum(misses))


def test_what_is_hidden_pays_nothing_and_earns_nothing(view):
    posed, of = view
    hidden = np.zeros(len(posed.uv), dtype=bool)
    hidden[np.flatnonzero(posed.candidate)[::3]] = True
    hits, misses = by_hand(posed, of, hidden)
    assert evidence(posed, of, towers(), hidden).ratio == pytest.approx(sum(hits) + sum(misses))
    everything = np.ones_like(hidden)
    assert evidence(posed, of, towers(), everything).ratio == 0.0


def test_density_is_a_density():
    """It integrates to 1 over the plane, and is 0 where nothing matched."""
    r, step = np.linspace(0, 10, 20001, retstep=True)
    assert (2 * pi * r * density(r, 0.7)).sum() * step == pytest.approx(1.0, abs=1e-6)
    assert density(np.array([np.nan]), 0.5).tolist() == [0.0]


def test_clutter_is_a_rate_over_the_images_area():
    of = data_of(
        [Appearance("a", "patch", (1.0, 1.0), "drawn"), Appearance("b", "unknown_kind", (1.0, 1.0), "drawn")], CAMERA
    )
    assert clutter_density(towers(), of).tolist() == [towers().rates.clutter["patch"] / 307200, 1.0 / 307200]


def test_hit_rates_are_the_knowledge_bases(view):
    posed, _ = view
    rates = towers().rates.hit
    assert hit_rates(posed, towers()).tolist() == [rates[f.type] for f in posed.object_type.features]


def test_an_empty_gamma_gives_penalties_only():
    pose = camera_pose(np.random.default_rng(7101))
    of = data_of([], CAMERA)
    posed = posed_at("t2", pose, of)
    found = evidence(posed, of, towers())
    rates = towers().rates.hit
    expected = [posed.object_type.features[f].type for f in np.flatnonzero(posed.candidate)]
    assert found.ratio == found.surplus == pytest.approx(sum(log(1 - rates[name]) for name in expected))


@pytest.mark.parametrize("stand", [side_by_side, one_before_the_other])
def test_the_posteriors_log_odds_are_prior_plus_evidence(stand):
    """One claimant, nothing else in the world: the cycle's ratio and the share of poses that fit.

    No less than misses.
    """
    rng = np.random.default_rng(7102)
    shot = scene(rng, {"t1": stand(rng)["t1"]}, hit=0.5, patch_hit=0.15, clutter=3)
    of, ready = data(shot), Perceiver(towers())
    posed = posed_at("t1", shot.poses["t1"], of)
    cycle = cycle_of(shot.gamma)
    alone = type(cycle)((belief_at("t1", shot.poses["t1"], of),), (), (), (), cycle.trace)
    situation = delta_of(alone, of, towers(), ready.dv, Options(reading="posterior")).situation
    p = ranked_worlds(situation).marginals["h1"]
    prior = towers().rates.prior["t1"]
    ratio = evidence(posed, of, towers()).ratio
    found = posed.candidate & posed.detected
    share = log_share(posed.at[found], sigmas(posed, towers())[found] ** -2.0, posed.middle, of.camera)
    least = float(np.log(1 - hit_rates(posed, towers()))[posed.candidate].sum())
    assert abs(ratio + share) < 60.0, "a ratio that doubles can tell from certainty"
    assert log(p / (1 - p)) == pytest.approx(log(prior / (1 - prior)) + max(ratio + share, least), abs=1e-3)


def test_an_occluder_waives_exactly_the_hidden_misses():
    rng = np.random.default_rng(7103)
    shot = scene(rng, one_before_the_other(rng), clutter=0)
    of = data(shot)
    front, back = (posed_at(n, shot.poses[n], of) for n in ("t1", "t2"))
    hidden = hidden_by(back, front)
    waived = back.candidate & hidden & ~back.detected
    assert waived.any()
    assert not (back.candidate & hidden & back.detected).any(), "no clutter of this scene falls on a hidden feature"
    gain = evidence(back, of, towers(), hidden).ratio - evidence(back, of, towers()).ratio
    assert gain == pytest.approx(-np.log(1 - hit_rates(back, towers())[waived]).sum())
