"""What comes again in another picture, and which features are kept, each against a loop that says what it means."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from made_sides import COUNT, an_edge, towards
from test_sides_observed import sides

from kb.learning.again import ALIKE, NEAR, SIMILAR, TURNED, differences, keypoints_again, same, sides_again
from kb.learning.features import _best

SEEDS = st.integers(0, 9999)
WIDTHS = st.sampled_from([32, 128, 138])


def keypoints(rng, count, width):
    """In a small picture; of their descriptors, angles and sizes about half are alike."""
    descriptors = rng.integers(96, 112 if width == 32 else 156, (count, width), np.uint8)
    angle = rng.choice([0.1, 0.3, 2 * np.pi - 0.1, 3.0], count)
    return SimpleNamespace(
        uv=rng.uniform(0, 12, (count, 2)), angle=angle, scale=rng.uniform(3.0, 6.0, count), descriptors=descriptors
    )


def most_alike(one, i, other):
    """Which of the other picture's keypoints is the i-th of ``one``, by a loop; None where none may be."""
    fits = []
    for j in range(len(other.uv)):
        near = np.linalg.norm(other.uv[j] - one.uv[i]) <= NEAR + 0.08 * one.scale[i]
        large = abs(np.log(other.scale[j] / one.scale[i])) < SIMILAR
        turned = abs(np.angle(np.exp(1j * (other.angle[j] - one.angle[i])))) < TURNED
        apart = differences(one.descriptors[[i]], other.descriptors[[j]])[0]
        if near and large and turned and apart < ALIKE[one.descriptors.shape[1]]:
            fits.append((apart, j))
    return min(fits)[1] if fits else None


@settings(max_examples=40, deadline=None, derandomize=True)
@given(SEEDS, WIDTHS, st.integers(0, 25), st.integers(0, 25))
def test_the_same_keypoint_is_the_most_alike_of_those_that_may_be(seed, width, count, its):
    rng = np.random.default_rng(seed)
    one, other = keypoints(rng, count, width), keypoints(rng, its, width)
    expected = {i: j for i in range(count) if (j := most_alike(one, i, other)) is not None}
    assert dict(zip(*(some.tolist() for some in same(one, other)), strict=True)) == expected


@settings(max_examples=20, deadline=None, derandomize=True)
@given(SEEDS, WIDTHS, st.integers(1, 25), st.integers(1, 3))
def test_what_is_the_same_in_every_picture_comes_always_and_stays_as_it_is(seed, width, count, others):
    one = keypoints(np.random.default_rng(seed), count, width)
    one.uv = one.uv + 100.0 * np.arange(count)[:, None]  # so that each is near to itself alone
    hit, uv, descriptor = keypoints_again(one, [one] * others)
    assert hit.tolist() == [1.0] * count
    assert uv == pytest.approx(one.uv)
    assert descriptor.tolist() == one.descriptors.tolist()


@settings(max_examples=20, deadline=None, derandomize=True)
@given(SEEDS, st.integers(0, 40), st.lists(st.integers(0, 60), min_size=1, max_size=3))
def test_sides_that_are_not_asked_for_do_not_come_again_and_the_others_as_ever(seed, count, others):
    rng = np.random.default_rng(seed)
    first, rest = sides(rng, count), [sides(rng, number) for number in others]
    asked = rng.random(count) < 0.5
    assert (
        sides_again(first, rest, np.flatnonzero(asked)).tolist()
        == np.where(asked, sides_again(first, rest), 0.0).tolist()
    )


@settings(max_examples=40, deadline=None, derandomize=True)
@given(SEEDS, st.integers(0, 30))
def test_the_best_are_those_with_the_least_rank_from_any_direction(seed, count):
    rng = np.random.default_rng(seed)
    seen = an_edge(rng, towards((0.0, 0.0, 1.0), 20.0), 4)
    seen = replace(seen, hit=rng.choice([0.5, 1.0], len(seen)))
    groups = [rng.choice(len(seen), rng.integers(1, 9), replace=False) for _ in range(count)]
    weight = [seen.hit[group].sum() for group in groups]
    turn = [count] * count
    for direction in range(COUNT):
        here = sorted(
            (i for i in range(count) if direction in seen.view[groups[i]].tolist()), key=lambda i: (-weight[i], i)
        )
        for rank, i in enumerate(here):
            turn[i] = min(turn[i], rank)
    assert _best(seen, groups) == sorted(range(count), key=lambda i: (turn[i], -weight[i], i))
