"""Worlds let go by physics: boxes on a floor, in stacks, in the air; laws; and what the floor is."""

from __future__ import annotations

from copy import deepcopy
from dataclasses import replace

import numpy as np
import pytest
from boxes_document import CAMERA_FROM_WORLD, at, boxes_document
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from plogic.base.errors import InputError
from plogic.facts.interpretation import situation_of
from plogic.facts.stances import Stance, Support, SupportPlane
from plogic.run import settling
from plogic.run.settling import Stances, floor_of, settled, stances_in, verdict_of
from sensing.simulated.physics import has_physics

pytestmark = pytest.mark.skipif(not has_physics(), reason="pybullet is not installed")
FEW = settings(max_examples=12, deadline=None, derandomize=True, suppress_health_check=list(HealthCheck))
CRATE, CARTON = ("a", "crate", at(0, 0, 0)), ("b", "carton", at(0.02, 0.01, 0.1, 0.4))
"""A crate on the floor, and a carton on it."""


def verdicts(document, *args, **options):
    (world,) = settled(document, *args, **options)["worlds"]
    return {row["id"]: row["verdict"] for row in world["objects"]}


def rows_of(document, **options):
    (world,) = settled(document, **options)["worlds"]
    return {row["id"]: row for row in world["objects"]}


def test_a_stack_stands():
    rows = rows_of(boxes_document(CRATE, CARTON))
    assert {row["verdict"] for row in rows.values()} == {"stands"}
    assert max(row["moved"] for row in rows.values()) < 0.001
    assert all(row["still"] for row in rows.values())


def test_what_was_lifted_falls_as_far():
    (row,) = rows_of(boxes_document(("a", "crate", at(0, 0, 0.05)))).values()
    assert row["verdict"] == "falls"
    assert row["fell"] == pytest.approx(0.05, abs=0.001)


def test_the_upper_falls_where_the_lower_was_taken_away():
    document = boxes_document(CRATE, CARTON, ("c", "slab", at(0.4, 0, 0)))
    document["worlds"] = [{"probability": 0.9, "present": ["b", "c"]}]
    rows = rows_of(document)
    assert {name: row["verdict"] for name, row in rows.items()} == {"b": "falls", "c": "stands"}
    assert rows["b"]["fell"] == pytest.approx(0.1, abs=0.002)


def test_what_leans_beyond_its_foot_tips():
    assert verdicts(boxes_document(("b", "carton", at(0, 0, 0.02, lean=0.6)))) == {"b": "tips"}


def test_what_reaches_far_into_another_is_pushed_out():
    """Each by half of the 8 cm; and all of it out of what is held."""
    document = boxes_document(CRATE, ("b", "carton", at(0.06, 0, 0.0)))
    rows = rows_of(document)
    assert {row["verdict"] for row in rows.values()} == {"pushed out"}
    assert [row["pushed"] for row in rows.values()] == pytest.approx([0.04, 0.04], abs=0.002)
    assert max(row["slid"] for row in rows.values()) < 0.001
    document["facts"] = [{"fact": "foot", "args": ["a"], "low": 0.1, "high": 0.2}]
    rows = rows_of(document)
    assert {name: row["verdict"] for name, row in rows.items()} == {"a": "held", "b": "pushed out"}
    assert rows["b"]["pushed"] == pytest.approx(0.08, abs=0.002)


def test_what_is_free_is_held_unless_it_is_dropped():
    """The document's facts say who floats: nothing holds b, which is 40 cm up."""
    document = boxes_document(CRATE, ("b", "carton", at(0, 0, 0.4)))
    document["facts"] = [
        {"fact": "foot", "args": ["a"], "low": -0.005, "high": 0.005},
        {"fact": "foot", "args": ["b"], "low": 0.395, "high": 0.405},
        {"fact": "rests_on", "args": ["a", "ground"]},
    ]
    rows = rows_of(document)
    assert {name: row["verdict"] for name, row in rows.items()} == {"a": "stands", "b": "held"}
    assert rows["b"]["moved"] == 0.0
    assert verdicts(document, drop=True) == {"a": "stands", "b": "falls"}


