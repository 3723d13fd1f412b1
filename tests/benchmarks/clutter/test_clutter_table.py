"""What ``plogic bench clutter`` prints: answers judged by hand, rows and claims from what was counted."""

from __future__ import annotations

import numpy as np
import pytest

from benchmarks.clutter.scenes import Case
from benchmarks.clutter.table import OURS, Outcome, claims, judged, rows
from benchmarks.clutter.types import EASY, HARD
from benchmarks.recognition.score import Found, Truth
from geometry.frames import from_rotation_translation

SMALL, LARGE, DIM = Case(EASY, 100, 300), Case(EASY, 1000, 300), Case(HARD, 100, 300)


def pose(degrees=0.0, z=1.0):
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    return from_rotation_translation(np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]]), (0, 0, z))


TRUTH = Truth("cup", pose(), 1.0, np.array([(300, 200), (340, 280)]), np.zeros(3))


@pytest.mark.parametrize(
    ("found", "identity", "right", "false"),
    [
        ([], False, False, False),
        ([Found("cup", pose())], True, True, False),
        ([Found("cup", pose(4.9, 1.049))], True, True, False),
        ([Found("cup", pose(5.1))], True, False, False),
        ([Found("cup", pose(z=1.051))], True, False, False),
        ([Found("can", pose())], False, False, True),
        ([Found("can", pose()), Found("cup", pose())], False, False, True),
        ([Found("cup", pose()), Found("can", pose())], True, True, True),
        ([Found("cup", pose(90)), Found("cup", pose())], True, False, True),
    ],
)
def test_the_best_of_what_was_accepted_is_judged(found, identity, right, false):
    assert judged(found, TRUTH) == (identity, right, false)


def outcome(case=SMALL, who=OURS, *, learned=False, own=20, identity=True, pose=True, false=False, seconds=0.5):
    return Outcome(case, who, learned, own, identity, pose, false, seconds)


def good(case=SMALL, seconds=0.5):
    return [outcome(case, learned=n % 3 == 0, seconds=seconds) for n in range(9)]


def unmet(outcomes):
    return [claim.claim for claim in claims(outcomes) if not claim.met]


def test_a_row_counts_what_its_side_did():
    outcomes = [
        outcome(seconds=1.0), outcome(seconds=2.0, pose=False), outcome(seconds=6.0, identity=False, pose=False, false=True, learned=True, own=8),
        outcome(who="peer", seconds=9.0, learned=True),
    ]  # fmt: skip
    mine, peer = rows(outcomes, {SMALL: 3.5})
    assert (mine["case"], mine["types"], mine["looks"], mine["who"], mine["trials"], mine["own"]) == (
        "easy",
        100,
        300,
        OURS,
        3,
        16.0,
    )
    assert (mine["identity"], mine["pose"], mine["learned"], mine["false"]) == (0.6667, 0.3333, "0/1", 1)
    assert (mine["median s"], mine["p95 s"], mine["build"]) == (2.0, 5.6, 3.5)
    assert (peer["who"], peer["trials"], peer["learned"], peer["build"]) == ("peer", 1, "1/1", "")


def test_every_claim_can_be_met():
    assert unmet([*good(), *good(LARGE, 1.5), *good(DIM)]) == []
    assert len(claims([*good(), *good(LARGE), *good(DIM)])) == 7


@pytest.mark.parametrize(
    ("worse", "said"),
    [
        (
            [outcome(identity=False, pose=False, learned=True)],
            ["easy, 100 types, 300 appearance types: identity right", "identity and pose right"],
        ),
        ([outcome(pose=False, learned=True)], ["easy, 100 types, 300 appearance types: identity and pose right"]),
        ([outcome(seconds=1.1)] * 20, ["seconds, median", "share of the trials"]),
        ([outcome(LARGE, seconds=1.6, learned=True)] * 20, ["median seconds over those of 100 types"]),
        ([outcome(LARGE, identity=False, pose=False, learned=True)] * 20, []),
        ([outcome(DIM, pose=False, learned=True)] * 2, []),
        ([outcome(DIM, pose=False, learned=True)] * 4, ["hard, 100 types, 300 appearance types: pose right"]),
        (
            [outcome(DIM, identity=False, pose=False, learned=True)],
            ["hard, 100 types, 300 appearance types: identity right"],
        ),
        ([outcome(who="peer", identity=False, pose=False, seconds=99.0)] * 9, []),
    ],
)
def test_a_claim_that_is_missed_is_not_met(worse, said):
    missed = unmet([*good(), *good(LARGE), *good(DIM), *worse])
    assert len(missed) == len(said)
    for name in said:
        assert any(name in claim for claim in missed)


def test_without_learned_types_the_claim_of_a_third_is_not_met():
    assert unmet([outcome() for _ in range(9)]) == ["share of the trials with clouds learned from meshes"]
