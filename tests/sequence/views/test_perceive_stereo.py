"""``plogic perceive LEFT RIGHT --stereo FILE`` through the console script, and what the right image does to a pose."""

from __future__ import annotations

import json

import numpy as np
import pytest
from console import document, plogic
from sequences import BESIDE, turned, view
from synthetic import towers

from geometry.frames import inverse, pose_error
from sensing.files.gamma_files import write_gamma

ASIDE = np.eye(4)
ASIDE[0, 3] = -0.8


@pytest.fixture(scope="module")
def pair(tmp_path_factory):
    """left.json, right.json and stereo.json of a pair 80 cm apart, before the two towers."""
    folder = tmp_path_factory.mktemp("pair")
    left = turned(0.0)
    write_gamma(view(1, left).gamma, folder / "left.json")
    write_gamma(view(2, left @ inverse(ASIDE)).gamma, folder / "right.json")
    (folder / "stereo.json").write_text(json.dumps({"format": "stereo/1", "T_right_left": ASIDE.tolist()}))
    return folder


def errors(told):
    truth = {name: inverse(turned(0.0)) @ pose for name, pose in BESIDE.items()}
    accepted = [h for h in told["hypotheses"] if h["status"] == "accepted"]
    return {
        h["type"]: pose_error(np.array(h["T_camera_object"]), truth[h["type"]], towers().type(h["type"]).symmetries)
        for h in accepted
    }


def test_the_pair_is_one_viewpoint_and_stands_better(pair):
    both = document(
        "perceive",
        "left.json",
        "right.json",
        "--stereo",
        "stereo.json",
        "--kb",
        "towers",
        "--reading",
        "posterior",
        cwd=pair,
    )
    alone = document("perceive", "left.json", "--kb", "towers", "--reading", "posterior", cwd=pair)
    assert both["format"] == alone["format"]
    assert [a["id"] for a in both["appearances"]] == [a["id"] for a in alone["appearances"]]
    assert any("depth" in a for a in both["appearances"])
    better, worse = errors(both), errors(alone)
    assert set(better) == set(worse) == {"t1", "t2"}
    assert sum(moved for _, moved in better.values()) < sum(moved for _, moved in worse.values())


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["left.json", "--stereo", "stereo.json"], "--stereo: takes two INPUTs"),
        (["left.json", "right.json", "--stereo", "none.json"], "none.json: is missing"),
        (
            ["left.json", "right.json", "--stereo", "left.json"],
            "left.json:2:12: format: 'gamma/1' should be 'stereo/1'",
        ),
        (
            ["left.json", "picture.png", "--stereo", "stereo.json"],
            "picture.png: an image needs its camera: stereo.json",
        ),
    ],
)
def test_what_is_wrong_is_said_in_a_line(pair, arguments, words):
    done = plogic("perceive", *arguments, "--kb", "towers", cwd=pair)
    assert done.returncode == 1
    assert words in done.stderr
    assert "Traceback" not in done.stderr
