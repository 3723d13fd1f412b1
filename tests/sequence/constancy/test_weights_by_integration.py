"""The weight of a track against its definition, integrated by brute force; persistence against drawn lobes.

Turns against drawn directions.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from moved_views import CAMERA, RATES, all_of, ring, views_of

from geometry.frames import inverse, transform_points
from plogic.match.gamma.grid import screen_angle
from plogic.sequence.constancy.sight_lines import View, sights_of
from plogic.sequence.constancy.tracks import DEPTHS, tracks_of
from plogic.sequence.constancy.weights import HALF_ANGLES, log_pattern, log_turns, log_weights
from sensing.appearance import Gamma


@pytest.mark.parametrize("count", [2, 3])
def test_laplaces_integral_is_the_integral(count):
    rng = np.random.default_rng(5)
    views, _ = views_of(np.array([[0.02, -0.03, 0.12]]), ring(count, 15.0), rng)
    sights = sights_of(views, all_of(views), RATES)
    tracks = tracks_of(sights)
    which = int((tracks.data >= 0).sum(axis=1).argmax())
    one = tracks.take(np.array([which]))
    expected = log_weights(sights, one, None)[0] - _pattern(one, sights)
    assert expected == pytest.approx(_by_sampling(views, one, rng), abs=0.1)


def _pattern(one, sights):
    towards = sights.eye - one.places.at[:, None]
    towards /= np.linalg.norm(towards, axis=-1, keepdims=True)
    return log_pattern(towards, sights.in_image(one.places.at), one.data >= 0, np.array([0.8]))[0]


def _by_sampling(views, one, rng):
    """The logarithm of n ∫ p(X) Π N dX / Π f in pixels, by importance sampling about the place, four times as wide."""
    covariance = 16.0 * one.places.covariance[0]
    draws = rng.multivariate_normal(one.places.at[0], covariance, 200_000)
    off = draws - one.places.at[0]
    proposal = np.exp(-0.5 * np.einsum("ni,ij,nj->n", off, np.linalg.inv(covariance), off)) / np.sqrt(
        (2 * np.pi) ** 3 * np.linalg.det(covariance)
    )
    area = CAMERA.width * CAMERA.height
    value, place = np.ones(len(draws)), np.zeros(len(draws))
    for view in views:
        points = transform_points(inverse(view.world_from_camera), draws)
        residual = CAMERA.project(points) - np.array(view.gamma.appearances[0].uv)
        value *= np.exp(-0.5 * (residual**2).sum(axis=1)) / (2 * np.pi) / (4.0 / area)
        place += CAMERA.f**2 / (area * points[:, 2] ** 3 * np.log(DEPTHS[1] / DEPTHS[0])) / len(views)
    return float(np.log(4.0 * np.mean(value * place / proposal)))


def test_persistence_is_the_mean_over_lobes():
    rng = np.random.default_rng(6)
    towards = np.array([[1.0, 0, 0], [0.8, 0.6, 0], [0, 1.0, 0], [-1.0, 0, 0]])
    detected, in_view = np.array([True, False, True, False]), np.array([True, True, True, False])
    axes = rng.normal(size=(400_000, 3))
    axes /= np.linalg.norm(axes, axis=1, keepdims=True)
    half = rng.choice(HALF_ANGLES, len(axes))
    seen = 0.8 * (axes @ towards.T >= np.cos(half)[:, None])
    each = np.where(detected, seen, np.where(in_view, 1.0 - seen, 1.0)).prod(axis=1)
    said = log_pattern(towards[None], in_view[None], detected[None], np.array([0.8]))[0]
    assert said == pytest.approx(np.log(each.mean() / seen[:, 0].mean()), abs=0.1)  # by 96 axes


def test_turns_are_the_mean_over_directions():
    rng, sigma = np.random.default_rng(7), 0.1
    rates = replace(RATES, sigma_angle=sigma)
    views, _ = views_of(np.array([[0.02, -0.03, 0.12]]), ring(3, 20.0), rng, sigma=0.1)
    angles = [0.4, 0.5, 0.45]
    views = [
        View(v.id, Gamma(CAMERA, tuple(replace(a, angle=angle) for a in v.gamma.appearances)), v.world_from_camera)
        for v, angle in zip(views, angles, strict=True)
    ]
    sights = sights_of(views, all_of(views), rates)
    tracks = tracks_of(sights)
    pair = tracks.take(np.flatnonzero((tracks.data >= 0).sum(axis=1) == 2)[:1])
    seen = np.flatnonzero(pair.data[0] >= 0)
    axes = rng.normal(size=(400_000, 3))
    joint = np.ones(len(axes))
    for v in seen:
        frame = inverse(views[v].world_from_camera)
        at = transform_points(frame, pair.places.at)[0]
        off = (screen_angle(axes @ frame[:3, :3].T, at) - angles[v] + np.pi) % (2 * np.pi) - np.pi
        joint *= np.exp(-0.5 * (off / sigma) ** 2) / (sigma * np.sqrt(2 * np.pi)) * 2 * np.pi
    assert log_turns(sights, pair)[0] == pytest.approx(np.log(joint.mean()), abs=0.15)
