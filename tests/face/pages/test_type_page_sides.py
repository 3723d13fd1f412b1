"""Sides of edges on the page of a type: which they are, which way they run, and that they can be put aside."""

from __future__ import annotations

import base64
from dataclasses import replace

import numpy as np
import pytest
from made_types import write_learned
from page_checks import COLOURS, COUNT, complaints, shown_as
from random_cloud import random_cloud

from kb.files.read import read_kb
from plogic.face.pages.type_content import type_document, type_page

SIDES = 8
TEXT = "return document.querySelector(arguments[0]).innerText"


@pytest.fixture(scope="module")
def sided_kb(tmp_path_factory):
    """A learned type of 16 features, of which the last half are sides of edges, of a word that no keypoint has."""
    cloud = random_cloud(5, 2 * SIDES, 70, words=6)
    side = cloud.feature >= SIDES
    word, lobe_word = np.where(np.arange(2 * SIDES) < SIDES, cloud.word, 6), np.where(side, 6, cloud.lobe_word)
    cloud = replace(cloud, size=np.where(side, 0.0, cloud.size), word=word, lobe_word=lobe_word)
    return read_kb(write_learned(tmp_path_factory.mktemp("sided"), cloud))


@pytest.fixture
def sided(chromium, sided_kb, tmp_path):
    return shown_as(chromium, tmp_path, type_page(sided_kb, sided_kb.types[0]))


def test_strokes_run_along_the_edge_and_across_it(sided_kb):
    kind = sided_kb.types[0]
    sides = type_document(sided_kb, kind)["features"]["sides"]
    feature = np.frombuffer(base64.b64decode(sides["feature"]), "<u2")
    along, across = np.split(np.frombuffer(base64.b64decode(sides["strokes"]), "<f4").reshape(-1, 6), 2, axis=1)
    assert feature.tolist() == list(range(SIDES, 2 * SIDES))
    assert np.allclose(np.linalg.norm(along, axis=1), 1.0, atol=1e-5)
    assert np.allclose((along * across).sum(axis=1), 0.0, atol=1e-5)
    cloud = kind.learned
    surest = [max(np.flatnonzero(cloud.feature == f), key=lambda row: cloud.hit[row]) for f in feature]
    assert np.allclose(across, cloud.up[surest], atol=1e-6)


def test_a_type_without_sides_has_none(learned_kb, tower_kb):
    assert type_document(learned_kb, learned_kb.types[0])["features"]["sides"] is None
    assert type_document(tower_kb, tower_kb.types[0])["features"]["sides"] is None


def test_sides_are_drawn_and_can_be_put_aside(sided):
    drawn = sided.run(COLOURS)
    sided.click("[data-layer=sides]")
    assert sided.run(COLOURS)[2] != drawn[2]
    sided.click("[data-layer=sides]")
    assert sided.run(COLOURS) == drawn
    assert "the side of an edge" in sided.run(TEXT, "#legend")
    assert complaints(sided) == []


def test_a_side_says_that_it_is_one_and_no_keypoint_does(sided, sided_kb):
    names = [feature.name for feature in sided_kb.types[0].features]
    sided.click("[data-layer=surface]")
    told = {}
    for _ in names:
        sided.click("[data-walk='1']")
        told[names.index(sided.run(TEXT, ".about-name"))] = "the side of an edge" in sided.run(TEXT, "#about")
    assert told == {index: index >= SIDES for index in range(2 * SIDES)}


def test_those_put_aside_are_not_walked_to(sided, sided_kb):
    names = [feature.name for feature in sided_kb.types[0].features]
    for layer in ("surface", "sides"):
        sided.click(f"[data-layer={layer}]")
    reached = set()
    for _ in range(SIDES + 3):
        sided.click("[data-walk='1']")
        reached.add(names.index(sided.run(TEXT, ".about-name")))
    assert reached == set(range(SIDES))


def test_without_sides_there_is_no_switch(chromium, learned_kb, tmp_path):
    shown_as(chromium, tmp_path, type_page(learned_kb, learned_kb.types[0]))
    assert chromium.run(COUNT, "[data-layer=sides]") == 0
    assert chromium.run(COUNT, "[data-layer=surface]") == 1


def test_without_webgl_they_are_strokes_as_well(flat_chromium, sided_kb, tmp_path):
    browser = shown_as(flat_chromium, tmp_path, type_page(sided_kb, sided_kb.types[0]))
    drawn = browser.run(COLOURS)
    browser.click("[data-layer=sides]")
    assert browser.run(COLOURS)[2] != drawn[2]
    assert complaints(browser) == []
