"""Keypoints: where they are to a fraction of a pixel, and what moving, turning or lighting the picture does to them."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from geometry.camera import Camera
from sensing.appearance import Gamma
from sensing.detectors.detector import detect
from sensing.detectors.keypoint_detector import KeypointDetector
from sensing.detectors.keypoints import LEAST_SIDE, MOST, WIDTHS, keypoints
from sensing.errors import DetectorError
from sensing.files.gamma_files import gamma_from_dict, gamma_to_dict

BOTH = pytest.mark.parametrize("name", ["sift", "orb"])


def texture(height=200, width=240, seed=0):
    """Grey noise of several grain sizes, within 40 to 210."""
    rng = np.random.default_rng(seed)
    layers = [cv2.GaussianBlur(rng.normal(0, 1, (height, width)), (0, 0), s) * s for s in (1.2, 2.5, 6.0)]
    picture = np.sum(layers, axis=0)
    return np.rint(40 + 170 * (picture - picture.min()) / np.ptp(picture)).astype(np.uint8)


def blob(place, sigma, slope=(0.0, 0.0), size=128):
    v, u = np.mgrid[:size, :size].astype(float)
    spot = 100 * np.exp(-((u - place[0]) ** 2 + (v - place[1]) ** 2) / (2 * sigma**2))
    hill = slope[0] * u + slope[1] * v
    return np.clip(np.rint(60 + spot + hill - hill.min()), 0, 255).astype(np.uint8)


def paired(a, uv, angle):
    """Share of the keypoints ``a`` that have one near the moved places, with an angle within 0.1 of theirs.

    Near is 0.5 px for SIFT and 0.7 px of its level for ORB, which knows places to a pixel of the level alone.
    """
    level = 0.7 * a.scale / 31 if a.descriptors.shape[1] == WIDTHS["orb"][0] else np.full(len(a), 0.5)
    gap = np.linalg.norm(a.uv[:, None] - uv[None], axis=2)
    turn = np.abs(np.angle(np.exp(1j * (a.angle[:, None] - angle[None]))))
    return float(((gap < level[:, None]) & (turn < 0.1)).any(axis=1).mean())


def within(found, low, high):
    return found.chosen(((found.uv >= low) & (found.uv <= high)).all(axis=1))


@pytest.mark.parametrize("sigma", [1.5, 3.0, 6.0])
@pytest.mark.parametrize("place", [(64.0, 64.0), (61.3, 66.8), (64.5, 63.25)])
def test_a_blob_s_keypoint_is_at_its_middle(place, sigma):
    found = keypoints(blob(place, sigma))
    assert found.uv[0] == pytest.approx(place, abs=0.12)
    assert 1.5 < found.scale[0] / sigma < 2.0


def test_orb_s_places_have_no_bias_that_grows_with_the_level():
    rng = np.random.default_rng(4)
    off = []
    for place in rng.uniform(60, 68, (20, 2)):
        found = keypoints(blob(place, 3.0), "orb")
        off.append((found.uv - place).mean(axis=0))
    assert np.mean(off, axis=0) == pytest.approx((0, 0), abs=0.15)


@BOTH
@pytest.mark.parametrize(
    ("slope", "angle"), [((0.6, 0), 0.0), ((0, 0.6), np.pi / 2), ((-0.6, 0), np.pi), ((0, -0.6), 3 * np.pi / 2)]
)
def test_an_angle_runs_clockwise_on_the_screen_towards_the_brighter_side(name, slope, angle):
    found = keypoints(blob((64, 64), 3.0, slope), name)
    middle = found.chosen(np.linalg.norm(found.uv - 64, axis=1) < 2)
    assert len(middle) > 0
    assert np.cos(middle.angle[0] - angle) > 0.95


@BOTH
@pytest.mark.parametrize("by", [(8, 16), (5, 3)])
def test_a_shift_by_whole_pixels_shifts_the_keypoints(name, by):
    whole = texture(220, 260)
    du, dv = by
    a, b = keypoints(whole[: 220 - dv, : 260 - du], name), keypoints(whole[dv:, du:], name)
    inner = within(a, (60, 60), (200, 160))
    assert len(inner) > 15
    assert paired(inner, b.uv + np.array(by), b.angle) > (
        0.95 if name == "sift" else 0.6
    )  # ORB's smaller pictures are sampled anew


@BOTH
def test_a_quarter_turn_turns_places_and_angles(name):
    image = texture(200, 200)
    a, b = keypoints(image, name), keypoints(np.ascontiguousarray(np.rot90(image, -1)), name)
    back = np.column_stack([b.uv[:, 1], 199 - b.uv[:, 0]])  # clockwise: (u, v) went to (199 − v, u)
    assert len(a) > 30
    assert paired(a, back, b.angle - np.pi / 2) > 0.95


@BOTH
@pytest.mark.parametrize(("gain", "offset"), [(0.8, 0), (1.0, 25), (0.85, 30)])
def test_light_changes_few_keypoints(name, gain, offset):
    image = texture()
    a = keypoints(image, name)
    b = keypoints(np.rint(image * gain + offset).astype(np.uint8), name)
    assert len(a) > 30
    assert paired(a, b.uv, b.angle) > 0.75


def test_light_changes_few_bits_of_a_descriptor():
    image = texture()
    a, b = keypoints(image), keypoints(np.rint(image * 0.8 + 20).astype(np.uint8))
    near = np.linalg.norm(a.uv[:, None] - b.uv[None], axis=2) + 10 * np.abs(
        np.sin((a.angle[:, None] - b.angle[None]) / 2)
    )
    i = np.flatnonzero(near.min(axis=1) < 0.3)
    gap = np.linalg.norm(a.descriptors[i].astype(float) - b.descriptors[near[i].argmin(axis=1)].astype(float), axis=1)
    assert np.median(gap) < 60  # of a length of 512


@BOTH
def test_the_same_pixels_give_the_same_arrays_on_one_thread_or_two(name):
    image = texture()
    threads = cv2.getNumThreads()
    found = []
    for count in (1, 2, 2):
        cv2.setNumThreads(count)
        found.append(keypoints(image.copy(), name))
    cv2.setNumThreads(threads)
    for key in ("uv", "angle", "scale", "response", "descriptors"):
        assert getattr(found[0], key).tobytes() == getattr(found[1], key).tobytes() == getattr(found[2], key).tobytes()


@BOTH
def test_the_strongest_come_first_and_no_more_than_asked(name):
    image = texture()
    every, few = keypoints(image, name), keypoints(image, name, most=20)
    assert 15 <= len(few) <= 20
    assert len(every) <= MOST
    assert (np.diff(every.response) <= 0).all()
    assert every.descriptors.shape == (len(every), WIDTHS[name][0])
    key = np.column_stack([np.round(every.uv, 2), np.round(every.angle, 3)])
    assert len(np.unique(key, axis=0)) == len(every)


def test_several_directions_at_one_place_are_kept():
    found = keypoints(texture())
    assert len(np.unique(np.round(found.uv, 2), axis=0)) < len(found)


def test_a_lower_contrast_gives_more():
    image = texture()
    soft = (image / 6 + 100).astype(np.uint8)
    assert len(keypoints(soft, contrast=0.002)) > len(keypoints(soft)) > len(keypoints(soft, contrast=0.04))


@BOTH
def test_constant_and_tiny_images_have_none_and_do_not_crash(name):
    assert len(keypoints(np.full((120, 160), 90, np.uint8), name)) == 0
    rng = np.random.default_rng(0)
    for shape in [(1, 1), (1, 300), (2, 2), (LEAST_SIDE, LEAST_SIDE), (9, 200), (31, 31), (0, 0)]:
        found = keypoints(rng.integers(0, 256, shape).astype(np.uint8), name)
        assert np.isfinite(found.uv).all()
        assert found.descriptors.shape == (len(found), WIDTHS[name][0])


def test_colour_is_read_as_its_grey():
    grey = texture()
    assert np.array_equal(keypoints(np.dstack([grey] * 3)).uv, keypoints(grey).uv)


def test_an_unknown_name_is_one_line():
    with pytest.raises(DetectorError, match="'surf' is neither"):
        keypoints(texture(), "surf")


class Halves:
    """Two words: descriptors whose first byte is small, and the others."""

    detector, names, sided = "sift", ("sift_w0000", "sift_w0001"), np.zeros(2, bool)

    def nearest(self, descriptors):
        """By the first byte."""
        return (descriptors[:, 0] > 20).astype(int)


def camera(image):
    return Camera(image.shape[1], image.shape[0], np.array([[300.0, 0, 120], [0, 300, 100], [0, 0, 1]]), np.zeros(0))


def coloured():
    return np.dstack([texture()] * 3)


def test_words_name_the_types_of_their_own_detector_alone():
    image = coloured()
    found = KeypointDetector("sift", Halves()).detect(image)
    assert {a.type for a in found} == set(Halves.names)
    assert all((a.descriptor[0] > 20) == (a.type == "sift_w0001") for a in found)
    assert KeypointDetector("orb", Halves()).types == ("orb",)
    assert {a.type for a in KeypointDetector("sift").detect(image)} == {"sift"}
    assert all(0 <= a.score <= 1 for a in found)


def test_detect_reports_the_words_of_the_vocabulary():
    image = coloured()
    found = detect(image, camera(image), {"sift_w0001"}, Halves()).appearances
    assert {(a.type, a.detector) for a in found} == {("sift_w0001", "sift")}
    assert detect(image, camera(image), {"sift_w0001"}).appearances == ()
    assert {a.type for a in detect(image, camera(image), {"orb", "sift"}, Halves()).appearances} == {"orb"}


def test_a_kb_without_keypoints_does_not_run_them(monkeypatch):
    def never(*_args, **_keys):
        raise AssertionError

    monkeypatch.setattr("sensing.detectors.keypoints.keypoints", never)
    image = coloured()
    assert all(a.type == "patch" for a in detect(image, camera(image), {"patch"}).appearances)
    assert detect(image, camera(image), {"other"}, Halves()).appearances == ()


@BOTH
def test_keypoints_survive_a_gamma_file(name):
    image = coloured()
    gamma = detect(image, camera(image), {name})
    assert len(gamma.appearances) > 30
    again = gamma_from_dict(gamma_to_dict(gamma))
    assert isinstance(again, Gamma)
    assert again.appearances == gamma.appearances
    assert {len(a.descriptor) for a in again.appearances} == {WIDTHS[name][0]}
