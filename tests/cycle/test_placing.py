"""From posed hypotheses to the facts of space.

Up, who is on whom, what A4 says in numbers, and all of it back from the file.
"""

import json
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
import trimesh
from synthetic import CAMERA, belief_at, cycle_of, data, one_before_the_other, perceiver, scene, towers

from geometry.frames import inverse, look_at, transform_points
from kb.surfaces.surface import Surface
from plogic.cycle.delta import Options, delta_of
from plogic.cycle.placing import space_of_view, upward
from plogic.cycle.planes import Setting
from plogic.facts.interpretation import situation_of, text_of
from plogic.facts.spatial import exclusion_lines, exclusions
from plogic.run.document import document_of
from plogic.scene.asking.presence import presence
from plogic.scene.worlds.ranked_worlds import ranked_worlds

GRAVITY = SimpleNamespace(gravity=True)


def brick(*size):
    mesh = trimesh.creation.box(size)
    return Surface(np.array(mesh.vertices), np.array(mesh.faces))


SHEET = Surface(np.array([[-1.0, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]]), np.array([[0, 1, 2], [0, 2, 3]]))


def seen(surface, at, camera_from_world):
    """A stand-in for an accepted belief: where it is, and what of."""
    pose = camera_from_world.copy()
    pose[:3, 3] = transform_points(camera_from_world, np.array([at], float))[0]
    kind = SimpleNamespace(surface=surface, name="brick", opaque=True)
    middle = pose[:3, 3] if surface is None else transform_points(pose, surface.centre[None])[0]
    return SimpleNamespace(object_type=kind, type=kind.name, camera_from_object=pose, middle=middle, status="accepted")


def camera(eye=(0.2, -2.5, 1.6), up=(0.0, 0.0, 1.0), *, knows=True):
    camera_from_world = look_at(np.array(eye), np.array([0.0, 0.0, 0.2]), up)
    return (replace(CAMERA, world_from_camera=inverse(camera_from_world)) if knows else CAMERA), camera_from_world


STACK = {
    "table": (brick(1.0, 1.0, 0.4), (0, 0, 0.2)),
    "cup": (brick(0.1, 0.1, 0.1), (0.2, 0.1, 0.45)),
    "lamp": (brick(0.1, 0.1, 0.1), (-0.2, 0.1, 0.9)),
    "beside": (brick(0.1, 0.1, 0.1), (0.8, 0.1, 0.05)),
}


def space_of(view, things=STACK, overlaps=(), kb=GRAVITY):
    some, camera_from_world = view
    return space_of_view(
        {name: seen(*thing, camera_from_world) for name, thing in things.items()}, overlaps, some, kb, {}
    )


@pytest.mark.parametrize("up", [(0, 0, 1), (1, 0.3, 0.2), (0, 0.1, -1)])
@pytest.mark.parametrize("eye", [(0.2, -2.5, 1.6), (-1.5, 1.8, 0.9)])
def test_a_camera_that_is_turned_keeps_above_and_on(eye, up):
    space = space_of(camera(eye, up))
    assert space.up_from == "T_world_camera"
    assert set(space.above) == {("cup", "table"), ("lamp", "table")}
    assert space.on == (("cup", "table"),)
    gaps = {frozenset((x, y)): gap for x, y, gap in space.gaps}
    assert gaps[frozenset(("lamp", "table"))] == pytest.approx(0.45, abs=1e-5)
    assert gaps[frozenset(("cup", "table"))] == pytest.approx(0.0, abs=1e-5)


def test_without_a_known_up_nothing_is_above_anything():
    space = space_of(camera(knows=False))
    assert (space.up, space.up_from, space.above, space.on) == (None, "", (), ())
    assert upward([], Setting({}, CAMERA, SimpleNamespace(rests=0.9))) == (None, "")
    assert len(space.gaps) == 6


def test_a_plank_on_two_blocks_is_on_both():
    post = brick(0.2, 0.2, 0.3)
    space = space_of(
        camera(),
        {
            "plank": (brick(1.2, 0.2, 0.1), (0, 0, 0.35)),
            "left": (post, (-0.5, 0, 0.15)),
            "right": (post, (0.5, 0, 0.15)),
        },
    )
    assert space.on == ()
    assert space.on_both == (("plank", "left", "right"),)