def test_how_a_world_stands_is_by_its_likeliest_plane_and_stances():
    """Of both s2 is what they stand on, though b rather floats than stands there."""
    situation = situation_of(boxes_document(CRATE, CARTON))
    spread = ((1e-4, 0, 0), (0, 1e-4, 0), (0, 0, 1e-4))
    planes = tuple(SupportPlane(name, (0, -1, 0), -0.5, spread, prior) for name, prior in (("s1", 0.2), ("s2", 0.7)))
    stances = Stance("a", "s2", 0, 0.9, 5.0), Stance("b", "s2", 0, 0.9, -9.0), Stance("b", "s1", 0, 0.9, 2.0)
    situation = replace(situation, reading="posterior", support=Support(0.9, 0.1, planes, stances))
    assert stances_in(situation, ["a", "b"]) == Stances("s2", frozenset("b"), {"a": "s2"})
    assert stances_in(replace(situation, support=None), ["a", "b"]) == Stances("", frozenset())


def test_where_a_world_rather_stands_on_no_plane_it_is_let_go_on_one_and_who_is_free_there_is_held():
    """That nothing says where things stand is likelier than s1: on s1 a stands and b is free, all the same."""
    situation = situation_of(boxes_document(CRATE, CARTON))
    spread = ((1e-4, 0, 0), (0, 1e-4, 0), (0, 0, 1e-4))
    planes = (SupportPlane("s1", (0, -1, 0), -0.5, spread, 0.001),)
    support = Support(0.9, 0.9, planes, (Stance("a", "s1", 0, 0.9, 3.0), Stance("b", "s1", 0, 0.9, -9.0)))
    situation = replace(situation, reading="posterior", support=support)
    assert stances_in(situation, ["a", "b"]) == Stances("none", frozenset())
    assert stances_in(situation, ["a", "b"], "s1") == Stances("s1", frozenset("b"), {"a": "s1"})


def standing_document(*boxes, **on):
    """The boxes, on the floor as a support plane; ``on``: what each that is told of stands on."""
    document = boxes_document(*boxes, ground=None)
    up = CAMERA_FROM_WORLD[:3, 2]
    plane = {"normal": up.tolist(), "offset": float(up @ CAMERA_FROM_WORLD[:3, 3])}
    spread = (1e-4 * np.eye(3)).tolist()
    row = {"name": "s1", "plane": plane, "covariance": spread, "prior": 0.9, "probability": 0.9, "standing": {}}
    document |= {"support_planes": [row], "resting": {"rests": 0.9, "none": 0.1}}
    for h in document["hypotheses"]:
        if h["id"] in on:
            h["stances"] = [{"on": on[h["id"]], "face": 0, "chance": 0.9, "log_ratio": 5.0}]
    return document


def nearer(pose, metres):
    """The pose so much nearer to the camera, that looks at it from beside and above."""
    middle = (CAMERA_FROM_WORLD @ pose)[:3, 3]
    pose = pose.copy()
    pose[:3, 3] -= metres * CAMERA_FROM_WORLD[:3, :3].T @ middle / np.linalg.norm(middle)
    return pose


UPPER = at(0.09, -0.06, 0.1)
"""On the crate, its middle 1 cm and 1.5 cm from the edges that are towards the camera."""


def test_what_is_said_to_stand_is_put_down_along_the_sight_and_flush_and_that_is_told():
    """Too near by what its depth is off, the carton is over the edge, and in the air: it stood on the crate."""
    carton = ("b", "carton", nearer(UPPER, 0.03) @ at(0, 0, 0, 0, 0.03))
    assert verdicts(standing_document(CRATE, carton, a="s1")) == {"a": "stands", "b": "held"}
    assert verdicts(standing_document(CRATE, carton, a="s1"), drop=True) == {"a": "stands", "b": "falls"}
    rows = rows_of(standing_document(CRATE, carton, a="s1", b="a"))
    assert {name: row["verdict"] for name, row in rows.items()} == {"a": "stands", "b": "stands"}
    assert rows["a"]["seated"] == rows["a"]["turned"] == 0.0
    assert 0.02 < rows["b"]["seated"] < 0.03
    assert rows["b"]["turned"] == pytest.approx(0.03, abs=0.001)
    assert rows["b"]["pushed"] < 0.001


