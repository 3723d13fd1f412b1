"""``--marks``: pictures of learned types are not buried by marks, unless they are asked for."""

from __future__ import annotations

import cv2
import numpy as np
import pytest
from console import good, plogic
from painted_cube import CAMERA, CORNER, cloud, picture, pose_towards, seen, write_knowledge

from geometry.camera import camera_to_dict
from plogic import Interpretation


@pytest.fixture(scope="module")
def pictures(tmp_path_factory):
    """The picture of a learned cube with each choice, without one, and the interpretation."""
    import json

    folder = tmp_path_factory.mktemp("marks")
    (folder / "kb").mkdir()
    write_knowledge(folder / "kb", {"cube": cloud(seen())})
    cv2.imwrite(str(folder / "seen.png"), picture([pose_towards(CORNER, 0.6)], seed=3))
    (folder / "camera.json").write_text(json.dumps(camera_to_dict(CAMERA)))
    given = "perceive", "seen.png", "--camera", "camera.json", "--kb", "kb", "-o", "seen.json"
    for name, more in {"usual": (), **{m: ("--marks", m) for m in ("few", "all", "none")}}.items():
        good(*given, "--picture", f"{name}.png", *more, cwd=folder)
    return {name: cv2.imread(str(folder / f"{name}.png")) for name in ("usual", "few", "all", "none")} | {
        "scene": Interpretation.load(folder / "seen.json")
    }


def test_hundreds_of_marks_are_drawn_where_they_are_asked_for(pictures):
    assert np.array_equal(pictures["usual"], pictures["few"])
    assert np.array_equal(pictures["few"], pictures["none"])
    assert pictures["all"].shape[0] > pictures["few"].shape[0]
    height = 2 * CAMERA.height
    changed = (pictures["all"][:height] != pictures["few"][:height]).any(-1).sum()
    assert changed > 2000


def test_python_draws_the_same(pictures):
    for marks in ("few", "all"):
        assert np.array_equal(np.asarray(pictures["scene"].picture(marks)), pictures[marks])


def test_another_word_is_bad_usage():
    result = plogic("perceive", "seen.png", "--kb", "first", "--marks", "many")
    assert result.returncode == 2
    assert "'few', 'all', 'none'" in result.stderr
