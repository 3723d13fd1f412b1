"""``plogic perceive --generator``: who proposes poses changes, and all else stays."""

import json
from pathlib import Path

import numpy as np
import pytest
from console import good, plogic

EXAMPLES = Path(__file__).parents[3] / "examples"
ASKED = "perceive", EXAMPLES / "first_gamma.json", "--kb", "first"


def accepted(*more):
    document = json.loads(good(*ASKED, *more))
    return [(h["type"], h["T_camera_object"]) for h in document["hypotheses"] if h["status"] == "accepted"]


def test_softposit_finds_the_box_that_the_fast_search_finds():
    ((name, pose),) = accepted()
    ((other, plain),) = accepted("--generator", "softposit")
    assert name == other == "box"
    assert np.array(plain) == pytest.approx(np.array(pose), abs=0.01)
    assert accepted("--generator", "index") == [(name, pose)]


def test_an_unknown_generator_is_bad_usage():
    done = plogic(*ASKED, "--generator", "magic")
    assert done.returncode == 2
    assert "'index', 'quadruples', 'softposit'" in done.stderr