def test_bodies_have_a_middle_a_nearest_place_and_a_view():
    cube = brick(0.2, 0.2, 0.2)
    things = {
        "near": (cube, (0, 0, 0.2)),
        "cut": (brick(0.2, 2.0, 4.0), (1.5, 1.0, 0.2)),
        "away": (cube, (9, 0, 0)),
        "point": (None, (0, 0, 1)),
    }
    bodies = {body.id: body for body in space_of(camera(), things).bodies}
    assert [bodies[name].view for name in things] == ["inside", "cut", "outside", "inside"]
    assert bodies["near"].middle[2] == pytest.approx(
        np.linalg.norm(np.subtract((0.2, -2.5, 1.6), (0, 0, 0.2))), abs=1e-5
    )
    assert 0.1 < bodies["near"].middle[2] - bodies["near"].nearest < 0.1 * 3**0.5
    assert bodies["point"].nearest == pytest.approx(np.linalg.norm(bodies["point"].middle), abs=1e-5)


def test_a_sheet_that_is_no_solid_is_stood_on_all_the_same():
    things = {"cup": STACK["cup"], "sheet": (SHEET, (0, 0, 0.4))}
    space = space_of(camera(), things, overlaps=())
    assert space.on == (("cup", "sheet"),)
    assert space_of(camera(), things, overlaps=[("cup", "sheet")]).shared == ()


def test_what_a4_keeps_apart_has_its_volume_and_depth():
    """A 10 cm cube 2 cm deep in the table: by hand 0.2 litres."""
    things = {"table": STACK["table"], "cup": (brick(0.1, 0.1, 0.1), (0.2, 0.1, 0.43))}
    space = space_of(camera(), things, overlaps=[("table", "cup")])
    (shared,) = space.shared
    assert shared.volume == pytest.approx(2e-4, rel=1e-4)
    assert shared.depth == pytest.approx((0.02, 0.02), abs=2e-6)
    assert space.gaps == ()


@pytest.fixture(scope="module")
def written():
    """Two towers, and a rival that stands in the place of one.

    The situation, and the document as it comes back from text.
    """
    rng = np.random.default_rng(7400)
    shot = scene(rng, one_before_the_other(rng))
    cycle = replace(cycle_of(shot.gamma), considered=(belief_at("t1", shot.poses["t2"], data(shot), "rival"),))
    delta = delta_of(cycle, data(shot), towers(), perceiver().dv, Options())
    ranking = ranked_worlds(delta.situation, 100)
    document = document_of(towers(), shot.gamma, delta, cycle.rejected, cycle.trace.document(), ranking, None)
    return delta.situation, json.loads(text_of(document))


def test_volume_and_depth_are_in_the_document_and_come_back(written):
    situation, document = written
    facts = [fact for fact in document["facts"] if fact["fact"] == "overlap"]
    assert facts
    for fact in facts:
        assert fact["volume"] > 0.0
        assert fact["depth"] > 0.02
    assert situation_of(document) == situation
    assert [row["args"] for row in exclusions(document)] == [fact["args"] for fact in facts]


def test_who_is_never_together_is_said_with_volume_and_depth(written):
    situation, document = written
    (line, *_) = exclusion_lines(document)
    assert "are never together (A4): they share" in line
    told = [text for h in document["hypotheses"] for text in h.get("apart", [])]
    assert len(told) >= 2
    x, y = document["facts"][0]["args"]
    lines = presence(situation, x, (x,))
    assert any(f"shares volume with (A4): {y} (" in text and "mm deep)" in text for text in lines)


def test_an_interpretation_without_space_is_read(written):
    """As those were that were written before."""
    _, document = written
    facts = [
        {key: value for key, value in fact.items() if key not in ("volume", "depth", "depth_interval")}
        for fact in document["facts"]
    ]
    old = {key: value for key, value in document.items() if key != "space"} | {"facts": facts}
    assert situation_of(old).space.bodies == ()
    assert exclusion_lines(old) == []
