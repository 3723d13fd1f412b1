"""Sides of edges in a checkered floor are evidence of nothing.

What matches say of places across their edges, by the formula.
"""

from __future__ import annotations

from math import exp, pi, sqrt

import numpy as np
import pytest
from learned_scenes import ready, with_sides
from random_cloud import random_cloud
from test_patterns import BRIGHT, CAMERA, MIDDLE, checkered, gamma, square

from plogic.match.judged.evidence import clutter_density, evidence, hit_rates, match_density
from plogic.match.learned.agreement import lobes_held
from plogic.match.learned.learned_match import SIDES_NOISE, matched, pose_of
from plogic.match.learned.sides import FEW_SIDES, MANY, ORDERED, side_likeness, side_matches

SIZE = 60.0
POSE = np.array([[1.0, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0.9], [0, 0, 0, 1]])
"""Before the camera, and not turned: a metre is 1000 pixels."""


@pytest.fixture(scope="module")
def tile():
    """A type that looks as one of the floor's bright squares does, seen from its front."""
    own, way = square(SIZE)
    count = len(own)
    at = np.column_stack([own / 1000.0 + 0.0005, np.zeros(count)])
    up = np.column_stack([np.cos(way), np.sin(way), np.zeros(count)])
    ranges = {
        "half_angle": np.full(count, 0.9),
        "r_min": np.full(count, 0.1),
        "r_max": np.full(count, 3.0),
        "hit": np.full(count, 0.8),
    }
    lobes = {"axis": np.tile([0.0, 0.0, -1.0], (count, 1)), "up": up, "sigma": np.full(count, 1e-5)} | ranges
    return ready(with_sides(random_cloud(0, count, count, width=138, at=at, **lobes), range(count), BRIGHT))


def floor(tiles, seed=0, noise=0.3):
    """So many squares about the one in the middle, on all sides; and only its own bright sides where there are none."""
    uv, angle, looks = checkered(SIZE, max(tiles, 1))
    some = (
        np.ones(len(uv), bool)
        if tiles
        else (np.abs(uv - MIDDLE).max(axis=1) < SIZE / 2 + 1) & (looks == BRIGHT).all(axis=1)
    )
    uv = uv + np.random.default_rng(seed).normal(0, noise, uv.shape)
    return gamma(uv[some], angle[some], looks[some])


def sides(tile, data, free=None):
    posed = pose_of(tile.index, POSE, data, tile.kb)
    lobes = lobes_held(tile.index, POSE, CAMERA.f / tile.kb.f_ref)
    return side_matches(
        tile.index, posed, data, lobes, data.sided if free is None else free, np.full(len(tile.cloud.at), 3.0)
    )


def test_a_square_of_a_floor_is_a_pattern_and_a_square_alone_is_none(tile):
    on_floor, alone = floor(6), floor(0)
    assert ORDERED <= sides(tile, on_floor).pattern <= 1.0
    found = sides(tile, alone)
    assert len(found.feature) > 0.9 * len(tile.cloud.at)
    assert found.pattern == 0.0


def test_of_few_matches_no_pattern_is_told(tile):
    data = floor(6)
    whole = sides(tile, data)
    few = int(max(FEW_SIDES, np.ceil(MANY * len(tile.cloud.at)))) - 1
    for count, pattern in ((few + 1, True), (few, False)):
        free = ~data.sided
        free[whole.datum[:count]] = True
        found = sides(tile, data, free)
        assert len(found.feature) == count
        assert (found.pattern >= ORDERED) == pattern


@pytest.mark.parametrize("tiles", [0, 6])
def test_what_a_match_says_is_its_density_across_the_line_against_what_is_usual(tile, tiles):
    """In a pattern: at most as much as one that is found with the chance of the pattern anyway."""
    data = floor(tiles)
    found = sides(tile, data)
    sigma = np.full(len(found.feature), 0.7)
    like, usual = side_likeness(found, sigma, data, tile.kb), clutter_density(tile.kb, data, found.datum)
    says = [
        n * exp(-0.5 * (off / 0.7) ** 2) / (2 * pi * 0.7**2) / f
        for n, off, f in zip(like, found.off, usual, strict=True)
    ]
    rare = [
        r * exp(-0.5 * (off / 0.7) ** 2) / (sqrt(2 * pi) * 0.7) for r, off in zip(found.rare, found.off, strict=True)
    ]
    assert says == pytest.approx(rare if tiles == 0 else np.minimum(rare, 1.0 / found.pattern).tolist())
    assert len(says) > 10


def test_a_square_of_a_floor_is_no_evidence_and_a_square_alone_is(tile):
    ratio = {}
    for tiles in (6, 0):
        data = floor(tiles)
        posed = matched(tile.index, pose_of(tile.index, POSE, data, tile.kb), data, tile.kb)
        assert posed.detected.sum() > 10
        usual, hit = (
            clutter_density(tile.kb, data, posed.matches[posed.detected]),
            hit_rates(posed, tile.kb)[posed.detected],
        )
        gain = (hit * match_density(posed, tile.kb)[posed.detected] + (1 - hit) * usual) / usual
        assert gain.max() <= 1 / ORDERED + 1e-9 or tiles == 0
        ratio[tiles] = evidence(posed, data, tile.kb).ratio
    assert ratio[6] < 5.0
    assert ratio[0] > 15.0


def test_the_noise_across_edges_is_told_by_the_sides_and_is_never_less_than_for_round_bodies(tile):
    for noise in (0.0, 1.0):
        data = floor(0, noise=noise)
        posed = matched(tile.index, pose_of(tile.index, POSE, data, tile.kb), data, tile.kb)
        assert (posed.sigma >= SIDES_NOISE).all()
        found = posed.detected
        assert found.sum() > 10
        off = np.abs(((data.uv[posed.matches[found]] - posed.uv[found]) * posed.across[found]).sum(axis=1))
        np.testing.assert_allclose(posed.residual[found], off, atol=1e-9)
        assert np.isnan(posed.residual[~found]).all()
        assert np.isnan(posed.across[~found]).all()
        assert posed.sigma.mean() == pytest.approx(max(SIDES_NOISE, noise), rel=0.3)
