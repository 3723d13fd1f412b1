"""A type that reaches behind the camera: what of it has no place in the image is told, drawn and asked, too."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import pytest
from console import good, plogic

ROOT = Path(__file__).parents[3]
GAMMA = ROOT / "examples" / "first_gamma.json"
FAR = """\
  - feature: far
    type: sticker
    at: [0, 0, 9]
    appearances:
      - {type: sticker, lobe: {axis: [0, 0, 1], half_angle: 75 deg, range: [0.2 m, 5 m]}}
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """What is perceived of a mast of 9 m, from above its foot."""
    folder = tmp_path_factory.mktemp("mast")
    shutil.copytree(ROOT / "kb" / "first", folder / "kb")
    description = folder / "kb" / "objects" / "box" / "object.yaml"
    description.write_text(description.read_text().rstrip("\n") + "\n" + FAR)
    good("perceive", GAMMA, "--kb", folder / "kb", "-o", folder / "i.json", "--picture", folder / "seen.png")
    return folder


def test_its_place_is_null(folder):
    (accepted,) = (h for h in json.loads((folder / "i.json").read_text())["hypotheses"] if h["status"] == "accepted")
    (far,) = (f for f in accepted["features"] if f["id"] == "far")
    assert (far["uv"], far["in_image"], far["match"], far["case"]) == (None, False, None, None)


@pytest.mark.parametrize(
    "command", [("worlds",), ("query", "expected(h1, far)"), ("explain", "present(h1)"), ("measures",)]
)
def test_the_rest_is_asked_as_ever(command, folder):
    good(command[0], folder / "i.json", *command[1:])


def test_a_page_is_made_of_it(folder):
    good("report", folder / "i.json", "-o", folder / "page.html")


@pytest.mark.parametrize(("key", "value"), [("in_image", True), ("match", "a1"), ("case", "C")])
def test_a_feature_without_a_place_is_nowhere_in_the_image(key, value, folder):
    document = json.loads((folder / "i.json").read_text())
    (f,) = (f for h in document["hypotheses"] for f in h["features"] if f["id"] == "far")
    f[key] = value
    (folder / "wrong.json").write_text(json.dumps(document))
    done = plogic("worlds", folder / "wrong.json")
    assert done.returncode == 1
    assert "uv: is null, of a feature that is in the image, or matched" in done.stderr
