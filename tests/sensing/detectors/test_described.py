"""Keypoints and points along edges together, and SIFT's description of given places."""

from __future__ import annotations

from dataclasses import fields

import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from test_keypoints import texture

from sensing.detectors.keypoint_detector import CELL, EDGE_SIZE, EDGES, RISE, KeypointDetector, described, edge_points
from sensing.detectors.keypoints import CONTRAST, EDGE, LAYERS, LEAST_SIDE, SIGMA, Keypoints, keypoints, sift_at
from sensing.detectors.regions import MOST, regions
from sensing.errors import DetectorError


def same(one, other):
    assert len(one) == len(other)
    for f in fields(Keypoints):
        assert np.array_equal(getattr(one, f.name), getattr(other, f.name)), f.name


def part(found, start, stop=None):
    return found.chosen(np.arange(len(found))[start:stop])


@settings(max_examples=10, deadline=None, derandomize=True)
@given(st.integers(0, 999), st.integers(3, 12), st.integers(1, 400))
def test_blobs_come_first_then_points_along_edges_then_regions_each_the_strongest_first(seed, cell, most):
    image = texture(120, 140, seed)
    found, blobs, edges = (
        described(image, cell=cell, most=most),
        keypoints(image, most=most),
        edge_points(image, cell, min(most, EDGES)),
    )
    assert len(blobs) > 0
    assert len(edges.uv) > 0
    same(part(found, 0, len(blobs)), blobs)
    own = regions(image, min(most, MOST))
    same(part(found, len(blobs) + len(edges.uv)), own)
    rest = part(found, len(blobs), len(blobs) + len(edges.uv))
    np.testing.assert_allclose(rest.uv, edges.uv, atol=1e-5)
    np.testing.assert_allclose(np.exp(1j * rest.angle), np.exp(1j * edges.angle), atol=1e-6)
    np.testing.assert_allclose(rest.response, RISE * edges.rise, rtol=1e-6)
    assert (rest.scale == EDGE_SIZE).all()
    assert ((rest.angle >= 0) & (rest.angle < 2 * np.pi)).all()
    for some in (blobs, rest):
        assert (np.diff(some.response) <= 0).all()
    assert found.descriptors.shape == (len(found), 128)
    assert found.descriptors.dtype == np.uint8
    assert (found.descriptors.max(axis=1) > 0).all()


@settings(max_examples=10, deadline=None, derandomize=True)
@given(st.integers(0, 999), st.integers(3, 9), st.sampled_from(["sift", "orb"]), st.integers(10, 70))
def test_where_a_mask_holds_is_the_same_as_without_it_and_elsewhere_is_nothing(seed, cell, name, middle):
    image, where = texture(120, 140, seed), np.zeros((120, 140), bool)
    where[middle : middle + 40, 20:100] = True
    every = described(image, name, cell=cell)
    column, row = np.floor(every.uv + 0.5).astype(int).T
    inside = where[np.clip(row, 0, 119), np.clip(column, 0, 139)]
    assert 0 < inside.sum() < len(every)
    same(described(image, name, cell=cell, where=where), every.chosen(inside))


@settings(max_examples=10, deadline=None, derandomize=True)
@given(st.integers(0, 999), st.integers(3, 6))
def test_larger_cells_make_edges_sparser_and_leave_blobs_as_they_are(seed, cell):
    image = texture(120, 140, seed)
    dense, sparse = described(image, cell=cell), described(image, cell=2 * cell)
    blobs, rest = len(keypoints(image)), len(regions(image))
    same(part(dense, 0, blobs), part(sparse, 0, blobs))
    same(part(dense, len(dense) - rest), part(sparse, len(sparse) - rest))
    many, few = ({tuple(uv) for uv in some.uv[blobs : len(some) - rest].tolist()} for some in (dense, sparse))
    assert 0 < len(few) < len(many)
    assert few <= many


def test_orb_has_no_points_along_edges():
    image = texture()
    same(described(image, "orb", cell=1), keypoints(image, "orb"))
    assert described(image, "orb").descriptors.shape[1] == 32


