"""Panoramas that strangers wrote: one line a mistake, and never a traceback."""

from __future__ import annotations

import json
import re

import numpy as np
import pytest
from written_panoramas import EMPTY, NOTHING_ELSE, interpretation_of

from plogic.base.errors import InputError
from plogic.sequence.constancy.panorama_reading import MOST_MISTAKES, unknown_of

CAMERA = {"width": 640, "height": 480, "K": [[600, 0, 320], [0, 600, 240], [0, 0, 1]], "dist": []}


def panorama():
    """Two views and an unknown object of one feature."""
    views = [
        {
            "id": f"v{i}",
            "frame": "f.json",
            "T_world_camera": np.eye(4).tolist(),
            "interpretation": interpretation_of(
                CAMERA, [{"id": "a1", "type": "patch", "uv": [1.0, 2.0]}, {"id": "a2", "type": "dot", "uv": [3.0, 4.0]}]
            ),
            **NOTHING_ELSE,
        }
        for i in (1, 2)
    ]
    feature = {
        "id": "u1/f1",
        "type": "patch",
        "at": [0.0, 0.1, 1.0],
        "sigma": 0.01,
        "probability": 0.9,
        "data": {"v1": "a1", "v2": "a1"},
    }
    return {
        **EMPTY,
        "views": views,
        "unknown": [{"id": "u1", "probability": 0.9, "features": [feature]}],
        "noise": {},
    }


def said(tmp_path, document):
    path = tmp_path / "p.json"
    path.write_text(document if isinstance(document, str) else json.dumps(document))
    with pytest.raises(InputError) as caught:
        unknown_of(str(path), "u1")
    return str(caught.value)


def test_a_good_one_is_read(tmp_path):
    (tmp_path / "p.json").write_text(json.dumps(panorama()))
    (feature,) = unknown_of(str(tmp_path / "p.json"), "u1")
    assert feature.type == "patch"
    assert [s.focal for s in feature.sightings] == [600.0, 600.0]


MISTAKES = [
    (lambda p: p.update(format="panorama/2"), "format: 'panorama/2' should be 'panorama/1'"),
    (lambda p: p.pop("views"), "views: is missing: should be a list"),
    (
        lambda p: p["views"][0].update(T_world_camera=[[1, 0, 0, 0]] * 4),
        "views.0.T_world_camera: must be a rigid 4x4 transform",
    ),
    (lambda p: p["views"][1].update(id="v1"), "views: 'v1' is the id of two"),
    (lambda p: p["views"][0]["interpretation"].update(camera={"width": -3}), "views.0.interpretation.camera"),
    (
        lambda p: p["unknown"][0]["features"][0].update(at=[1, 2]),
        "unknown.0.features.0.at: a list of 2, and not of 3",
    ),
    (
        lambda p: p["unknown"][0]["features"][0].update(at=[1, 2, 1e300]),
        "unknown.0.features.0.at: no number may be above 1e+06 m",
    ),
    (
        lambda p: p["unknown"][0]["features"][0].update(at=[0, 0, 0]),
        "unknown.0.features.0.at: lies in the camera of v1",
    ),
    (
        lambda p: p["unknown"][0]["features"][0].update(data={}),
        "unknown.0.features.0.data: is empty: should name an appearance by view",
    ),
    (lambda p: p["unknown"][0]["features"][0].update(data={"v9": "a1"}), "unknown.0.features.0.data: 'v9' is no view"),
    (lambda p: p["unknown"][0]["features"][0].update(data={"v1": "a9"}), "'a9' is no appearance of v1"),
    (
        lambda p: p["unknown"][0]["features"][0].update(data={"v1": "a2"}),
        "'a2' of v1 is a 'dot', and the feature a 'patch'",
    ),
]


@pytest.mark.parametrize(("spoil", "words"), MISTAKES)
def test_each_mistake_is_named(tmp_path, spoil, words):
    document = panorama()
    spoil(document)
    lines = said(tmp_path, document).splitlines()
    assert any(words in line for line in lines), lines
    place = re.compile(rf"{tmp_path / 'p.json'}:1:\d+: ")
    assert all(place.match(line) for line in lines)


@pytest.mark.parametrize(
    "text", ["", "{", "[1, 2]", '{"format": NaN}', "[" * 100_000, '{"a": ' + "9" * 5000 + "}", "null"]
)
def test_what_is_no_panorama(tmp_path, text):
    lines = said(tmp_path, text).splitlines()
    assert lines
    assert all(len(line) < 400 for line in lines)


def test_many_mistakes_are_counted(tmp_path):
    document = panorama()
    document["unknown"][0]["features"] *= 100
    for feature in document["unknown"][0]["features"]:
        feature["data"] = {"v9": "a1"}
    lines = said(tmp_path, document).splitlines()
    assert len(lines) == MOST_MISTAKES + 1
    assert lines[-1].endswith("and 80 more mistakes")
