"""What the program is told of who stands on what: planes, tops of others, and chances that sum to what rests."""

from dataclasses import astuple
from types import SimpleNamespace

import numpy as np
import pytest
import trimesh
from synthetic import CAMERA

from geometry.bodies.resting import resting_faces
from geometry.frames import from_rotation_translation, look_at, turn_about
from kb.surfaces.surface import Surface
from plogic.cycle.planes import FREE, STACKED, Setting, abduced, bodies_of, supported
from plogic.cycle.stances import support_of_view
from plogic.cycle.state import Proposal, State
from plogic.cycle.support import leaning
from plogic.facts.hypothesis import Hypothesis

EYE = look_at(np.array([0.6, -0.5, 0.7]), np.zeros(3))
MESH = trimesh.creation.box((0.1, 0.08, 0.06))
SURFACE = Surface(np.array(MESH.vertices), np.array(MESH.faces))
BOX = SimpleNamespace(surface=SURFACE, name="box", opaque=True)
SETTING = Setting(
    {"box": SimpleNamespace(centre=np.zeros(3), resting=resting_faces(SURFACE.vertices))},
    CAMERA,
    SimpleNamespace(rests=0.9),
)


EXACT = np.diag([0.01, 0.01, 0.01, 0.002, 0.002, 0.002]) ** 2
"""Noise of a pose known to half a degree and 2 mm."""


def box(x, y, z=0.03, turn=0.0, **said):
    pose = EYE @ from_rotation_translation(turn_about([0.0, 0.0, 1.0], turn), (x, y, z))
    return Hypothesis(
        "box", pose, opaque=True, known_type=BOX, pixels=9.0, surplus=9.0, status="accepted", at=pose[None, :3, 3]
    ).told(**said)


STANDING = {"h1": box(0.0, 0.0), "h2": box(0.2, 0.1, turn=1.0), "h3": box(-0.15, 0.1, turn=2.0)}


def ways(support, name, on):
    return [s for s in support.stances if s.hypothesis == name and s.on == on]


def test_three_stand_on_the_first_plane_and_the_best_face_is_the_one_below():
    support = support_of_view(STANDING, SETTING)
    plane = support.planes[0]
    assert plane.name == "s1"
    assert np.array(plane.normal) @ EYE[:3, 2] > np.cos(np.radians(2.0))
    assert plane.offset == pytest.approx(EYE[:3, 2] @ EYE[:3, 3], rel=0.02)
    covariance = np.array(plane.covariance)
    np.testing.assert_allclose(covariance, covariance.T, atol=1e-12)
    assert (np.linalg.eigvalsh(covariance) > 0.0).all()
    best = [max(ways(support, name, "s1"), key=lambda s: s.log_ratio) for name in STANDING]
    assert min(s.log_ratio for s in best) > 5.0
    down = SETTING.models["box"].resting.down[[s.face for s in best]]
    np.testing.assert_allclose(down, [[0.0, 0.0, -1.0]] * 3, atol=1e-9)


def test_what_stands_on_another_may_do_either_and_chances_sum_to_no_more_than_what_rests():
    posed = {**STANDING, "h4": box(0.0, 0.0, 0.09, 0.3)}
    support = support_of_view(posed, SETTING)
    (on,) = {s.on for s in support.stances if s.hypothesis == "h4" and s.on.startswith("h")}
    assert on == "h1"
    assert max(s.log_ratio for s in ways(support, "h4", "h1")) > 5.0
    assert not [s for s in support.stances if s.hypothesis == "h1" and s.on.startswith("h")]
    chances = [
        sum(s.chance for s in support.stances if s.hypothesis == name and s.on in (plane.name, "h1"))
        for name in posed
        for plane in support.planes
    ]
    assert max(chances) <= 0.9 + 1e-9
    assert sum(s.chance for s in ways(support, "h4", "h1")) <= 0.9 * STACKED + 1e-9


def test_each_find_may_stand_by_chance_and_a_rival_is_no_other_find():
    posed = {**STANDING, "h4": box(0.1, -0.2, status="rival")}
    told = support_of_view(posed, SETTING).by_chance
    assert dict(told) == dict.fromkeys(STANDING, FREE.on)


def test_types_that_look_alike_speak_for_a_plane_as_one_where_one_of_them_is_accepted():
    kinds = [SimpleNamespace(surface=SURFACE, name=f"box{k}", opaque=True) for k in range(3)]
    setting = SETTING._replace(models=dict.fromkeys(("box", *(k.name for k in kinds)), SETTING.models["box"]))
    one, elsewhere = STANDING["h1"], STANDING["h2"].told(status="rival")
    alike = [replace_type(one, kind).told(status="rival") for kind in kinds]
    alone, together = (abduced([one], some, setting, 0.9)[1].probability for some in ([], alike))
    assert together == pytest.approx(alone, abs=0.01)
    apart = abduced([one], [replace_type(elsewhere, kinds[0])], setting, 0.9)[1].probability
    assert apart[0] > 0.9
    assert alone[0] < 0.5


