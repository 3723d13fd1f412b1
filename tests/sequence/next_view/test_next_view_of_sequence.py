"""`plogic next-view` of a `panorama/1`: the worlds of all views, from where the last one stood."""

from __future__ import annotations

import json
from copy import deepcopy
from functools import cache

import numpy as np
import pytest
from click.testing import CliRunner
from made_prospects import CAMERA, camera_at

from cli import cli
from geometry.camera import Camera
from geometry.errors import PlogicError
from geometry.frames import inverse
from kb.files.folder import shipped
from kb.files.read import read_kb
from plogic.cycle.delta import Options
from plogic.run.perceive import Perceiver
from plogic.sequence.constancy.sight_lines import View
from plogic.sequence.views.panorama import Panorama, panorama_document
from sensing.appearance import Appearance, Gamma

SOUTH, SOUTH_TOO, NORTH = camera_at(0.6, -4.0, 1.8), camera_at(-0.3, -4.1, 1.8), camera_at(-0.6, 4.0, 1.8)


@cache
def sequence(*places):
    """An open tower at the origin, which is a blind tower's twin from the south.

    Six of seven features that show are reported, without noise.
    """
    from plogic.match.gamma.data import data_of
    from plogic.match.judged.expectation import pose_of

    kb = read_kb(shipped("lookalikes"))
    kind, known, looks = kb.type("open_tower"), Panorama(Perceiver(kb), Options(reading="posterior")), []
    for n, place in enumerate(places, 1):
        pose = {"south": SOUTH, "south too": SOUTH_TOO, "north": NORTH}[place]
        camera = Camera(CAMERA.width, CAMERA.height, CAMERA.K, world_from_camera=pose)
        posed = pose_of(kind, inverse(pose), data_of([], camera), kb)
        first = {int(f): look for f, look in reversed(list(zip(kind.lobes.feature, kind.lobes.types, strict=True)))}
        seen = [f for f in np.flatnonzero(posed.candidate).tolist() if f % 7]
        data = [Appearance(f"a{f}", first[f], (float(posed.uv[f, 0]), float(posed.uv[f, 1])), "told") for f in seen]
        looks.append((f"f{n}", known.look(View(f"v{n}", Gamma(camera, tuple(data)), pose))))
    return json.loads(json.dumps(panorama_document(known, looks)))


def asked(document, tmp_path, *options):
    (tmp_path / "p.json").write_text(json.dumps(document))
    done = CliRunner().invoke(cli, ["next-view", str(tmp_path / "p.json"), "--json", "-n", "11", *options])
    if done.exception is not None and not isinstance(done.exception, SystemExit):
        raise done.exception
    return json.loads(done.output)


def test_of_one_view_it_says_what_the_interpretation_says(tmp_path):
    document = sequence("south")
    whole, alone = asked(document, tmp_path), asked(document["views"][0]["interpretation"], tmp_path)
    assert whole["entropy_bits"] == pytest.approx(alone["entropy_bits"], abs=0.02)
    gains = [{row["name"]: row["gain_bits"] for row in answer["candidates"]} for answer in (whole, alone)]
    assert gains[0].keys() == gains[1].keys()
    assert [gains[0][name] for name in gains[1]] == pytest.approx(list(gains[1].values()), abs=0.05)


def test_after_two_views_from_the_same_side_it_would_look_from_behind(tmp_path):
    answer = asked(sequence("south", "south too"), tmp_path)
    assert answer["entropy_bits"] == pytest.approx(1.0, abs=0.1)
    best = answer["candidates"][0]
    assert best["gain_bits"] > 0.9
    assert np.array(best["T_world_camera"])[1, 3] > 0.0  # north of the tower
    assert np.allclose(SOUTH_TOO @ np.array(best["T_present_candidate"]), best["T_world_camera"])


def test_what_it_asks_for_settles_it(tmp_path):
    answer = asked(sequence("south", "north"), tmp_path)
    assert answer["entropy_bits"] < 0.1
    assert max(row["gain_bits"] for row in answer["candidates"]) < 0.1


@pytest.mark.parametrize(
    ("options", "says"),
    [
        (("--about", "present(p1)"), "ask the interpretation of one of its views"),
        (("--reading", "score"), "perceive it again for the other"),
    ],
)
def test_what_the_worlds_of_a_sequence_do_not_say_is_refused(tmp_path, options, says):
    with pytest.raises(PlogicError, match=says):
        asked(sequence("south"), tmp_path, *options)


@pytest.mark.parametrize(
    ("spoil", "says"),
    [
        (
            lambda d: d.pop("rivals"),
            "rivals: is missing: should be a list, each a list of 2, each a text; if it is an older one, perceive the sequence again",
        ),
        (lambda d: d.update(views=[]), "views: there is none"),
        (
            lambda d: d["views"][0].update(T_world_camera=[[1, 0, 0, 0]]),
            "views.0.T_world_camera: should be a rigid 4x4",
        ),
        (
            lambda d: d["hypotheses"][0].update(T_world_object=np.diag([1.0, 2.0, 1.0, 1.0]).tolist()),
            "should be a rigid 4 x 4 transform",
        ),
        (lambda d: d["worlds"][0]["present"].append("p99"), "p99 should be among the hypotheses"),
        (lambda d: d["worlds"][0].update(probability="much"), "worlds.0.probability: 'much' is not a number from"),
        (lambda d: d.update(unlisted_mass=[0.0]), "unlisted_mass: a list of 1, and not of 2"),
        (lambda d: d.update(worlds=7), "worlds: 7 is no list"),
        (lambda d: d["views"][0]["interpretation"].update(types=[]), "views.0.interpretation.types: [] is no object"),
        (lambda d: d["hypotheses"][0].update(type="never heard of"), "types, sensing or assets: not complete"),
        (
            lambda d: d["views"][0]["interpretation"].pop("camera"),
            "views.0.interpretation.camera: is missing; if it is an older one",
        ),
        (lambda d: d.update(format="panorama/2"), "'interpretation/1' or 'panorama/1'"),
    ],
)
def test_a_broken_one_is_refused_in_a_line(tmp_path, spoil, says):
    document = deepcopy(sequence("south"))
    spoil(document)
    with pytest.raises(PlogicError) as told:
        asked(document, tmp_path)
    assert says in str(told.value)
    assert "\n" not in str(told.value)


@pytest.mark.parametrize("options", [(), ("--within", "0.5"), ("--ring", "1")])
def test_where_nothing_may_be_there_is_nothing_to_look_at(tmp_path, options):
    document = deepcopy(sequence("south"))
    document.update(hypotheses=[], rivals=[], worlds=[{"probability": 1.0, "present": []}], unlisted_mass=[0.0, 0.0])
    (tmp_path / "p.json").write_text(json.dumps(document))
    told = CliRunner().invoke(cli, ["next-view", str(tmp_path / "p.json"), *options]).output
    assert told.startswith("uncertain of the worlds: 0.000 bits over 1 world; no candidates\n")