@pytest.mark.parametrize(
    ("carton", "verdict"),
    [
        (at(0.13, 0, 0.1), "falls"),  # its middle is beyond the edge by 3 cm, at the right height
        (at(0.02, 0.01, 0.15), "falls"),  # too high by more than it may be off
        (at(0.02, 0.01, 0.1, 0, 0.3), "tips"),  # leaning by more than it may: it is not turned, and rocks back
    ],
)
def test_what_is_said_to_stand_and_cannot_falls(carton, verdict):
    rows = rows_of(standing_document(CRATE, ("b", "carton", carton), a="s1", b="a"))
    assert {name: row["verdict"] for name, row in rows.items()} == {"a": "stands", "b": verdict}


def test_what_is_held_holds_others():
    document = boxes_document(("a", "slab", at(0, 0, 0.3)), ("b", "carton", at(0.05, 0, 0.34)))
    feet = {"a": 0.3, "b": 0.34}
    document["facts"] = [{"fact": "foot", "args": [k], "low": z - 0.005, "high": z + 0.005} for k, z in feet.items()]
    document["facts"].append({"fact": "rests_on", "args": ["b", "a"]})
    assert verdicts(document) == {"a": "held", "b": "stands"}
    assert verdicts(document, drop=True) == {"a": "falls", "b": "falls"}


@FEW
@given(st.integers(0, 9999))
def test_poses_that_are_off_as_found_ones_are_stand_all_the_same(seed):
    """A stack and its neighbour, each off by up to 8 mm and 2 degrees: nothing is thrown about."""
    rng = np.random.default_rng(seed)
    boxes = [CRATE, CARTON, ("c", "crate", at(0.2, 0.02, 0, 0.1)), ("d", "slab", at(0.1, -0.3, 0))]
    off = [at(*rng.uniform(-0.008, 0.008, 3), *rng.uniform(-0.035, 0.035, 2)) for _ in boxes]
    rows = rows_of(boxes_document(*((n, k, pose @ move) for (n, k, pose), move in zip(boxes, off, strict=True))))
    assert {row["verdict"] for row in rows.values()} == {"stands"}


def drawn(seed):
    rng = np.random.default_rng(seed)
    kinds = rng.choice(["crate", "carton", "slab"], 4)
    poses = [at(*rng.uniform(-0.2, 0.2, 2), rng.uniform(0.0, 0.2), *rng.uniform(-0.6, 0.6, 2)) for _ in kinds]
    return boxes_document(
        *((f"h{i}", str(kind), pose) for i, (kind, pose) in enumerate(zip(kinds, poses, strict=True)))
    )


@FEW
@given(st.integers(0, 9999))
def test_what_has_settled_is_settled(seed):
    document = drawn(seed)
    rows = rows_of(document)
    for row in document["hypotheses"]:
        row["T_camera_object"] = rows[row["id"]]["T_camera_object"]
    again = rows_of(document)
    quiet = [name for name, row in rows.items() if row["still"]]
    if len(quiet) == len(rows):
        assert {again[name]["verdict"] for name in quiet} == {"stands"}
        assert max(again[name]["moved"] for name in quiet) < 0.004


@FEW
@given(st.integers(0, 9999), st.permutations(range(4)))
def test_the_order_of_hypotheses_changes_nothing(seed, order):
    document = drawn(seed)
    other = deepcopy(document)
    other["hypotheses"] = [document["hypotheses"][i] for i in order]
    other["worlds"][0]["present"] = [row["id"] for row in other["hypotheses"]]
    assert rows_of(other) == rows_of(document)


def test_several_worlds_are_each_let_go_by_themselves():
    document = boxes_document(CRATE, CARTON)
    document["worlds"].append({"probability": 0.1, "present": ["b"]})
    assert [world["present"] for world in settled(document, 5)["worlds"]] == [["a", "b"], ["b"]]
    assert [world["objects"][-1]["verdict"] for world in settled(document, 5)["worlds"]] == ["stands", "falls"]


