"""Words of the sides of edges among those of keypoints, and their nearest by brute force.

And that learning tells the two apart.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from random_cloud import random_cloud, random_words

from kb.clouds.words import PER_WORD, POINT, SIDE, Words, learn_words, read_words, worded, words_bytes
from kb.learning.again import BYTES, LOOKS, descriptors

SEEDS = st.integers(0, 9999)


def mixed(seed, choice):
    """Words of keypoints, and of sides where ``choice`` says so."""
    rng = np.random.default_rng(seed)
    centroids = rng.integers(0, 256, (len(choice), BYTES), np.uint8)
    centroids[:, 5] = 7
    centroids[np.array(choice, bool)] = descriptors(rng.integers(0, 256, (sum(choice), SIDE), np.uint8)).astype(
        np.uint8
    )
    return Words("sift", centroids)


@settings(max_examples=40, deadline=None, derandomize=True)
@given(SEEDS, st.lists(st.booleans(), min_size=1, max_size=12))
def test_words_of_sides_are_those_of_colours_alone(seed, choice):
    words = mixed(seed, choice)
    assert words.sided.tolist() == choice
    assert read_words(words_bytes(words)).sided.tolist() == choice
    assert words.sided.dtype == bool


@pytest.mark.parametrize("width", [32, 128])
def test_words_without_colours_know_no_sides(width):
    words = random_words(0, 6, width)
    assert words.sided.tolist() == [False] * 6
    assert not Words(words.detector, np.zeros_like(words.centroids)).sided.any()


@settings(max_examples=40, deadline=None, derandomize=True)
@given(SEEDS, st.lists(st.booleans(), min_size=1, max_size=12).filter(any), st.integers(0, 15))
def test_the_nearest_side_is_brute_forces_first_among_those_of_sides(seed, choice, asked):
    words, rng = mixed(seed, choice), np.random.default_rng(seed)
    words = Words("sift", np.concatenate([words.centroids, words.centroids]))
    colours = rng.integers(0, 256, (asked, SIDE), np.uint8)
    some = np.flatnonzero(choice)
    colours[: asked // 2] = words.centroids[rng.choice(some, asked // 2)][:, LOOKS]
    far = [
        [sum((int(a) - int(b)) ** 2 for a, b in zip(row, words.centroids[w][LOOKS], strict=True)) for w in some]
        for row in colours
    ]
    nearest = words.nearest_side(colours)
    assert nearest.tolist() == [int(some[np.argmin(row)]) for row in far]
    assert nearest.dtype == np.int64
    assert words.sided[nearest].all()


@settings(max_examples=40, deadline=None, derandomize=True)
@given(SEEDS, st.lists(st.booleans(), min_size=1, max_size=12).filter(any), st.integers(0, 15))
def test_a_side_s_word_is_the_nearest_to_its_whole_descriptor_among_those_of_sides(seed, choice, asked):
    words, colours = mixed(seed, choice), np.random.default_rng(seed).integers(0, 256, (asked, SIDE), np.uint8)
    alone = Words("sift", words.centroids[words.sided])
    whole = descriptors(colours).astype(np.uint8)
    assert whole.shape == (asked, BYTES)
    assert words.nearest_side(colours).tolist() == np.flatnonzero(words.sided)[alone.nearest(whole)].tolist()


def test_where_colours_are_is_said_alike_everywhere():
    assert (LOOKS.start, LOOKS.stop) == (POINT, POINT + SIDE)
    assert random_cloud(width=138).descriptor.shape[1] == BYTES


def sift_like(rng, count):
    """Descriptors as long as SIFT's, with colours."""
    points = rng.gamma(0.7, 1.0, (count, POINT))
    points = np.minimum(512.0 * points / np.linalg.norm(points, axis=1, keepdims=True), 255)
    return np.column_stack([points, rng.integers(90, 160, (count, BYTES - POINT))]).astype(np.uint8)


@settings(max_examples=8, deadline=None, derandomize=True)
@given(st.integers(0, 999), st.integers(2, 6), st.integers(2, 6))
def test_learning_gives_sides_words_of_their_own(seed, points, sides):
    rng = np.random.default_rng(seed)
    edges = descriptors(rng.integers(60, 200, (sides * PER_WORD, SIDE), np.uint8)).astype(np.uint8)
    some = np.concatenate([sift_like(rng, points * PER_WORD), edges])
    words = learn_words(some)
    nearest = words.nearest(some)
    assert 0 < words.sided.sum() < len(words.names)
    assert words.sided[nearest].tolist() == [False] * points * PER_WORD + [True] * sides * PER_WORD
    assert words.nearest_side(edges[:, LOOKS]).tolist() == nearest[points * PER_WORD :].tolist()


@settings(max_examples=8, deadline=None, derandomize=True)
@given(st.integers(0, 999))
def test_lobes_of_sides_are_given_words_of_sides_and_others_others(seed):
    rng, clouds = np.random.default_rng(seed), {}
    for name in ("a", "b"):
        plain = random_cloud(seed, 40, 90, width=BYTES, descriptor=sift_like(rng, 90))
        sided = rng.random(90) < 0.5
        edges = descriptors(rng.integers(60, 200, (90, SIDE), np.uint8)).astype(np.uint8)
        size, descriptor = np.where(sided, 0.0, plain.size), np.where(sided[:, None], edges, plain.descriptor)
        clouds[name] = replace(plain, size=size, descriptor=descriptor)
    words, named = worded(clouds)
    assert set(named) == {"a", "b"}
    for cloud in named.values():
        assert 0 < cloud.sided.sum() < len(cloud.sided)
        assert np.array_equal(words.sided[cloud.lobe_word], cloud.sided)
