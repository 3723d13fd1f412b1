"""Little data, or none, is no mistake: the answer is the empty world."""

from __future__ import annotations

import json

import pytest
from console import document, good
from refusals import ONE


@pytest.mark.parametrize(("appearances", "reading"), [([], "score"), ([ONE], "score"), ([ONE], "posterior")])
def test_little_data_is_an_answer_the_empty_world(appearances, reading, tmp_path, gamma):
    text = json.dumps({**gamma, "appearances": appearances})
    interpretation = good("perceive", "-", "--kb", "towers", "--reading", reading, stdin=text)
    assert json.loads(interpretation)["worlds"] == [
        {"probability": 1.0, "present": [], "causes": {a["id"]: "noise" for a in appearances}}
    ]
    found = document("worlds", "-", "--json", stdin=interpretation)
    assert [(w["probability"], w["present"]) for w in found["worlds"]] == [(1.0, [])]
    assert found["unlisted_mass"] == [0.0, 0.0]
    assert document("query", "-", "present(H)", "--json", stdin=interpretation)["answers"] == []


def test_every_command_answers_on_the_empty_world(gamma):
    interpretation = good("perceive", "-", "--kb", "towers", stdin=json.dumps({**gamma, "appearances": []}))
    assert "nothing known" in good("worlds", "-", stdin=interpretation)
    assert document("query", "-", "present(h1)", "--json", stdin=interpretation)["answers"][0]["probability"] == 0.0
    assert good("report", "-", "-o", "-", stdin=interpretation).lstrip().lower().startswith("<!doctype html>")


def test_an_image_that_shows_nothing_is_an_answer(tmp_path, demo):
    import cv2
    import numpy as np

    cv2.imwrite(str(tmp_path / "grey.png"), np.full((480, 640, 3), 128, np.uint8))
    found = json.loads(good("perceive", tmp_path / "grey.png", "--camera", demo / "camera.json", "--kb", "towers"))
    assert [(w["probability"], w["present"]) for w in found["worlds"]] == [(1.0, [])]
