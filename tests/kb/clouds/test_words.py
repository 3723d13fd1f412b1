"""Visual words: the nearest against brute force, determinism, the file, and the words of several clouds together."""

import io

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from random_cloud import random_cloud, random_words

from kb.clouds import words as module
from kb.clouds.cloud import KEYPOINTS, word_clutter
from kb.clouds.words import MOST, PER_WORD, Words, learn_words, read_words, worded, words_bytes
from kb.errors import CloudError
from kb.files.read import learned_features, learned_lobes


def far(one, other):
    """Euclid's distance squared of 128 bytes, Hamming's of 32."""
    if len(one) == 32:
        return sum((int(a) ^ int(b)).bit_count() for a, b in zip(one, other, strict=True))
    return sum((int(a) - int(b)) ** 2 for a, b in zip(one, other, strict=True))


@settings(max_examples=15, deadline=None, derandomize=True)
@given(st.integers(0, 99), st.integers(1, 9), st.integers(0, 12), st.sampled_from([32, 128]))
def test_the_nearest_word_is_brute_forces_first(seed, count, asked, width):
    rng = np.random.default_rng(seed)
    words = random_words(seed, count, width)
    words = Words(words.detector, np.concatenate([words.centroids, words.centroids[:1]]))
    some = rng.integers(0, 256, (asked, width), np.uint8)
    some[: asked // 2] = words.centroids[rng.integers(0, count, asked // 2)]
    expected = [min(range(count + 1), key=lambda w: (far(one, words.centroids[w]), w)) for one in some]
    nearest = words.nearest(some)
    assert nearest.tolist() == expected
    assert nearest.dtype == np.int64


def test_blocks_change_nothing(monkeypatch):
    words, some = random_words(), np.random.default_rng(3).integers(0, 256, (50, 128), np.uint8)
    whole = words.nearest(some)
    monkeypatch.setattr(module, "_BLOCK", 7)
    assert words.nearest(some).tolist() == whole.tolist()


@pytest.mark.parametrize("width", [32, 128])
def test_the_same_descriptors_and_seed_give_the_same_words(width):
    rng = np.random.default_rng(2)
    some = rng.integers(0, 256, (4 * PER_WORD + 3, width), np.uint8)
    words = learn_words(some)
    assert words_bytes(words) == words_bytes(learn_words(some))
    assert words.centroids.shape == (4, width)
    assert words.centroids.dtype == np.uint8
    assert words.names == tuple(f"{'orb' if width == 32 else 'sift'}_w000{i}" for i in range(4))


def test_clusters_become_words_and_there_are_never_too_many():
    middles = np.array([[20] * 128, [120] * 128, [220] * 128], np.uint8)
    some = np.repeat(middles, PER_WORD, axis=0) + np.random.default_rng(0).integers(0, 5, (3 * PER_WORD, 128)).astype(
        np.uint8
    )
    near = learn_words(some).nearest(some).reshape(3, PER_WORD)
    assert (near == near[:, :1]).all()
    assert len(set(near[:, 0].tolist())) == 3
    assert len(learn_words(some[:1]).centroids) == 1
    assert MOST <= 10_000  # names have four digits


@pytest.mark.parametrize("width", [32, 128])
def test_words_come_back_from_their_file(width):
    words = random_words(4, 5, width)
    back = read_words(words_bytes(words))
    assert (back.detector, back.names) == (words.detector, words.names)
    assert np.array_equal(back.centroids, words.centroids)


def saved(**arrays):
    memory = io.BytesIO()
    np.savez_compressed(memory, **arrays)
    return memory.getvalue()


def test_what_is_no_vocabulary_is_a_cloud_error():
    good = words_bytes(random_words())
    plain = io.BytesIO()
    np.save(plain, random_words().centroids)
    wrong = [b"", b"PK", b"nothing", good[:40], good[:-30], plain.getvalue(), saved(other=np.zeros(3))]
    shapes = [(3, 64), (0, 128), (128,), (MOST + 1, 128)]
    wrong += [saved(centroids=np.zeros(shape, np.uint8)) for shape in shapes]
    wrong += [saved(centroids=np.zeros((3, 128))), saved(centroids=np.array([{}], dtype=object))]
    for content in wrong:
        with pytest.raises(CloudError):
            read_words(content)


def test_spoilt_bytes_of_a_vocabulary_are_cloud_errors_or_nothing():
    words = random_words()
    content, rng, told = saved(centroids=words.centroids), np.random.default_rng(0), []
    for place in rng.integers(0, len(content), 150):
        spoilt = bytearray(content)
        spoilt[place] ^= 0x55
        try:
            assert np.array_equal(read_words(bytes(spoilt)).centroids, words.centroids)
        except CloudError as error:
            told.append(str(error))
    assert told
    assert not any("\n" in text for text in told)


def test_a_vocabulary_that_unpacks_to_too_much(monkeypatch):
    monkeypatch.setattr(module, "MAX_BYTES", 100_000)
    with pytest.raises(CloudError, match="unpacks to more than 100000 bytes"):
        read_words(saved(centroids=np.zeros((1000, 128), np.uint8)))


def test_clouds_share_their_words_whatever_their_order():
    clouds = {"b": random_cloud(1, 30, 60), "a": random_cloud(2, 20, 50)}
    words, named = worded(clouds)
    again, other = worded(dict(reversed(clouds.items())))
    assert words_bytes(words) == words_bytes(again)
    for name, cloud in named.items():
        assert (
            cloud.lobe_word.tolist()
            == other[name].lobe_word.tolist()
            == words.nearest(clouds[name].descriptor).tolist()
        )
        for feature in range(len(cloud.at)):
            mine = cloud.feature == feature
            weight = {w: cloud.hit[mine & (cloud.lobe_word == w)].sum() for w in set(cloud.lobe_word[mine].tolist())}
            assert weight[int(cloud.word[feature])] == max(weight.values())


def test_a_learned_cloud_as_features_and_lobes_of_its_type():
    cloud, words = random_cloud(5), random_words()
    features, table = learned_features(cloud, words), learned_lobes(cloud, words)
    assert [f.name for f in features] == [f"f{i:04d}" for i in range(1, 7)]
    assert [f.type for f in features] == [words.names[w] for w in cloud.word]
    assert table.types == tuple(words.names[w] for w in cloud.lobe_word)
    assert np.array_equal(table.at, cloud.at[cloud.feature])
    np.testing.assert_allclose(np.arccos(table.cos_half), cloud.half_angle)


def test_clutter_of_words_adds_up_and_the_common_word_has_more():
    class Kind:
        learned = object()
        seen_features = learned_features(random_cloud(6, 6, 6, word=[0, 0, 0, 1, 1, 2]), random_words())

    rates = word_clutter([Kind()], random_words().names)
    assert sum(rates.values()) == pytest.approx(KEYPOINTS)
    values = list(rates.values())
    assert values[0] > values[1] > values[2] > 0
    assert len(set(values[3:])) == 1
