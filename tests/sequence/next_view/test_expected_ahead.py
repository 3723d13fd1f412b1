"""A world's expectations from elsewhere are those of perception there (D7), of bodies alone and one behind another."""

from __future__ import annotations

import numpy as np
import pytest
from made_prospects import CAMERA, body, camera_at, prospect, towers

from geometry.frames import inverse
from plogic.match.gamma.data import data_of
from plogic.match.judged.expectation import hidden_by, pose_of
from plogic.sequence.next_view.expected import sightings

VIEWS = [camera_at(5, 0), camera_at(-4, 3), camera_at(1, -6, 4), camera_at(0.5, 4, 0.3)]


def _posed(one, view):
    return pose_of(
        towers().type(one.cloud.name), inverse(view) @ one.reference_from_object, data_of([], CAMERA), towers()
    )


def _expected(found, one, number, world):
    """The features that a world leads to expect of one body."""
    mask = np.zeros(len(one.cloud.features), bool)
    mask[found.feature[(found.body == number) & world]] = True
    return mask


@pytest.mark.parametrize("view", VIEWS)
@pytest.mark.parametrize("turned", [0.3, 2.0])
def test_it_is_what_perception_expects(view, turned):
    bodies = [body("h1", "t1", 0.6, 0.2, turned), body("h2", "t2", -0.8, -0.1, -turned)]
    found = sightings(prospect(bodies, [[1, 1], [1, 0]], [0.5, 0.5]), CAMERA, view)
    both, alone = found.expected(np.array([[True, True], [True, False]]))
    posed = [_posed(one, view) for one in bodies]
    assert posed[0].candidate.sum() > 5
    assert np.array_equal(_expected(found, bodies[0], 0, alone), posed[0].candidate)
    assert np.array_equal(_expected(found, bodies[0], 0, both), posed[0].candidate & ~hidden_by(posed[0], posed[1]))
    assert np.array_equal(_expected(found, bodies[1], 1, both), posed[1].candidate & ~hidden_by(posed[1], posed[0]))


def test_one_tower_hides_the_other_unless_they_are_rivals_or_it_is_transparent():
    near, far = body("h1", "t1", 1.5, 0), body("h2", "t2", -1.5, 0)
    glass = body("h1", "t1", 1.5, 0, opaque=False)
    there = np.array([[True, True]])

    def seen_of_far(bodies, rivals=()):
        found = sightings(prospect(bodies, [[1, 1]], [1.0], rivals), CAMERA, camera_at(6, 0, 1.5))
        return int(found.expected(there)[0][found.body == 1].sum())

    assert seen_of_far([near, far]) < seen_of_far([glass, far])
    assert seen_of_far([near, far], [("h1", "h2")]) == seen_of_far([glass, far])


def test_nothing_is_expected_of_what_is_not_there_or_out_of_view():
    found = sightings(prospect([body("h1", "t1", 0, 0)], [[0], [1]], [0.5, 0.5]), CAMERA, VIEWS[0])
    assert not found.expected(np.array([[False]])).any()
    assert found.expected(np.array([[True]])).any()
    away = sightings(
        prospect([body("h1", "t1", 0, 0)], [[1]], [1.0]), CAMERA, camera_at(5, 0, target=np.array([9.0, 0, 2]))
    )
    assert len(away.body) == 0
