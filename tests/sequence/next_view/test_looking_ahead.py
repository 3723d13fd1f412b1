"""Laws of the next view: equal worlds gain nothing, a hidden feature is looked for there, and names decide nothing."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from made_prospects import CAMERA, body, camera_at, prospect

from plogic.sequence.next_view.look import entropy, looked_ahead
from plogic.sequence.next_view.moves import Candidate, ring, standing, turned_to, within

WORLD = np.eye(4)
RING = [
    Candidate(f"at {a}°", camera_at(6 * np.cos(np.radians(a)), 6 * np.sin(np.radians(a)), 1.5))
    for a in range(0, 360, 45)
]


def _behind():
    """A tower that stands, or does not, behind another as seen from 0°."""
    return prospect([body("h1", "t1", 1.0, 0), body("h2", "t2", -1.2, 0)], [[1, 1], [1, 0]], [0.5, 0.5])


def _by_name(looks):
    return {look.candidate.name: look for look in looks}


def test_it_looks_where_what_is_hidden_would_be_seen():
    looks = looked_ahead(_behind(), CAMERA, RING)
    by_name = _by_name(looks)
    assert looks[0].gain.bits == pytest.approx(1.0, abs=0.01)
    assert by_name["at 0°"].gain.bits <= by_name["at 90°"].gain.bits
    assert (np.diff([look.gain.bits for look in looks]) <= 1e-9).all()
    assert any("h2" in r.text and "h2 is not there in the rest" in r.text for r in looks[0].why)


def test_no_gain_exceeds_what_is_uncertain_and_a_goal_never_exceeds_the_whole():
    one = prospect(
        [body("h1", "t1", 1, 0), body("h2", "t2", -1, 0, 0.4)], [[1, 1], [1, 0], [0, 1], [0, 0]], [0.4, 0.3, 0.2, 0.1]
    )
    answers = np.eye(2)[[0, 1, 0, 1]]
    whole, part = (_by_name(looked_ahead(one, CAMERA, RING, goal)) for goal in (None, answers))
    assert all(
        0.0 <= part[c.name].gain.bits <= whole[c.name].gain.bits + 1e-9 <= float(entropy(one.probability)) + 1e-6
        for c in RING
    )


def test_where_worlds_agree_or_nothing_is_seen_there_is_no_gain():
    same = prospect([body("h1", "t1", 0, 0)], [[1], [1]], [0.5, 0.5])
    assert {look.gain.bits for look in looked_ahead(same, CAMERA, RING)} == {0.0}
    away = [Candidate("away", camera_at(6, 0, target=np.array([12.0, 0, 2])))]
    (look,) = looked_ahead(_behind(), CAMERA, away)
    assert look.gain == (0.0, 0.0, 0)
    assert look.why == []


def test_the_same_object_under_two_names_tells_nothing():
    twins = prospect([body("h1", "t2", 0, 0), body("h2", "t2", 0, 0)], [[1, 0], [0, 1]], [0.5, 0.5], [("h1", "h2")])
    assert max(look.gain.bits for look in looked_ahead(twins, CAMERA, RING)) == 0.0


def test_renaming_and_reordering_worlds_and_hypotheses_changes_no_gain():
    one = _behind()
    turned = replace(
        one,
        bodies=tuple(replace(b, id=f"z{i}") for i, b in reversed(list(enumerate(one.bodies)))),
        present=one.present[::-1, ::-1].copy(),
        probability=one.probability[::-1].copy(),
    )
    before, after = (_by_name(looked_ahead(p, CAMERA, RING)) for p in (one, turned))
    assert [after[c.name].gain.bits for c in RING] == pytest.approx([before[c.name].gain.bits for c in RING], abs=1e-9)


def test_a_ring_keeps_height_and_distance_and_looks_at_the_middle():
    one, stand = _behind(), standing(WORLD)
    stand = replace(stand, reference_from_camera=camera_at(5, 1, 2))
    made, stated = ring(one, stand)
    eyes = np.array([c.reference_from_camera[:3, 3] for c in made])
    assert len(made) == stated["places"] - 1
    assert eyes[:, 2] == pytest.approx(2.0)
    assert np.linalg.norm(eyes[:, :2] - one.middle[:2], axis=1) == pytest.approx(
        np.linalg.norm([5, 1] - one.middle[:2])
    )
    uv = np.array([_centre(c, one) for c in made])
    assert uv == pytest.approx(np.tile([320.0, 240.0], (len(made), 1)), abs=1e-6)


def _centre(candidate, one):
    """Where the scene's middle is in a candidate's picture."""
    return CAMERA.project((np.linalg.inv(candidate.reference_from_camera) @ np.array([*one.middle, 1.0]))[:3])


def test_all_within_a_distance_are_within_it_outside_the_scene_and_above_its_ground():
    one = _behind()
    eye = camera_at(4, 0, 0.5)
    made, stated = within(one, replace(standing(WORLD), reference_from_camera=eye), 3.0)
    eyes = np.array([c.reference_from_camera[:3, 3] for c in made])
    moved = np.linalg.norm(eyes - eye[:3, 3], axis=1)
    assert stated["left_out"] > 0
    assert len(made) > 20
    assert moved.max() <= 3.0 + 1e-9
    assert (np.diff(moved) > -1e-9).all()
    assert eyes[:, 2].min() >= -1e-9
    assert np.linalg.norm(eyes - one.middle, axis=1).min() >= 1.5 * one.radius - 1e-9


def test_up_is_the_worlds_where_it_is_known_and_a_camera_may_look_straight_down():
    world_from_camera = camera_at(3, 0, 3)
    assert world_from_camera[:3, :3] @ standing(world_from_camera).up == pytest.approx([0, 0, 1])
    assert not standing(None).upright
    down = turned_to(np.array([0.0, 0, 5]), np.zeros(3), np.array([0.0, 0, 1]))
    assert down[:3, 2] == pytest.approx([0, 0, -1])


def test_where_nothing_may_be_there_is_nowhere_to_look():
    empty = prospect([], np.zeros((1, 0)), [1.0])
    assert ring(empty, standing(None))[0] == []
    assert within(empty, standing(None), 1.0)[0] == []
    assert looked_ahead(empty, CAMERA, RING)[0].gain.bits == 0.0
