"""Which appearances look like which keypoints.

With one word as comparing all with all, with a vocabulary those of the nearest words.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from learned_scenes import CAMERA, ready
from random_cloud import random_cloud, random_words

from plogic.match.gamma.data import data_of
from plogic.match.kinds import models_of
from plogic.match.learned.keypoints import FARTHEST, FARTHEST_BITS, NTH, WORDS, lexicon_of, spread
from sensing.appearance import Appearance

WIDTHS = pytest.mark.parametrize("width", [32, 128, 138])


def noisy(rng, descriptors):
    """The same with some noise: a few bits of 32 bytes, some grey levels of 128; some of them much, some hardly any."""
    much = rng.uniform(0, 1, (len(descriptors), 1))
    if descriptors.shape[1] == 32:
        return descriptors ^ np.packbits(rng.random((len(descriptors), 256)) < 0.3 * much, axis=1)
    return np.clip(descriptors + 30 * much * rng.normal(0, 1, descriptors.shape), 0, 255).astype(np.uint8)


def data_like(descriptors):
    """Keypoints of these descriptors anywhere; every fifth has none."""
    rows = [
        Appearance(
            f"a{i}",
            "sift",
            (float(i), 2.0),
            "made",
            angle=1.0,
            scale=5.0,
            descriptor=b"" if i % 5 == 4 else row.tobytes(),
        )
        for i, row in enumerate(descriptors)
    ]
    return data_of(rows, CAMERA, descriptors.shape[1])


def some_clouds(rng, width, words=None, sizes=(9, 14, 5)):
    """Types whose appearances all look like one of four things, with their words as ``words`` (W, D) say."""
    base = rng.integers(0, 256, (4, width), np.uint8)
    clouds = {}
    for i, size in enumerate(sizes):
        look = noisy(rng, base[rng.integers(0, 4, size)])
        word = np.zeros(size, np.int64) if words is None else nearest(look, words, 1)[:, 0]
        clouds[f"t{i}"] = random_cloud(i, min(size, 4), size, width=width, descriptor=look, lobe_word=word)
    return clouds, data_like(noisy(rng, base[rng.integers(0, 4, 23)]))


def distances(a, b):
    """(A, B) in SIFT's measure: Euclid's, of ORB the root of the bits that differ, scaled."""
    if a.shape[1] != 32:
        return np.sqrt(((a.astype(float)[:, None] - b[None]) ** 2).sum(axis=2))
    return np.sqrt(np.unpackbits(a[:, None] ^ b[None], axis=2).sum(axis=2)) * FARTHEST / FARTHEST_BITS


def nearest(descriptors, words, count):
    return np.argsort(distances(descriptors, words), axis=1, kind="stable")[:, :count]


def rows_of(found):
    return {(int(d), int(lobe)): float(a) for d, lobe, a in zip(found.datum, found.lobe, found.apart, strict=True)}


def all_pairs(cloud, data, words=None, most=NTH):
    """Of each appearance the ``most`` keypoints most like it, ties included, that share a word and are near."""
    apart, rows = distances(data.descriptors, cloud.descriptor), {}
    looked = None if words is None else nearest(data.descriptors, words, WORDS)
    for lobe in range(len(cloud.feature)):
        there = [d for d in np.flatnonzero(data.described) if looked is None or cloud.lobe_word[lobe] in looked[d]]
        limit = sorted(apart[there, lobe])[most - 1] + 1e-3 if len(there) > most else np.inf
        rows |= {(int(d), lobe): float(apart[d, lobe]) for d in there if apart[d, lobe] < min(limit, FARTHEST)}
    return rows


def assert_same(found, expected):
    assert len(found.datum) == len(rows_of(found)), "no pair twice"
    assert np.array_equal(np.lexsort((found.apart, found.lobe)), np.arange(len(found.lobe))), (
        "by appearance, the most alike first"
    )
    assert rows_of(found).keys() == expected.keys()
    assert rows_of(found) == {key: pytest.approx(value, abs=0.05) for key, value in expected.items()}


@WIDTHS
@settings(max_examples=12, deadline=None, derandomize=True)
@given(st.integers(0, 9999))
def test_without_a_vocabulary_they_are_all_pairs_that_are_near(width, seed):
    clouds, data = some_clouds(np.random.default_rng(seed), width)
    lexicon, found = lexicon_of(clouds), 0
    for name, cloud in clouds.items():
        expected = all_pairs(cloud, data)
        assert_same(lexicon.alike(name, data), expected)
        found += len(expected)
    assert 0 < found < sum(len(cloud.feature) for cloud in clouds.values()) * 23


@WIDTHS
@settings(max_examples=12, deadline=None, derandomize=True)
@given(st.integers(0, 9999))
def test_with_a_vocabulary_they_are_those_of_the_nearest_words(width, seed):
    """Words that lie about the keypoints, so that some pairs that are near are of a word too far away."""
    rng = np.random.default_rng(seed)
    base = rng.integers(0, 256, (4, width), np.uint8)
    words = noisy(rng, base[np.arange(40) % 4])
    look = noisy(rng, base[rng.integers(0, 4, 30)])
    cloud = random_cloud(seed, 6, 30, width=width, descriptor=look, lobe_word=nearest(look, words, 1)[:, 0])
    data = data_like(noisy(rng, base[rng.integers(0, 4, 23)]))
    found, expected, every = (
        lexicon_of({"t": cloud}, words).alike("t", data),
        all_pairs(cloud, data, words),
        all_pairs(cloud, data, most=99),
    )
    assert_same(found, expected)
    assert expected.keys() <= every.keys()


def test_a_vocabulary_does_leave_some_out_and_no_more_words_than_looked_at_leave_none():
    rng = np.random.default_rng(1)
    base = rng.integers(0, 256, (1, 128), np.uint8)
    words, look = noisy(rng, np.repeat(base, 40, axis=0)), noisy(rng, np.repeat(base, 60, axis=0))
    data = data_like(noisy(rng, np.repeat(base, 20, axis=0)))
    for some, fewer in ((words, True), (words[:WORDS], False)):
        cloud = random_cloud(1, 6, 60, descriptor=look, lobe_word=nearest(look, some, 1)[:, 0])
        found = rows_of(lexicon_of({"t": cloud}, some).alike("t", data))
        assert found.keys() <= all_pairs(cloud, data, most=99).keys()
        assert (found.keys() == all_pairs(cloud, data).keys()) != fewer


@WIDTHS
@settings(max_examples=15, deadline=None, derandomize=True)
@given(st.integers(0, 9999), st.integers(0, 2**23 - 1), st.integers(0, 2**23 - 1))
def test_of_a_part_of_the_data_they_are_the_pairs_of_that_part(width, seed, bits, more):
    """Whichever way the part was come by, and in whichever order the questions are asked."""
    rng = np.random.default_rng(seed)
    words = rng.integers(0, 256, (12, width), np.uint8)
    clouds, data = some_clouds(rng, width, words)
    lexicon = lexicon_of(clouds, words)
    keep = np.array([bits >> i & 1 for i in range(23)], bool)
    again = np.array([more >> i & 1 for i in range(int(keep.sum()))], bool)
    parts = [data, data.only(keep), data.only(keep).only(again)]
    assert clouds
    for name in clouds:
        whole = rows_of(lexicon_of(clouds, words).alike(name, data))
        for i in rng.permutation(3):
            place = {int(row): own for own, row in enumerate(parts[i].rows)}
            assert rows_of(lexicon.alike(name, parts[i])) == {
                (place[d], lobe): a for (d, lobe), a in whole.items() if d in place
            }


def test_other_data_are_not_mistaken_for_the_last():
    clouds, one = some_clouds(np.random.default_rng(1), 128)
    _, other = some_clouds(np.random.default_rng(2), 128)
    lexicon = lexicon_of(clouds)
    for data in (one, other, one):
        assert_same(lexicon.alike("t1", data), all_pairs(clouds["t1"], data))
    assert rows_of(lexicon.alike("t1", one)) != rows_of(lexicon.alike("t1", other))


@settings(max_examples=8, deadline=None, derandomize=True)
@given(st.integers(0, 9999))
def test_a_type_among_others_has_the_pairs_that_it_has_alone(seed):
    clouds, data = some_clouds(np.random.default_rng(seed), 128)
    together = lexicon_of(clouds)
    assert together.names == tuple(clouds)
    for name, cloud in clouds.items():
        assert rows_of(together.alike(name, data)) == pytest.approx(
            rows_of(lexicon_of({name: cloud}).alike(name, data)), abs=0.05
        )


@WIDTHS
def test_where_there_is_nothing_nothing_is_alike(width):
    clouds, data = some_clouds(np.random.default_rng(3), width)
    words = np.random.default_rng(4).integers(0, 256, (5, width), np.uint8)
    empty = random_cloud(0, 0, 0, width=width)
    for some in (None, words):
        lexicon = lexicon_of(clouds, some)
        for nothing in (data_of([], CAMERA, width), data.only(np.zeros(23, bool)), data.only(~data.described)):
            assert [len(part) for part in lexicon.alike("t0", nothing)] == [0, 0, 0]
        for kinds in ({"none": empty}, {"none": empty, **clouds}):
            assert len(lexicon_of(kinds, some).alike("none", data).datum) == 0
    assert_same(lexicon_of({"none": empty, **clouds}).alike("t0", data), all_pairs(clouds["t0"], data))


def test_vectors_have_euclids_distance_and_the_root_of_hammings():
    rng = np.random.default_rng(5)
    a, b = rng.integers(0, 256, (2, 32), np.uint8)
    assert np.linalg.norm(spread(a[None]) - spread(b[None])) ** 2 == pytest.approx(
        sum(int(x ^ y).bit_count() for x, y in zip(a, b, strict=True))
    )
    a, b = rng.integers(0, 256, (2, 128), np.uint8)
    assert np.linalg.norm(spread(a[None]) - spread(b[None])) == pytest.approx(np.linalg.norm(a.astype(float) - b))


def test_all_learned_types_of_a_knowledge_base_share_one():
    words = random_words(1)
    things = [ready(random_cloud(i), name=f"t{i}", words=words) for i in range(3)]
    kb = replace(things[0].kb, types=tuple(thing.kind for thing in things))
    indices = models_of(kb, dict.fromkeys(words.names, 0.5))
    assert list(indices) == ["t0", "t1", "t2"]
    assert len({id(index.lexicon) for index in indices.values()}) == 1
    assert indices["t0"].lexicon.names == ("t0", "t1", "t2")
    assert len(indices["t0"].lexicon.words) == len(words.names)