def floor(document):
    (world,) = settled(document)["worlds"]
    return world["floor"]


def test_the_floor_is_the_likeliest_support_plane_before_anything_else():
    document = boxes_document(CRATE, ground=-1.0)
    up = CAMERA_FROM_WORLD[:3, 2]
    plane = {"normal": up.tolist(), "offset": float(up @ CAMERA_FROM_WORLD[:3, 3])}
    other = {"normal": [0.0, -1.0, 0.0], "offset": -3.0}
    document["support_planes"] = [
        {"name": "s1", "plane": other, "probability": 0.1},
        {"name": "s2", "plane": plane, "probability": 0.8},
    ]
    found = floor(document)
    assert found["told_by"] == "support plane s2"
    assert found["plane"]["normal"] == pytest.approx(plane["normal"], abs=1e-6)
    assert found["plane"]["offset"] == pytest.approx(plane["offset"], abs=1e-6)
    assert verdicts(document) == {"a": "stands"}
    assert floor_of(document, [], "s1").told_by == "support plane s1, P 0.10"  # it is rather no plane: that is said


def test_else_it_is_the_ground_and_else_where_the_lowest_stands():
    assert floor(boxes_document(CRATE))["told_by"] == "ground"
    lifted = ("c", "carton", at(0.4, 0, 0.3))
    document = boxes_document(CRATE, lifted, ground=None)
    assert floor(document)["told_by"] == "lowest object a"
    assert verdicts(document) == {"a": "stands", "c": "falls"}


def test_else_it_is_what_the_objects_agree_on_or_nobody_knows():
    document = boxes_document(CRATE, ("c", "slab", at(0.4, 0, 0)), ground=None)
    del document["camera"]["T_world_camera"]
    assert floor(document)["told_by"] == "what a, c stand on"
    assert set(verdicts(document).values()) == {"stands"}
    document["worlds"] = [{"probability": 1.0, "present": ["a"]}]
    with pytest.raises(InputError, match="nobody knows which way is up"):
        settled(document)


def test_what_has_no_body_is_left_out():
    document = boxes_document(CRATE, CARTON)
    del document["assets"]["meshes"]["carton"]
    (world,) = settled(document)["worlds"]
    assert [row["id"] for row in world["objects"]] == ["a"]
    assert world["left_out"] == [{"id": "b", "why": "the interpretation carries no mesh of its type"}]


@pytest.mark.parametrize("gone", ["crate", "carton"])
def test_what_has_no_body_is_put_on_nothing_and_carries_nobody(gone):
    document = standing_document(CRATE, ("b", "carton", at(0.02, 0.01, 0.1)), a="s1", b="a")
    del document["assets"]["meshes"][gone]
    (row,) = rows_of(document).values()
    assert (row["id"], row["seated"], row["turned"]) == ("b" if gone == "crate" else "a", 0.0, 0.0)


def test_without_physics_it_is_said(monkeypatch):
    monkeypatch.setattr(settling, "has_physics", lambda: False)
    with pytest.raises(InputError, match="nothing can be let go, for pybullet is not installed: pip install"):
        settled(boxes_document(CRATE))


@pytest.mark.parametrize(
    ("moves", "verdict"),
    [
        ({}, "stands"),
        ({"slid": 0.06}, "slides"),
        ({"slid": 0.06, "tilted": 0.5}, "tips"),
        ({"slid": 0.06, "tilted": 0.5, "fell": 0.035}, "falls"),
        ({"slid": 0.06, "tilted": 0.5, "fell": 0.06, "pushed": 0.06}, "pushed out"),
        ({"slid": 0.04, "tilted": 0.25, "fell": 0.025, "pushed": 0.04}, "stands"),
    ],
)
def test_verdicts_are_by_the_first_way_that_is_too_far(moves, verdict):
    assert verdict_of({"pushed": 0.0, "fell": 0.0, "tilted": 0.0, "slid": 0.0, "allowed": 0.05} | moves) == verdict
