"""What was looked for on a plane is looked for again where the plane moved, or somebody stands before it since."""

from types import SimpleNamespace

import numpy as np
import pytest
from painted_cube import CORNER, cloud, pose_towards, seen, write_knowledge

from geometry.bodies.resting import Plane
from geometry.bodies.standing import Known
from kb.files.read import read_kb
from plogic.facts.hypothesis import Hypothesis
from plogic.match.learned import learned_standing
from plogic.match.learned.learned_pixels import Seen
from plogic.match.learned.learned_standing import Place, maybe_hidden, on_supports
from plogic.run.perceive import Perceiver

UP = np.array([0.0, -0.8, -0.6])
PLANE = Known(Plane(UP, 0.4), np.eye(3) * 1e-4)
LEFT, RIGHT = (pose_towards(CORNER, 0.8, 0.0, (side, 0.0)) for side in (-0.15, 0.15))
POSES = np.stack([LEFT, RIGHT])


@pytest.fixture(scope="module")
def index(tmp_path_factory):
    return Perceiver(read_kb(write_knowledge(tmp_path_factory.mktemp("kb"), {"cube": cloud(seen())}))).models["cube"]


@pytest.fixture
def asked(monkeypatch):
    """Each search on a plane: whether it was made anew, and how many poses of views were told; and planes searched."""
    rows, planes = [], []

    def seen_on(_index, _maps, _data, supports):
        planes.extend(supports)
        return [Seen(POSES, np.zeros(2)) for _ in supports]

    def resting(_index, _known, _left, _kb, _taken, *, before, seen, anew):
        rows.append((anew, len(seen.poses)))
        return []

    monkeypatch.setattr(learned_standing, "seen_on", seen_on)
    monkeypatch.setattr(learned_standing, "resting", resting)
    return rows, planes


def place(*accepted):
    return Place(SimpleNamespace(data=None, kb=None), None, accepted, np.zeros((0, 4)), None)


def body(index, pose):
    return Hypothesis("cube", pose, opaque=True, known_type=index.object_type)


def test_a_plane_is_searched_once_and_then_what_new_bodies_may_hide(index, asked):
    rows, planes = asked
    _, stood = on_supports(index, [PLANE], [], place())
    one = body(index, pose_towards(CORNER, 0.5, 0.0, (-0.09, 0.0)))
    for accepted in ((), (one,), (one,)):
        _, stood = on_supports(index, [PLANE], stood, place(*accepted))
    assert rows == [(True, 2), (False, 0), (False, 1), (False, 0)]
    assert len(planes) == len(stood) == 1


@pytest.mark.parametrize(("share", "anew"), [(0.001, False), (0.06, True)])
def test_a_plane_that_moved_is_searched_anew(index, asked, share, anew):
    _, stood = on_supports(index, [PLANE], [], place())
    moved = PLANE._replace(plane=Plane(UP, 0.4 * (1.0 + share)))
    _, stood = on_supports(index, [moved], stood, place())
    assert asked[0][1] == (anew, 2 if anew else 0)
    assert len(stood) == 1 + anew


def test_who_may_hide_is_before_and_not_aside(index):
    before, aside, behind = (
        pose_towards(CORNER, far, 0.0, (x, 0.0)) for far, x in ((0.5, -0.09), (0.5, 0.5), (2.0, -0.3))
    )
    told = [maybe_hidden(index, POSES, [body(index, pose)]).tolist() for pose in (before, aside, behind)]
    assert told == [[True, False], [False, False], [False, False]]
