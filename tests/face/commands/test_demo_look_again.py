"""`plogic demo --look-again`.

Two worlds near even, and a second view, where it was said to tell most, that settles it.
"""

from __future__ import annotations

import json

import cv2
import numpy as np
import pytest
from click.testing import CliRunner

from cli import cli


@pytest.fixture(scope="module")
def shown(tmp_path_factory):
    folder = tmp_path_factory.mktemp("look") / "again"
    done = CliRunner().invoke(cli, ["demo", "--look-again", "-o", str(folder), "--json"], catch_exceptions=False)
    assert done.exit_code == 0
    return json.loads(done.stdout), folder


def test_one_image_leaves_two_worlds_near_even_and_the_chosen_view_settles_it(shown):
    told, folder = shown
    first, second = (w["probability"] for w in told["worlds"][:2])
    assert 0.4 < second <= first < 0.6
    assert told["next_view"]["candidates"][0]["gain_bits"] > 0.9
    assert told["after"][0]["probability"] > 0.95
    types = {h["id"]: h["type"] for h in json.loads((folder / "worlds.json").read_text())["hypotheses"]}
    assert sorted(types[name] for name in told["after"][0]["present"]) == ["open_tower", "pyramid_tower"]


def test_the_folder_holds_both_views_where_they_were_taken_and_what_can_be_asked(shown):
    told, folder = shown
    poses = json.loads((folder / "poses.json").read_text())["frames"]
    assert np.allclose(poses[1]["T_world_camera"], told["next_view"]["candidates"][0]["T_world_camera"])
    both = cv2.imread(str(folder / "views.png"))
    assert both.shape[1] > 2 * cv2.imread(str(folder / "view-1.png")).shape[1]
    again = CliRunner().invoke(
        cli, ["next-view", str(folder / "interpretation.json"), "-n", "4", "--json"], catch_exceptions=False
    )
    assert json.loads(again.stdout)["candidates"] == told["next_view"]["candidates"]