def test_a_type_that_is_seen_in_the_place_of_what_is_accepted_alone_is_not_believed_besides():
    kinds = [SimpleNamespace(surface=SURFACE, name=f"box{k}", opaque=True) for k in range(2)]
    models = dict.fromkeys(("box", "box0", "box1"), SETTING.models["box"])
    proposed = replace_type(STANDING["h1"], kinds[0]), replace_type(STANDING["h2"], kinds[1])
    told: list[dict[str, float]] = []
    task = SimpleNamespace(
        kb=SETTING.kb,
        setting=SETTING._replace(models=models),
        searches=[(models, SimpleNamespace(reckon=told.append))],
    )
    proposals = tuple(Proposal(some.told(status="proposed")) for some in proposed)
    state = leaning(task, State(accepted=(STANDING["h1"],), proposals=proposals))
    (best,) = told
    assert best["box0"] == -np.inf
    assert {name: best[name] for name in ("box", "box1")} == {
        some.type: some.pixels + some.stance for some in (state.accepted[0], state.proposals[1].hypothesis)
    }


def test_a_rival_in_the_same_pose_is_told_as_much():
    support = support_of_view({**STANDING, "h4": STANDING["h3"].told(status="rival")}, SETTING)
    level = {name: {on: ratio for who, on, ratio in support.level if who == name} for name in ("h3", "h4")}
    stands = {name: [s[1:] for s in map(astuple, support.stances) if s[0] == name] for name in ("h3", "h4")}
    assert level["h3"] == level["h4"] != {}
    assert stands["h3"] == stands["h4"] != []


def test_what_was_looked_for_on_a_plane_stands_as_its_released_pose_does():
    there = box(0.3, 0.3)
    tipped = EYE @ from_rotation_translation(turn_about([1.0, 0.0, 0.0], 0.5), (0.3, 0.3, 0.2))
    held = support_of_view({**STANDING, "h4": there.told(released=there.camera_from_object)}, SETTING)
    left = support_of_view({**STANDING, "h4": there.told(released=tipped)}, SETTING)
    assert max(s.log_ratio for s in ways(held, "h4", "s1")) > 3.0
    assert ways(left, "h4", "s1") == []


def test_what_others_tell_that_are_not_in_delta_is_the_prior_of_the_planes():
    """With all of them in Δh the planes' posterior is that of all proposals, whoever of them the prior speaks for."""
    kinds = [SimpleNamespace(surface=SURFACE, name=f"box{k}", opaque=True) for k in range(3)]
    three = [replace_type(posed, kind) for posed, kind in zip(STANDING.values(), kinds, strict=True)]
    setting = SETTING._replace(models={kind.name: SETTING.models["box"] for kind in kinds})
    every = supported(bodies_of([], three, setting), 0.9)
    alone = support_of_view({"h1": three[0].told(status="rival")}, setting, every)
    both = support_of_view({"h1": three[0].told(status="rival"), "h2": three[1].told(status="rival")}, setting, every)
    assert alone.planes[0].normal == both.planes[0].normal
    assert alone.planes[0].prior > 0.9 > both.planes[0].prior
    assert support_of_view({}, setting, every).planes[0].prior == pytest.approx(every.probability[0])


def replace_type(posed, kind):
    return posed.told(type=kind.name, known_type=kind)


def test_where_nobody_said_that_things_rest_nothing_is_told():
    assert support_of_view(STANDING, replace_rests(None)) is None
    assert support_of_view(STANDING, SETTING._replace(models={})) is None
    assert support_of_view({}, SETTING).planes == ()


def replace_rests(rests):
    return SETTING._replace(kb=SimpleNamespace(rests=rests))


def test_a_rival_in_the_place_of_an_accepted_one_speaks_in_its_stead_and_not_beside_it():
    here, beside = STANDING["h1"].told(status="open"), box(0.3, -0.2, status="open")
    found = bodies_of([STANDING["h1"], STANDING["h2"]], [here, beside], SETTING)
    assert found.kind.tolist() == [0, 1, 0, 2]
    assert bodies_of([STANDING["h1"]], [], SETTING).kind.tolist() == [0]


def test_what_is_level_above_the_plane_on_nothing_known_is_likelier_where_it_is_free():
    posed = {**STANDING, "h4": box(0.3, -0.2, 0.2)}
    tipped = EYE @ from_rotation_translation(turn_about([1.0, 0.0, 0.0], 0.7), (-0.3, -0.3, 0.2))
    posed["h6"] = box(-0.3, -0.3).told(camera_from_object=tipped)
    told = {name: ratio for name, plane, ratio in support_of_view(posed, SETTING).level if plane == "s1"}
    assert 2.0 < told["h4"] < np.log(0.9 / FREE.level)
    assert told.get("h6", 0.0) < 0.1


def test_what_is_turned_more_than_meshes_are_wrong_is_free_and_a_little_is_not():
    """Those beside it stand exactly; it is turned about the middle of an edge that stays on the table."""
    worth = {}
    for tip in (0.1, 0.8):
        pose = EYE @ from_rotation_translation(
            turn_about([1.0, 0.0, 0.0], tip), (0.3, 0.3, 0.03 * np.cos(tip) + 0.04 * np.sin(tip))
        )
        support = support_of_view(
            {**STANDING, "h4": box(0.0, 0.0).told(camera_from_object=pose, spread=EXACT)}, SETTING
        )
        worth[tip] = sum(s.chance * np.exp(s.log_ratio) for s in ways(support, "h4", "s1"))
    assert worth[0.1] > 1.0
    assert worth[0.8] < 0.1


def test_each_way_to_stand_is_told_once():
    support = support_of_view(STANDING, SETTING)
    told = [(s.hypothesis, s.on, s.face) for s in support.stances]
    assert {name for name, _, _ in told} == set(STANDING)
    assert len(set(told)) == len(told)
