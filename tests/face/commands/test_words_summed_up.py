"""Visual words, of which a learned type has hundreds that nobody knows by name, are summed up on a terminal."""

from __future__ import annotations

import json

import cv2
import pytest
from console import document, good, plogic
from painted_cube import CAMERA, CORNER, cloud, picture, pose_towards, seen, write_knowledge

from kb.clouds.word_names import is_word
from kb.files.read import read_kb


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A learned cube, a picture of it, its interpretation, and that of a picture of something else."""
    folder = tmp_path_factory.mktemp("words")
    (folder / "kb").mkdir()
    write_knowledge(folder / "kb", {"cube": cloud(seen())})
    cv2.imwrite(str(folder / "seen.png"), picture([pose_towards(CORNER, 0.6)], seed=3))
    part = picture([pose_towards(CORNER, 0.6)], seed=3)
    part[:, 160:] = 128
    cv2.imwrite(str(folder / "part.png"), part)
    camera = {"width": CAMERA.width, "height": CAMERA.height, "K": CAMERA.K.tolist(), "dist": []}
    (folder / "camera.json").write_text(json.dumps(camera))
    for name in ("seen", "part"):
        good("perceive", f"{name}.png", "--camera", "camera.json", "--kb", "kb", "-o", f"{name}.json", cwd=folder)
    return folder


def test_the_names_of_words_are_known(folder):
    names = read_kb(folder / "kb").words.names
    assert len(names) > 20
    assert all(map(is_word, names))
    assert not any(map(is_word, ("corner", "sift", "w0001", "sift_words", "sift_w12")))


def test_measures_have_one_row_of_words_and_json_has_all(folder):
    text = good("measures", "seen.json", cwd=folder)
    told = document("measures", "seen.json", "--json", cwd=folder)
    words = [row["type"] for row in told["features"] if is_word(row["type"])]
    assert len(words) > 20
    (row,) = [line.split() for line in text.splitlines() if "visual words" in line]
    assert row[:3] == [str(len(words)), "visual", "words"]
    assert row[4] == "to"
    assert "sift_w" not in text
    table, _, legend = text.partition("\ncolumns")
    assert len(table.splitlines()) < 15
    assert legend


def test_a_missing_type_tells_how_many_words_were_detected_and_json_which(folder):
    text = good("explain", "part.json", "--missing", "cube", "--kb", "kb", cwd=folder)
    told = document("explain", "part.json", "--missing", "cube", "--kb", "kb", "--json", cwd=folder)
    detected, words = told["look_like_it"], told["visual_words"]
    assert all(map(is_word, detected))
    assert 10 < len(detected) < words
    (data,) = [line for line in text.splitlines() if line.startswith("data: ")]
    assert data == (
        f"data: {sum(detected.values())} of {told['appearances']} appearances look like features of it: "
        f"{len(detected)} of {words} visual words detected"
    )
    assert "sift_w" not in text


def test_what_is_missed_stands_beside_what_was_found_in_learning(folder):
    (seen,) = [h for h in document_in(folder / "seen.json") if h["status"] == "accepted"]
    rates = [f["learned_rate"] for f in seen["features"] if f["expected"] and f.get("stands_for", 1) == 1]
    assert all(0.0 <= rate <= 1.0 for rate in rates)
    found = sum(f["case"] == "A" and f.get("stands_for", 1) == 1 for f in seen["features"])
    told = " ".join(good("explain", "seen.json", "present(h1)", cwd=folder).split())
    assert f"{found} of {len(rates)} expected features are found; when its type was learned, {sum(rates):.0f}" in told
    page = good("report", "seen.json", "-o", "-", cwd=folder)
    assert "When its type was learned" in page
    part = [h for h in document_in(folder / "part.json") if h["status"] == "rejected"]
    assert all("learned_rate" in f for h in part for f in h["features"] if f.get("stands_for", 1) == 1)


def document_in(path):
    return json.loads(path.read_text())["hypotheses"]


def test_help_says_how_all_words_are_listed():
    assert "--json lists them" in " ".join(plogic("measures", "--help").stdout.split())
    assert "--json: by visual word" in " ".join(plogic("explain", "--help").stdout.split())
