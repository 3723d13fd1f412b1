"""`plogic next-view` on an interpretation in doubt: gains, goals, moves of one's own, and what is refused."""

from __future__ import annotations

import json
import re
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
from plogic.face.commands.next_view import looked
from plogic.face.shown.options import Moves
from plogic.facts.interpretation import situation_of, text_of
from plogic.run.perceive import Perceiver
from plogic.scene.asking.query import answers
from plogic.sequence.next_view.look import answers_in
from plogic.sequence.next_view.reading import prospect_of
from sensing.appearance import Appearance, Gamma

WORLD = camera_at(0.6, -4.0, 1.8)


@cache
def document():
    """A tower of which the north wall would tell which it is, seen from the south.

    Six of seven features that show are reported, without noise.
    """
    from plogic.match.gamma.data import data_of
    from plogic.match.judged.expectation import pose_of

    kb, camera = read_kb(shipped("lookalikes")), Camera(CAMERA.width, CAMERA.height, CAMERA.K, world_from_camera=WORLD)
    kind = kb.type("open_tower")
    posed = pose_of(kind, inverse(WORLD), data_of([], camera), kb)
    held = [(kind.lobes.types[lobe], kind.lobes.feature[lobe]) for lobe in range(len(kind.lobes.types))]
    first = {int(f): name for name, f in reversed(held)}
    seen = [f for f in np.flatnonzero(posed.candidate).tolist() if f % 7]
    data = [Appearance(f"a{f}", first[f], (float(posed.uv[f, 0]), float(posed.uv[f, 1])), "told") for f in seen]
    return Perceiver(kb)(Gamma(camera, tuple(data)), Options(reading="posterior"))


@pytest.fixture
def file(tmp_path):
    (tmp_path / "i.json").write_text(text_of(document()))
    return tmp_path / "i.json"


def _asked(file, *options):
    done = CliRunner().invoke(cli, ["next-view", str(file), *options])
    if done.exception is not None and not isinstance(done.exception, SystemExit):
        raise done.exception
    return done.output


def test_two_worlds_are_near_even_and_it_would_look_from_behind(file):
    answer = json.loads(_asked(file, "--json", "-n", "11"))
    assert answer["format"] == "next-view/1"
    assert answer["entropy_bits"] == pytest.approx(1.0, abs=0.1)
    assert (answer["of"], len(answer["candidates"])) == (11, 11)
    best, last = answer["candidates"][0], answer["candidates"][-1]
    assert best["gain_bits"] > 0.9
    assert last["gain_bits"] < 0.3
    assert np.array(best["T_world_camera"])[1, 3] > 0.0  # north of the tower
    assert "north" in best["why"][0]["text"]
    assert np.allclose(WORLD @ np.array(best["T_present_candidate"]), best["T_world_camera"])


def test_about_a_goal_no_gain_exceeds_that_about_the_worlds():
    first = document()["worlds"][0]["present"][0]
    whole, about = (looked(document(), 11, 0, Moves(about=goal)) for goal in (None, f"present({first})"))
    gains = [{row["name"]: row["gain_bits"] for row in answer["candidates"]} for answer in (whole, about)]
    assert about["entropy_bits"] <= whole["entropy_bits"] + 1e-9
    assert len(gains[1]) == 11
    assert all(gains[1][name] <= gains[0][name] + 1e-6 for name in gains[0])


def test_about_what_is_unknown_nothing_is_listed():
    with pytest.raises(PlogicError, match="--about: h99 is unknown as argument 1 of present/1"):
        looked(document(), 11, 0, Moves(about="present(h99)"))


def test_about_what_is_certain_there_is_nothing_to_gain():
    sure = looked(document(), 11, 0, Moves(about="opaque(h1)"))
    assert sure["entropy_bits"] == 0.0
    assert {row["gain_bits"] for row in sure["candidates"]} == {0.0}


