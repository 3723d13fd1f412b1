"""What a picture lacks is told first, where nothing was found."""

import cv2
import numpy as np
import pytest

from plogic.run.carried import image_asset
from plogic.run.silence.picture import lacking

PICTURE = np.random.default_rng(0).integers(0, 200, (60, 80, 3)).astype(np.uint8)
GREY = cv2.cvtColor(cv2.cvtColor(PICTURE, cv2.COLOR_BGR2GRAY), cv2.COLOR_GRAY2BGR)


@pytest.mark.parametrize(
    ("picture", "words"),
    [
        (PICTURE, []),
        (GREY, ["has no colours"]),
        (PICTURE // 6, ["is dark: 99 of 100 pixels are at most "]),
        (GREY // 6, ["has no colours", "is dark"]),
        (np.clip(PICTURE * 8.0, 0, 255).astype(np.uint8), ["is over-exposed: "]),
        (None, []),
    ],
    ids=["fine", "grey", "dark", "grey and dark", "over-exposed", "none"],
)
def test_each_lack_is_a_line(picture, words):
    lines = list(lacking({"assets": image_asset(picture)}, learned=True))
    assert len(lines) == len(words)
    assert all(word in line for word, line in zip(words, lines, strict=True))


def test_what_was_modelled_by_hand_needs_light_and_no_colours():
    (line,) = lacking({"assets": image_asset(GREY // 6)}, learned=False)
    assert "is dark" in line
    assert "learned" not in line


def test_grey_is_grey_as_jpeg_too(monkeypatch):
    monkeypatch.setattr("plogic.run.carried.LARGEST_PNG", 0)
    assert image_asset(GREY)["image"]["media_type"] == "image/jpeg"
    (line,) = lacking({"assets": image_asset(GREY)}, learned=True)
    assert "has no colours" in line
