"""The picture of figure 5: four cases that look different, a colour per hypothesis, names that do not overlap."""

from __future__ import annotations

import copy

import cv2
import numpy as np
import pytest
import shapely
from towers_scene import HEIGHT, WIDTH, photograph

from plogic.face.shown.edges import edges_of
from plogic.face.shown.overlay import BUSY, PALETTE, bgr, overlay
from plogic.face.shown.pencil import OTHER, SIGNS, TINTS, Pencil, free_place, meet, sign_of


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


def _bare(towers, **changes):
    """Edges and names alone: no feature, no appearance."""
    rows = [h | {"features": []} for h in towers["hypotheses"]]
    return _plain(towers, hypotheses=rows, appearances=[], **changes)


def _coloured(picture, stroke, colour):
    """The share of a stroke's places that have its colour."""
    line = shapely.LineString(stroke.points)
    places = shapely.get_coordinates(line.interpolate(np.arange(3.0, max(3.5, line.length - 3), 0.5)))
    u, v = np.round(places * 2 + 0.5).astype(int).T
    near = [np.abs(picture[v + j, u + i].astype(int) - colour).max(-1) < 40 for i in (-1, 0, 1) for j in (-1, 0, 1)]
    return float(np.mean(np.any(near, axis=0)))


def test_hidden_edges_are_dashed_and_seen_ones_are_whole(towers):
    picture = _bare(towers)
    shares = {True: [], False: []}
    for i, strokes in enumerate(edges_of(towers)[h] for h in ("h1", "h2")):
        for stroke in strokes:
            hidden = stroke.self_hidden or "h1" in stroke.hidden_by
            if shapely.LineString(stroke.points).length > 30:
                shares[hidden].append(_coloured(picture, stroke, bgr(PALETTE[i])))
    assert len(shares[True]) >= 5
    assert len(shares[False]) >= 5
    assert np.median(shares[False]) > 0.97
    assert 0.4 < np.median(shares[True]) < 0.8


def test_the_legend_tells_of_hidden_edges_where_there_are_any(towers):
    entries = [np.count_nonzero(_bare(towers, assets=assets)[2 * HEIGHT :] > 100) for assets in (towers["assets"], {})]
    assert entries[0] > entries[1] + 100


def test_hundreds_of_marks_are_pale(towers):
    at = [40.0, 40.0]
    sign = towers["appearances"][0] | {"type": "patch", "uv": at}
    few, many = (
        _plain(towers, hypotheses=[], appearances=[sign] + [sign | {"uv": [500.0, 400.0]}] * n) for n in (10, BUSY)
    )
    x, y = round(2 * at[0] + 0.5) - 4, round(2 * at[1] + 0.5) - 4
    assert few[y, x].min() > 240
    assert 205 < many[y, x].min() < 235


def test_every_appearance_type_has_a_sign_of_its_own():
    """By its strokes or its colour, for as many unknown types as there are pairs of the two."""
    kinds = sorted([*SIGNS, *(f"type_{i:02}" for i in range(len(OTHER) * len(TINTS)))])
    signs = [sign_of(kind, kinds) for kind in kinds]
    assert len(kinds) > 30
    assert len(set(signs)) == len(kinds)


def test_unknown_types_are_drawn_apart():
    names = [f"odd_{i:02}" for i in range(len(OTHER) + 2)]
    pictures = []
    for name in names:
        pencil = Pencil(np.zeros((30, 30, 3), np.uint8), 1)
        pencil.sign((15, 15), name, names)
        pictures.append(pencil.picture.tobytes())
    assert len(set(pictures)) == len(names) > 9
