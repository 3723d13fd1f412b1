"""The picture of figure 5: four cases that look different, a colour per hypothesis, names that do not overlap."""

from __future__ import annotations

import copy

import cv2
import numpy as np
import pytest
from towers_scene import HEIGHT, WIDTH, photograph

from plogic.face.shown.overlay import PALETTE, bgr, overlay
from plogic.face.shown.pencil import Pencil, free_place, meet


def _plain(towers, **changes):
    return overlay(towers | changes, None)


def test_it_is_twice_the_image_and_a_legend(towers):
    picture = overlay(towers, photograph(3, 1))
    assert picture.shape[1] == 2 * WIDTH
    assert 2 * HEIGHT + 40 < picture.shape[0] < 2 * HEIGHT + 200
    assert picture.dtype == np.uint8


def test_the_image_given_is_not_drawn_upon(towers):
    image = photograph(3, 1)
    before = image.copy()
    overlay(towers, image)
    assert np.array_equal(image, before)


def test_only_accepted_hypotheses_are_drawn(towers):
    accepted = [h for h in towers["hypotheses"] if h["status"] == "accepted"]
    assert np.array_equal(_plain(towers), _plain(towers, hypotheses=accepted))
    assert not np.array_equal(_plain(towers), _plain(towers, hypotheses=accepted[:1]))


def test_an_empty_interpretation_is_the_bare_image(towers):
    picture = _plain(towers, hypotheses=[], appearances=[])
    assert (picture[: 2 * HEIGHT] == 205).all()


def test_a_large_image_keeps_its_size(towers):
    camera = towers["camera"] | {"width": 1920, "height": 1080}
    assert overlay(towers | {"camera": camera}, None).shape[1] == 1920


def _mark(*, circle, filled):
    picture = np.full((60, 60, 3), 205, np.uint8)
    Pencil(picture, 1).feature((30, 30), bgr(PALETTE[0]), circle=circle, filled=filled)
    return picture


@pytest.mark.parametrize("one", [(True, True), (True, False), (False, True), (False, False)])
def test_the_four_cases_look_different(one):
    mine = _mark(circle=one[0], filled=one[1])
    others = [_mark(circle=c, filled=f) for c in (True, False) for f in (True, False) if (c, f) != one]
    assert len(others) == 3
    assert all(np.count_nonzero((mine != o).any(-1)) > 60 for o in others)
    assert (mine[30, 30] != 205).any() == one[1]


def test_each_hypothesis_has_its_own_colour(towers):
    picture = _plain(towers)[: 2 * HEIGHT].reshape(-1, 3)
    for colour in PALETTE[:2]:
        assert np.count_nonzero((picture == bgr(colour)).all(-1)) > 500
    assert np.count_nonzero((picture == bgr(PALETTE[2])).all(-1)) == 0


def test_colours_are_told_apart_by_eye():
    lab = cv2.cvtColor(np.array([[bgr(c) for c in PALETTE]], np.uint8), cv2.COLOR_BGR2LAB)[0].astype(float)
    apart = np.linalg.norm(lab[:, None] - lab[None], axis=-1)[np.triu_indices(len(PALETTE), 1)]
    assert apart.min() > 25


def test_names_do_not_overlap():
    pencil = Pencil(np.zeros((480, 640, 3), np.uint8), 1)
    taken = []
    for _ in range(12):
        box = free_place((90, 14), (300, 200), taken, pencil, needed=True)
        assert box is not None
        assert 0 <= box[0] < box[2] <= 640
        assert 0 <= box[1] < box[3] <= 480
        taken.append(box)
    assert not any(meet(a, b) for i, a in enumerate(taken) for b in taken[:i])
    assert free_place((600, 400), (300, 200), taken, pencil, needed=False) is None


def test_a_name_of_other_letters_and_an_unknown_type_are_drawn(towers):
    strange = copy.deepcopy(towers)
    strange["hypotheses"][0]["label"] = "Türmchen 塔"
    strange["appearances"][0]["type"] = "word_17"
    assert overlay(strange, None).shape[1] == 2 * WIDTH


def test_a_mark_at_the_edge_and_one_outside_do_no_harm():
    picture = np.full((40, 40, 3), 205, np.uint8)
    for place in ((0, 0), (39, 39), (-30, 10), (500, 500)):
        Pencil(picture, 1).feature(place, bgr(PALETTE[1]), circle=True, filled=True)
    assert (picture != 205).any()
