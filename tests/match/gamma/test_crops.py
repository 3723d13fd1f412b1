"""A crop of an image has its principal point anywhere: what it shows is found as in the whole."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from benchmarks.places.scenes import scene
from benchmarks.places.types import places_kb
from geometry.camera import Camera
from plogic.base.clock import Stopwatch
from plogic.cycle.delta import Options
from plogic.cycle.state import among
from plogic.match.judged.rivals import claims
from plogic.run.perceive import Perceiver
from sensing.appearance import Gamma

MARGIN = 12.0
"""Pixels of a crop around the data of an object."""
ENOUGH = 8
"""Data of an object: clutter is as much in a crop as in the whole, so that fewer may tell nothing there."""


@cache
def perceiver():
    return Perceiver(places_kb(12))


def accepted_in(gamma):
    return perceiver().cycle(gamma, Options(), Stopwatch())


def cropped(gamma, low, high):
    """Γ of the rectangle from ``low`` to ``high`` (2,) pixels, as a camera of that size reports it."""
    low, high = np.floor(low), np.ceil(high)
    shift = np.array([[0.0, 0.0, low[0]], [0.0, 0.0, low[1]], [0.0, 0.0, 0.0]])
    width, height = (high - low + 1).astype(int).tolist()
    camera = Camera(width, height, gamma.camera.K - shift, gamma.camera.dist)
    inside = [a for a in gamma.appearances if camera.contains(np.array(a.uv) - low)]
    return Gamma(camera, tuple(replace(a, uv=tuple((np.array(a.uv) - low).tolist())) for a in inside))


@pytest.mark.parametrize("seed", range(5))
def test_what_a_crop_shows_is_found_as_in_the_whole(seed):
    gamma, _ = scene(perceiver().kb, seed)
    data, whole = accepted_in(gamma)
    sure = [held for held in whole.accepted if len(claims(held)) >= ENOUGH]
    assert sure
    for held in sure:
        places = data.uv[list(claims(held))]
        crop = cropped(gamma, places.min(axis=0) - MARGIN, places.max(axis=0) + MARGIN)
        assert np.abs(crop.camera.K[:2, 2] - (crop.camera.width / 2, crop.camera.height / 2)).max() > 20.0
        assert among(held, accepted_in(crop)[1].accepted)
