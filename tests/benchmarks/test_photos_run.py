"""``plogic bench photos`` end to end: small photos, simulated ones, each type left out."""

from __future__ import annotations

import shutil

import pytest
from console import plogic
from photo_folder import models, photos, ran


@pytest.fixture(scope="module")
def one(tmp_path_factory):
    """Photos of one type."""
    return photos(tmp_path_factory.mktemp("one"), {"cube": 1})


def test_photos_are_counted_claimed_and_drawn(one):
    found, done = ran(one, "photos", "--pictures", "pictures")
    assert done.returncode == 1, "eleven of twelve are asked for"
    ours, without, first, peer = found["rows"]
    assert (ours["row"], ours["there"], ours["right"], ours["false"]) == ("ycb, ours", 2, 2, 0)
    assert {**without, "seconds": 0} == {**ours, "row": "ycb, without support", "seconds": 0}, (
        "one alone stands for itself"
    )
    assert found["planes"] == []
    assert first["row"] == "ycb, the first of each type"
    assert (first["there"], first["accepted"], first["found"]) == (2, 2, 2)
    assert peer["there"] == 2
    assert found["not right"] == []
    claimed = {row["claim"]: row for row in found["claimed"]}
    assert [(row["forecasts"], row["true"]) for row in claimed.values()] == [(2, 1.0)] * 3
    for row in claimed.values():
        assert row["low"] <= row["ECE"] == pytest.approx(1.0 - row["mean P"], abs=0.001)
    bars = {claim["claim"]: claim for claim in found["claims"]}
    assert bars["ycb: right, of 2"]["value"] == 2
    assert bars["photos: ECE, its pose is right"]["bar"] == "<= 0.08"
    assert sorted(p.name for p in (one / "pictures").iterdir()) == ["ycb_1_1.png", "ycb_1_2.png"]
    assert done.stderr.count("photo 1/") == 2


def test_simulated_pictures_are_as_many_as_asked_and_the_same_again(one):
    found, done = ran(one, "photos", "--simulated", "--count", "2")
    assert done.stderr.count("photo 2000") == 2
    rows = {row["row"]: row for row in found["rows"]}
    assert rows["ycb, printed"]["there"] == rows["ycb, all"]["there"] >= 2
    assert rows["ycb, plain"]["there"] == 0
    sized = found["right by size"]
    assert sum(row["there"] for row in sized) == rows["ycb, all"]["there"]
    assert sum(row["right"] for row in sized) == rows["ycb, all"]["right"]
    assert {row["claim"] for row in found["reliability"]} <= {row["claim"] for row in found["claimed"]}
    again, _ = ran(one, "photos", "--simulated", "--count", "2")
    for row in (*found["rows"], *again["rows"]):
        del row["seconds"]
    assert found == again


def test_a_removed_type_comes_back_as_its_twin(tmp_path):
    found, done = ran(photos(tmp_path, {"cube": 1, "twin": 2}), "photos", "--without")
    assert done.returncode == 1
    assert found["rows"] == [{"row": "ycb", "left out": 2, "another in its place": 2}]
    assert [(row["photo"], row["without"], row["accepted"]) for row in found["in its place"]] == [
        ("1/1", "cube", "twin"),
        ("1/2", "cube", "twin"),
    ]
    assert min(row["overlap"] for row in found["in its place"]) > 0.9
    assert found["claims"][0]["value"] == 1.0


def test_of_one_type_nothing_is_left_that_could_come_back(one):
    found, done = ran(one, "photos", "--without")
    assert done.returncode == 0, done.stderr
    assert found["rows"] == [{"row": "ycb", "left out": 2, "another in its place": 0}]
    assert found["in its place"] == []


def test_a_knowledge_base_that_lacks_types_is_told_before_a_photo_is_looked_at(tmp_path, one):
    models(tmp_path / "photos/ycb/models", {"cube": 1, "twin": 2})
    shutil.copytree(one / "photos/ycb/test", tmp_path / "photos/ycb/test")
    shutil.copytree(one / "kbs", tmp_path / "kbs")
    done = plogic("bench", "photos", "--quick", "--kb", "kbs", cwd=tmp_path, PLOGIC_PHOTOS="photos")
    assert done.returncode == 1
    assert "photos/ycb/models: numbers 2; in a folder that does not exist it is learned anew" in done.stderr
    assert "photo 1/" not in done.stderr


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (("box", "--simulated"), "`box` has no such parts; `photos` has"),
        (("box", "--without"), "`box` has no such parts; `photos` has"),
        (("box", "--kb", "kbs"), "`box` learns its own; `photos` and `support` take one"),
        (("box", "--count", "3"), "`box` has no such pictures; `photos` and `support` have"),
        (("photos", "--count", "3"), "pictures are counted with --simulated"),
    ],
)
def test_options_of_photos_alone(options, said):
    done = plogic("bench", *options)
    assert done.returncode == 2
    assert said in done.stderr