def test_a_colour_picture_is_as_its_grey():
    grey = texture(90, 100)
    same(described(np.repeat(grey[..., None], 3, axis=2)), described(grey))


@pytest.mark.parametrize("name", ["sift", "orb"])
@pytest.mark.parametrize("shape", [(1, 1), (3, 40), (LEAST_SIDE, LEAST_SIDE), (40, 40, 3)])
def test_what_is_constant_has_none(name, shape):
    found = described(np.full(shape, 90, np.uint8), name)
    assert len(found) == 0
    assert found.descriptors.shape == (0, 128 if name == "sift" else 32)
    assert found.uv.shape == (0, 2)


def test_other_detectors_are_refused():
    with pytest.raises(DetectorError, match="surf"):
        described(texture(), "surf")


def test_the_detector_reports_exactly_these():
    image = np.repeat(texture(90, 100)[..., None], 3, axis=2)
    found, told = described(image, cell=CELL), KeypointDetector("sift").detect(image)
    assert [a.descriptor for a in told] == [row.tobytes() for row in found.descriptors]
    assert [a.uv for a in told] == [tuple(uv) for uv in found.uv.tolist()]
    assert [a.angle for a in told] == found.angle.tolist()
    assert [a.scale for a in told] == found.scale.tolist()
    assert all(0 < a.score < 1 for a in told)


@settings(max_examples=15, deadline=None, derandomize=True)
@given(st.integers(0, 999), st.integers(1, 25))
def test_given_places_are_described_as_opencv_does_each_alone_in_their_order(seed, count):
    image, rng = texture(100, 130, seed), np.random.default_rng(seed)
    uv = rng.uniform(-0.4, (129.4, 99.4), (count, 2))
    angle, scale, response = rng.uniform(-7, 7, count), rng.uniform(2, 30, count), rng.uniform(0, 1, count)
    found = sift_at(image, uv, angle, scale, response)
    sift = cv2.SIFT.create(0, LAYERS, CONTRAST, EDGE, SIGMA, cv2.CV_8U, True)  # noqa: FBT003 (positional in OpenCV 4 and 5)
    assert len(found) == count
    for i in range(count):
        place = cv2.KeyPoint(
            *uv[i].tolist(), float(scale[i]), float(np.degrees(angle[i] % (2 * np.pi))), float(response[i]), 0
        )
        _, expected = sift.compute(image, [place])
        assert found.descriptors[i].tolist() == expected[0].tolist()
    np.testing.assert_allclose(found.uv, uv, atol=1e-4)
    np.testing.assert_allclose(np.exp(1j * found.angle), np.exp(1j * angle), atol=1e-5)
    np.testing.assert_allclose(found.scale, scale, rtol=1e-6)
    np.testing.assert_allclose(found.response, response, rtol=1e-6)


def test_no_places_have_no_descriptions():
    found = sift_at(texture(), np.zeros((0, 2)), *np.zeros((3, 0)))
    assert len(found) == 0
    assert found.descriptors.shape == (0, 128)


def test_a_picture_turned_by_a_quarter_has_the_same_descriptions_turned():
    """What is described turns with the gradient.

    The descriptors of a picture on its side are those of the upright one.
    """
    image = texture(121, 121, 4)
    points = edge_points(image, 7, 500)
    middle = np.array([60.0, 60.0])
    some = (np.abs(points.uv - middle) < 35).all(axis=1)
    uv, angle, size = points.uv[some], points.angle[some], np.full(some.sum(), EDGE_SIZE)
    upright = sift_at(image, uv, angle, size, size)
    turned = (uv - middle) @ np.array(
        [[0.0, 1.0], [-1.0, 0.0]]
    ) + middle  # (u, v) -> (-v, u): a quarter clockwise on the screen
    lying = sift_at(np.rot90(image, -1).copy(), turned, angle + np.pi / 2, size, size)
    gap = np.linalg.norm(upright.descriptors.astype(float) - lying.descriptors, axis=1)
    assert len(gap) > 20
    assert np.quantile(gap, 0.95) < 60.0