def test_the_worlds_answer_a_goal_as_query_does():
    situation = situation_of(document())
    worlds = document()["worlds"]
    mass = np.array([w["probability"] for w in worlds])
    (asked,) = answers(situation, f"present({situation.hypotheses[0].id})")
    true = answers_in(situation, [w["present"] for w in worlds], f"present({situation.hypotheses[0].id})")[:, 0]
    assert mass @ true == pytest.approx(asked.probability, abs=1e-6 + document()["unlisted_mass"][1])
    which = answers_in(situation, [w["present"] for w in worlds], "present(H)")
    assert which.shape[1] == len({tuple(w["present"]) for w in worlds})


def test_the_other_reading_has_worlds_of_its_own(file):
    score = json.loads(_asked(file, "--json", "--reading", "score"))
    assert score["reading"] == "score"
    assert 0.0 < score["entropy_bits"] != json.loads(_asked(file, "--json"))["entropy_bits"]


def test_moves_of_ones_own_and_all_within_a_distance(file, tmp_path):
    behind = camera_at(0.0, 4.0, 1.8)
    rows = [
        {"name": "behind", "T_world_camera": behind.tolist()},
        {"name": "stay", "T_present_candidate": np.eye(4).tolist()},
    ]
    (tmp_path / "moves.json").write_text(json.dumps({"format": "moves/1", "moves": rows}))
    answer = json.loads(_asked(file, "--json", "--moves", str(tmp_path / "moves.json")))
    assert [row["name"] for row in answer["candidates"]] == ["behind", "stay"]
    assert answer["candidates"][1]["gain_bits"] < 0.1
    near = json.loads(_asked(file, "--json", "--within", "0.5"))
    assert near["moves"]["step"] == pytest.approx(0.5 / 3)
    assert near["candidates"][0]["gain_bits"] < 0.3


def test_the_table_says_what_is_uncertain_and_why(file):
    text = _asked(file, "-n", "2")
    assert "uncertain of the worlds" in text
    assert "2 of 11 candidates" in text
    assert "is not there" in " ".join(text.split())
    assert text == _asked(file, "-n", "2")


@pytest.mark.parametrize("lost", [("sensing", "types"), ("camera",), ("assets",)])
def test_an_older_interpretation_is_told_to_perceive_again(file, lost):
    old = {key: value for key, value in document().items() if key not in lost}
    file.write_text(text_of(old))
    with pytest.raises(PlogicError, match=rf"i\.json: {', '.join(lost)}: is missing; .*perceive again") as error:
        _asked(file)
    assert len(str(error.value).splitlines()) == 1


@pytest.mark.parametrize(
    ("broken", "why"),
    [
        ({"types": {}}, "not complete"),
        ({"sensing": {}}, "sensing.f_ref: is missing"),
        ({"types": {"open_tower": {"features": [[1]]}}}, "types.open_tower.looks: is missing"),
    ],
)
def test_what_is_broken_is_refused_with_its_place(file, broken, why):
    file.write_text(text_of({**document(), **broken}))
    with pytest.raises(PlogicError) as error:
        _asked(file)
    lines = str(error.value).splitlines()
    assert [line for line in lines if not re.match(rf"{file}(:1:\d+)?: ", line)] == []
    assert [line for line in lines if why in line]


def test_a_goal_that_is_none_is_refused(file):
    with pytest.raises(PlogicError):
        _asked(file, "--about", "present(")


def test_ways_to_move_exclude_one_another(file):
    assert CliRunner().invoke(cli, ["next-view", str(file), "--ring", "2", "--within", "1"]).exit_code == 2


def test_what_is_carried_says_how_the_types_are_seen():
    kb, carried = read_kb(shipped("lookalikes")), document()["types"]
    prospect = prospect_of(document())
    for body in prospect.bodies:
        kind = kb.type(body.cloud.name)
        assert body.cloud.features == tuple(f.name for f in kind.features)
        assert body.cloud.lobes.types == kind.lobes.types
        assert np.allclose(body.cloud.lobes.axis, kind.lobes.axis, atol=1e-3)
        assert np.allclose(body.cloud.lobes.cos_half, kind.lobes.cos_half, atol=1e-3)
    assert prospect.bodies
    assert all("left_out" not in table for table in carried.values())
