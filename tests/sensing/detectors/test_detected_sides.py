"""What the keypoint detector says of the sides of edges: only where words know any and the image has colours.

And in a file of Γ.
"""

from __future__ import annotations

import base64
import json

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from test_edge_sides import texture

from geometry.camera import Camera
from kb.clouds.words import POINT, SIDE, Words
from sensing.appearance import Appearance, Gamma
from sensing.detectors.detector import detect
from sensing.detectors.keypoint_detector import CELL, WIDTH, KeypointDetector, edge_sides
from sensing.errors import GammaError
from sensing.files.gamma_files import gamma_from_dict, gamma_from_text, gamma_to_dict

CAMERA = Camera(90, 75, np.array([[100.0, 0, 44.5], [0, 100, 37], [0, 0, 1]]), np.zeros(0))
PLACE = {"uv": (3.0, 4.0), "detector": "sift"}


def words(seed=0, points=3, sides=2, width=138):
    """Some words of keypoints and, mixed among them, some of sides, of widely different colours."""
    rng = np.random.default_rng(seed)
    centroids = rng.integers(1, 256, (points + sides, width), np.uint8)
    for number, row in enumerate(rng.permutation(points + sides)[:sides]):
        centroids[row] = 0
        centroids[row, POINT : POINT + SIDE] = (128 + 30 * number) % 256
    return Words("orb" if width == 32 else "sift", centroids)


def sides_of(found):
    return [a for a in found if a.scale is None]


@settings(max_examples=10, deadline=None, derandomize=True)
@given(st.integers(0, 999), st.integers(1, 4), st.integers(1, 5))
def test_sides_follow_the_keypoints_with_an_angle_five_bytes_and_no_scale(seed, points, sides):
    image, known = texture(seed), words(seed, points, sides)
    found, expected = KeypointDetector("sift", known).detect(image), edge_sides(image, CELL)
    mine = sides_of(found)
    assert found[len(found) - len(mine) :] == mine
    assert len(mine) == len(expected) > 20
    assert [a.descriptor for a in mine] == [row.tobytes() for row in expected.looks]
    assert {len(a.descriptor) for a in mine} == {WIDTH} == {SIDE}
    assert [a.uv for a in mine] == [tuple(uv) for uv in expected.uv.tolist()]
    assert [a.angle for a in mine] == expected.angle.tolist()
    assert all(0 < a.score < 1 for a in mine)
    assert mine[0].score == max(a.score for a in mine)
    assert {a.detector for a in mine} == {"sift"}
    assert {a.type for a in mine} <= {name for name, sided in zip(known.names, known.sided, strict=True) if sided}
    apart = [
        (np.abs(row.astype(int) - known.centroids[:, POINT : POINT + SIDE].astype(int)) ** 2).sum(axis=1)
        for row in expected.looks
    ]
    assert [a.type for a in mine] == [known.names[np.where(known.sided, far, 10**9).argmin()] for far in apart]


@settings(max_examples=10, deadline=None, derandomize=True)
@given(st.integers(0, 999))
def test_keypoints_are_the_same_whether_or_not_words_know_sides(seed):
    image, known = texture(seed), words(seed)
    plain = Words("sift", known.centroids[~known.sided])
    with_sides, without = (KeypointDetector("sift", some).detect(image) for some in (known, plain))
    assert [(a.uv, a.angle, a.scale, a.score, a.descriptor) for a in with_sides if a.scale is not None] == [
        (a.uv, a.angle, a.scale, a.score, a.descriptor) for a in without
    ]


@pytest.mark.parametrize("known", [None, words(sides=0), words(sides=0, width=128), words(sides=0, width=32)])
@pytest.mark.parametrize("name", ["sift", "orb"])
def test_without_words_that_know_sides_there_are_none(name, known):
    found = KeypointDetector(name, known).detect(texture(1))
    assert len(found) > 0
    assert sides_of(found) == []


def test_orb_has_none_whatever_the_words():
    assert sides_of(KeypointDetector("orb", words()).detect(texture(1))) == []


def test_a_grey_image_has_none():
    grey = np.repeat(texture(2)[..., :1], 3, axis=2)
    found = KeypointDetector("sift", words()).detect(grey)
    assert len(found) > 0
    assert sides_of(found) == []


def test_a_constant_image_has_none():
    assert KeypointDetector("sift", words()).detect(np.full((60, 60, 3), (10, 90, 200), np.uint8)) == []


@settings(max_examples=8, deadline=None, derandomize=True)
@given(st.integers(0, 999))
def test_they_survive_a_file_of_gamma(seed):
    known = words(seed)
    gamma = detect(texture(seed), CAMERA, set(known.names), known)
    assert len(sides_of(gamma.appearances)) > 20
    again = gamma_from_text(json.dumps(gamma_to_dict(gamma)), vocabulary=known.names)
    assert isinstance(again, Gamma)
    assert again.appearances == gamma.appearances


@settings(max_examples=30, deadline=None, derandomize=True)
@given(st.binary(min_size=WIDTH, max_size=WIDTH), st.floats(0.0, 6.28), st.integers(0, 9999))
def test_any_side_survives_a_file_of_gamma(looks, angle, word):
    side = Appearance("a1", f"sift_w{word:04d}", angle=angle, descriptor=looks, **PLACE)
    document = gamma_to_dict(Gamma(CAMERA, (side,)))
    assert "scale" not in document["appearances"][0]
    assert gamma_from_dict(document).appearances == (side,)


@pytest.mark.parametrize(
    ("a_type", "size", "wanted"),
    [
        ("sift_w0003", 4, "128 or 138 or 5"),
        ("sift_w0003", 6, "128 or 138 or 5"),
        ("sift", 8, "128 or 138 or 5"),
        ("orb_w0003", 5, "32"),
        ("orb", 5, "32"),
    ],
)
def test_other_lengths_are_a_stated_mistake(a_type, size, wanted):
    document = gamma_to_dict(Gamma(CAMERA, (Appearance("a1", a_type, angle=1.0, **PLACE),)))
    document["appearances"][0]["descriptor"] = base64.b64encode(bytes(size)).decode()
    with pytest.raises(GammaError) as caught:
        gamma_from_dict(document)
    assert list(caught.value.mistakes) == [
        f"gamma.json: appearances.0.descriptor: has {size} bytes, and one of {a_type!r} has {wanted}"
    ]
