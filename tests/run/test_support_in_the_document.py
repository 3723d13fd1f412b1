"""What things stand on, in ``interpretation.json``: told with its probabilities, read back, and asked of the file."""

from __future__ import annotations

import json
from dataclasses import replace

import pytest
from in_process import told
from standing_towers import SUPPORT, TIGHT, standing_towers

from plogic.base.errors import InterpretationError
from plogic.face.python.interpretation import Interpretation
from plogic.facts.interpretation import read_interpretation, situation_of, text_of
from plogic.facts.stances import words_of_standing
from plogic.scene.text.program_text import program_text
from plogic.scene.worlds.ranked_worlds import ranked_worlds


@pytest.fixture(scope="module", params=["score", "posterior"])
def written(request):
    return standing_towers(request.param)


@pytest.fixture(scope="module")
def file(written, tmp_path_factory):
    path = tmp_path_factory.mktemp("standing") / "interpretation.json"
    path.write_text(text_of(written[2]), encoding="utf-8")
    return path


def test_it_is_read_back_whole(written, file):
    situation, ranking, _ = written
    back = situation_of(read_interpretation(file))
    assert back == situation
    assert program_text(replace(back, types=situation.types)) == program_text(situation)
    assert ranked_worlds(back, 100) == ranking


def test_planes_are_told_with_their_probability_and_who_stands_there(written):
    situation, _, document = written
    assert document["resting"] == {"rests": 0.9, "none": 0.05}
    first, second = document["support_planes"]
    assert first["plane"] == {"normal": [0.0, -0.8, -0.6], "offset": -1.25}
    assert first["covariance"] == [list(row) for row in TIGHT]
    assert (first["name"], first["prior"], second["standing"]) == ("s1", 0.6, {})
    assert set(first["standing"]) == {"h1", "h2"}
    if situation.reading == "score":
        assert (first["probability"], second["probability"]) == pytest.approx((0.6, 0.2))
    else:
        assert first["probability"] > 0.97
        assert min(first["standing"].values()) > 0.8


def test_each_hypothesis_tells_its_stances_and_how_free_it_is(written):
    _, ranking, document = written
    rows = [h for h in document["hypotheses"] if h["status"] != "rejected"]
    assert [(h["id"], s["on"], s["face"], s["chance"], s["log_ratio"]) for h in rows for s in h["stances"]] == [
        (s.hypothesis, s.on, s.face, s.chance, s.log_ratio) for s in SUPPORT.stances
    ]
    assert len(rows) >= 2
    for h in rows:
        assert sum(s["probability"] for s in h["stances"]) + h["free"] <= ranking.marginals[h["id"]] + 1e-9
        assert "expected_detected" in next(iter(h["support"].values()))
    assert {h["id"]: h["stands_by_chance"] for h in rows if "stands_by_chance" in h} == {"h2": 0.12}


def test_worlds_tell_what_things_stand_on(written):
    situation, ranking, document = written
    assert [(w["support"], w["stances"]) for w in document["worlds"]] == [
        (w.told.state, w.told.stances) for w in ranking.worlds
    ]
    on = "s1/0" if situation.reading == "posterior" else "h1/0"  # ρ is no evidence in the score reading
    assert document["worlds"][0]["stances"] == {"h1": "s1/0", "h2": on}


def test_where_nothing_is_said_to_rest_nothing_is_told(written):
    situation, _, document = written
    bare = {key: value for key, value in document.items() if key not in ("support_planes", "resting")}
    assert situation_of(bare) == replace(situation, support=None)


def test_commands_answer_from_the_file(written, file):
    situation, _, document = written
    assert any("stands on" in line for line in told("worlds", file))
    (world, *_) = json.loads("\n".join(told("worlds", file, "--json")))["worlds"]
    assert (world["support"], world["stances"]) == (document["worlds"][0]["support"], document["worlds"][0]["stances"])
    words = words_of_standing(world["support"], world["stances"])
    assert any(words in line for line in told("worlds", file))
    found = json.loads("\n".join(told("query", file, "support_plane(S)", "--json")))["answers"]
    assert {a["goal"]: a["probability"] for a in found} == pytest.approx(
        {f"support_plane({p['name']})": p["probability"] for p in document["support_planes"]}
    )
    assert "\n".join(told("program", file)).startswith(program_text(situation_of(document)))
    words = (
        "believed because it stands on s1, the plane of h2" if situation.reading == "posterior" else "most probably it"
    )
    assert any(words in line for line in told("explain", file, "present(h1)"))


def test_python_tells_it(written, file):
    opened = Interpretation.load(file)
    (first, *_) = opened.worlds(3)
    assert (first.support, first.stances["h1"]) == ("s1", "s1/0")
    assert "stands on" in str(opened.worlds(3))


def test_whose_pose_is_withheld_stands_nowhere(file):
    without = Interpretation.load(file).withhold("h1")
    support = without.subject.support
    assert {s.hypothesis for s in support.stances} == {"h2"}
    assert {s.on for s in support.stances} == {"s1"}
    assert [answer.goal for answer in without.query("free(H)").rows] == ["free(h2)"]


@pytest.mark.parametrize(
    ("spoil", "said"),
    [
        (lambda d: d["support_planes"][0]["plane"].update(normal=[0.0, -2.0, 0.0]), "s1: normal is 2.0 long"),
        (lambda d: d["support_planes"][0].update(prior=0.9), "sum to more than 1"),
        (lambda d: d["support_planes"][0].pop("plane"), "plane: is missing"),
        (lambda d: d["hypotheses"][0]["stances"][0].update(on="s7"), "'s7' is unknown"),
        (lambda d: d["hypotheses"][0]["stances"][0].update(on="h2"), "some stand on what stands on them"),
        (lambda d: d["resting"].update(rests=2), "resting.rests"),
        (lambda d: d["hypotheses"][0].update(stands_by_chance=2), "stands_by_chance"),
    ],
)
def test_a_spoilt_file_is_told(written, tmp_path, spoil, said):
    document = json.loads(json.dumps(written[2]))
    spoil(document)
    path = tmp_path / "spoilt.json"
    path.write_text(json.dumps(document), encoding="utf-8")
    with pytest.raises(InterpretationError, match=said):
        read_interpretation(path)
