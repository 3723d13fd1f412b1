"""How right the side of an edge looks: laws of its colours, and of its brightness against what is beyond the edge."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from kb.clouds.words import COLOURS, SIDE
from plogic.match.gamma.side_looks import (
    BRIGHT,
    EDGES,
    FEW,
    LEAST,
    LESS,
    NEAREST,
    OFF,
    USUAL,
    WILD,
    colours_off,
    contrasts_of,
    looks_fit,
)

LOOKS = st.lists(st.integers(0, 255), min_size=SIDE, max_size=SIDE)
CONTRASTS = st.integers(0, 255)
VARIED = st.floats(0.0, 0.9 * np.sqrt(EDGES**2 - BRIGHT**2))
"""Less than the contrasts of the edges of objects."""
BYTES = np.arange(256)
EVEN = np.full(256, 1.0 / 256.0)
"""Contrasts of an image that holds as many of each."""


def mine(looks, varied=0.0):
    return np.array([[*looks, varied]], np.float32)


def its(*looks):
    return np.array(looks, np.uint8).reshape(-1, SIDE)


def of_contrasts(contrast, varied, asked=BYTES, off=0.0, usual=EVEN):
    """The fit of each of these contrasts, of colours that are off by so much, in an image of usual contrasts."""
    some = np.zeros((len(asked), SIDE), np.uint8)
    some[:, SIDE - 1] = asked
    rows = np.repeat(mine([0] * COLOURS + [contrast], varied), len(asked), axis=0)
    return looks_fit(rows, some, np.full(len(asked), off, np.float32), usual) / (NEAREST - LESS * off)


@settings(max_examples=60, deadline=None, derandomize=True)
@given(LOOKS, CONTRASTS, st.floats(0, 255))
def test_the_same_colours_are_not_off_whatever_the_contrast(looks, contrast, varied):
    assert colours_off(mine(looks, varied), its([*looks[:COLOURS], contrast]), coloured=True).tolist() == [0.0]


@settings(max_examples=60, deadline=None, derandomize=True)
@given(st.lists(st.tuples(LOOKS, LOOKS), max_size=8))
def test_colours_are_off_by_their_distance_as_a_share_of_the_greatest(pairs):
    one, other = np.array([[*a, 3.0] for a, _ in pairs], np.float32).reshape(-1, SIDE + 1), its(*[b for _, b in pairs])
    expected = [sum((x - y) ** 2 for x, y in zip(a[:COLOURS], b[:COLOURS], strict=True)) ** 0.5 / OFF for a, b in pairs]
    assert colours_off(one, other, coloured=True).tolist() == pytest.approx(expected, rel=1e-5)
    neither = colours_off(one, other, coloured=False)
    assert neither.shape == (len(pairs),)
    assert NEAREST - LESS * neither == pytest.approx(1.0, abs=1e-6)


@settings(max_examples=60, deadline=None, derandomize=True)
@given(LOOKS, LOOKS, st.integers(0, COLOURS - 1))
def test_another_byte_farther_away_is_farther_off(looks, other, which):
    asked = np.repeat(its(other), 256, axis=0)
    asked[:, which] = BYTES
    off = colours_off(np.repeat(mine(looks), 256, axis=0), asked, coloured=True)
    assert (np.diff(off[: looks[which] + 1]) <= 0).all()
    assert (np.diff(off[looks[which] :]) >= 0).all()
    assert off.min() == off[looks[which]]


@settings(max_examples=60, deadline=None, derandomize=True)
@given(CONTRASTS, st.floats(0, 255), CONTRASTS)
def test_the_farther_off_colours_are_the_worse_they_fit_and_none_is_impossible(contrast, varied, seen):
    off = np.linspace(0.0, 0.999, 50).astype(np.float32)
    looks = np.repeat(its([0] * COLOURS + [seen]), 50, axis=0)
    fit = looks_fit(np.repeat(mine([0] * COLOURS + [contrast], varied), 50, axis=0), looks, off, EVEN)
    assert (np.diff(fit) < 0).all()
    assert (fit >= (NEAREST - LESS) * WILD * (1 - 1e-6)).all()
    assert np.isfinite(fit).all()


def test_colours_evenly_off_fit_neither_better_nor_worse():
    """On average over all shares of what may be off."""
    assert NEAREST > 1.0 > NEAREST - LESS > 0.0
    assert pytest.approx(1.0, abs=0.1) == NEAREST - LESS / 2.0


@settings(max_examples=100, deadline=None, derandomize=True)
@given(st.integers(90, 165), VARIED, st.integers(0, 9999), st.integers(0, 400))
def test_contrasts_of_the_images_edges_fit_on_average_neither_better_nor_worse(contrast, varied, seed, count):
    """By their own share among its edges: what looks likelier here looks less likely there.

    In bytes: the rims of 0 and 255 are far.
    """
    rng = np.random.default_rng(seed)
    edges = np.zeros((count, SIDE), np.uint8)
    edges[:, SIDE - 1] = np.clip(128 + rng.normal(0, rng.uniform(5, 40), count), 0, 255)
    usual = contrasts_of(edges)
    assert (of_contrasts(contrast, varied, usual=usual) * usual).sum() == pytest.approx(
        usual.sum() * WILD + (1.0 - WILD), abs=0.02
    )


@settings(max_examples=60, deadline=None, derandomize=True)
@given(st.lists(CONTRASTS, max_size=60))
def test_contrasts_of_an_image_are_those_of_its_edges_and_of_some_of_any(contrasts):
    edges = np.zeros((len(contrasts), SIDE), np.uint8)
    edges[:, SIDE - 1] = contrasts
    found, prior = contrasts_of(edges), np.exp(-0.5 * ((BYTES - 128) / USUAL) ** 2)
    bells = [np.exp(-0.5 * ((BYTES - c) / 5.0) ** 2) for c in contrasts]
    expected = (sum(bell / bell.sum() for bell in bells) + FEW * prior / prior.sum()) / (len(contrasts) + FEW)
    np.testing.assert_allclose(found, np.maximum(expected, LEAST))


@settings(max_examples=60, deadline=None, derandomize=True)
@given(CONTRASTS, VARIED)
def test_contrasts_fit_the_worse_the_farther_they_are_from_what_was_learned(contrast, varied):
    fit = of_contrasts(contrast, varied)
    likeliest = int(fit.argmax())
    assert (np.diff(fit[: likeliest + 1]) >= -1e-12).all()
    assert (np.diff(fit[likeliest:]) <= 1e-12).all()
    kept = (
        1.0 - (varied**2 + BRIGHT**2) / EDGES**2
    )  # the rest is as the edges of objects are, of which the middle is 128
    assert likeliest == pytest.approx(128 + (contrast - 128) * kept, abs=0.51)
    assert (fit >= WILD).all()


@settings(max_examples=60, deadline=None, derandomize=True)
@given(st.integers(40, 215))
def test_what_varied_less_says_more(contrast):
    """The right contrast fits better, and those a hundred bytes off no better, the less it varied in learning."""
    away = contrast + (100 if contrast < 128 else -100)
    both = np.array([of_contrasts(contrast, varied, np.array([contrast, away])) for varied in (0.0, 6.0, 12.0, 18.0)])
    right, wrong = both.T
    assert (np.diff(right) < 0).all()
    assert right[0] > 1.0
    assert (np.diff(wrong) >= 0).all()
    assert wrong[0] < 1.0


@settings(max_examples=60, deadline=None, derandomize=True)
@given(CONTRASTS, st.floats(float(np.sqrt(EDGES**2 - BRIGHT**2)) + 0.01, 255), st.floats(0.0, 0.99))
def test_what_varied_as_edges_do_says_where_edges_of_objects_are_and_no_more(contrast, varied, off):
    edges = np.exp(-0.5 * ((BYTES - 128.0) / EDGES) ** 2) / (np.sqrt(2.0 * np.pi) * EDGES)
    found = of_contrasts(contrast, varied, off=off, usual=np.maximum(edges, LEAST))
    assert found[edges > LEAST].tolist() == pytest.approx([1.0] * int((edges > LEAST).sum()))


def test_of_none_there_is_nothing():
    nothing = np.zeros((0, SIDE + 1), np.float32), its()
    assert colours_off(*nothing, coloured=True).shape == colours_off(*nothing, coloured=False).shape == (0,)
    assert looks_fit(*nothing, np.zeros(0, np.float32), EVEN).shape == (0,)
