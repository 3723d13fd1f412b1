"""A camera that is not the picture's: the poses fit all the same, and what they fit better is told."""

from __future__ import annotations

import json

import pytest
from in_process import told

FIT = "the accepted objects fit a focal length of "


@pytest.fixture(scope="module")
def scene(tmp_path_factory):
    folder = tmp_path_factory.mktemp("lens") / "scene"
    told("simulate", "--kb", "towers", "--gamma", "--seed", "2", "-o", str(folder))
    return folder


def with_focal(scene, share):
    """The scene's Γ under a camera whose focal length is off."""
    gamma = json.loads((scene / "gamma.json").read_text(encoding="utf-8"))
    gamma["camera"]["K"][0][0] *= share
    gamma["camera"]["K"][1][1] *= share
    place = scene / f"gamma-{share}.json"
    place.write_text(json.dumps(gamma), encoding="utf-8")
    return place


def lines(scene, share, tmp_path):
    return [
        line
        for line in told("perceive", str(with_focal(scene, share)), "--kb", "towers", "-o", str(tmp_path / "o.json"))
        if FIT in line
    ]


def test_the_right_camera_is_not_doubted(scene, tmp_path):
    assert lines(scene, 1.0, tmp_path) == []


@pytest.mark.parametrize("share", [0.6, 1.8])
def test_a_wrong_one_is_and_the_right_focal_length_is_named(scene, tmp_path, share):
    (line,) = lines(scene, share, tmp_path)
    camera = json.loads((scene / "gamma.json").read_text(encoding="utf-8"))["camera"]
    said = float(line.removeprefix(FIT).split()[0])
    error = float(line.split("standard error ")[1].split(")")[0])
    right = camera["K"][0][0]
    assert abs(said - right) < 4.0 * error
    assert f"the camera's {right * share:.0f}" in line
    assert "is it this picture's camera" in line
