"""A4 to a millimetre: what reaches into another is moved apart, as little as its matches allow, and nothing else is."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from synthetic import CAMERA, cycle_of, data, posed_at, scene, stand, towers

from geometry.bodies.depth import penetration
from geometry.frames import pose_error
from plogic.match.judged.evidence import pose_information
from plogic.match.judged.rivals import DEEP, contacts, moved_apart, solid_of


def pushed(seed, deep, names=("t1", "t2")):
    """Two towers side by side, the second pushed sideways until it reaches ``deep`` m into the first.

    Matched where they truly are.
    """
    rng = np.random.default_rng(seed)
    poses = stand(rng, 5.0, across=0.8, deep=0.0)
    of = data(scene(rng, poses))
    posed = [posed_at(name, poses[name], of) for name in names]
    one, other = (poses[name] for name in ("t1", "t2"))
    way = (one[:3, 3] - other[:3, 3]) / np.linalg.norm(one[:3, 3] - other[:3, 3])
    low, high = 0.0, 2.0
    for _ in range(30):
        there = other.copy()
        there[:3, 3] += 0.5 * (low + high) * way
        found = reached(
            [replace(some, camera_from_object=there if some.object_type.name == "t2" else one) for some in posed]
        )
        low, high = (0.5 * (low + high), high) if found < deep else (low, 0.5 * (low + high))
    return [posed_at(name, there if name == "t2" else one, of) for name in names]


def touching(poses):
    """The same, the second moved sideways until the two only just touch."""
    one, other = (
        posed_at(name, pose, data(scene(np.random.default_rng(0), {name: pose}))) for name, pose in poses.items()
    )
    step = 0.002 * (one.camera_from_object[:3, 3] - other.camera_from_object[:3, 3])
    there = other.camera_from_object.copy()
    while not contacts([one, other], [one.camera_from_object, there]):
        there[:3, 3] += step
    while contacts([one, other], [one.camera_from_object, there]):
        there[:3, 3] -= 0.05 * step
    return dict(zip(poses, (one.camera_from_object, there), strict=True))


def apart(posed, still=0):
    return moved_apart(posed, lambda k: pose_information(posed[k], CAMERA, towers()), still)


def reached(posed):
    return max(
        (contact.reach.depth for contact in contacts(posed, [some.camera_from_object for some in posed])), default=0.0
    )


@settings(max_examples=12, deadline=None, derandomize=True)
@given(st.integers(0, 999), st.floats(0.003, 0.04))
def test_what_reaches_into_another_is_moved_out(seed, deep):
    posed = pushed(seed, deep)
    poses, left = apart(posed)
    assert left == []
    assert reached([replace(some, camera_from_object=pose) for some, pose in zip(posed, poses, strict=True)]) <= DEEP
    for some, pose in zip(posed, poses, strict=True):
        turned, moved = pose_error(pose, some.camera_from_object)
        assert moved < 3.0 * deep + DEEP, "as far as it must"
        assert turned < 0.1


@pytest.mark.parametrize("seed", range(6))
def test_what_was_moved_out_is_out_by_the_definition_of_depth_too(seed):
    """Which knows nothing of least widths."""
    posed = pushed(seed, 0.004 * (1 + seed))
    poses, _ = apart(posed)
    (a, T_a), (b, T_b) = ((solid_of(some.object_type.surface), pose) for some, pose in zip(posed, poses, strict=True))
    found = penetration(a, T_a, b, T_b)
    assert found is None or found.high <= DEEP


def test_the_one_that_nobody_saw_makes_way():
    """A move costs what the matches say: without matches it costs nearly nothing."""
    first, second = pushed(5, 0.02)
    unseen = replace(second, matches=np.full(len(second.matches), -1))
    poses, _ = apart([first, unseen])
    stayed, went = (
        np.linalg.norm(pose[:3, 3] - some.camera_from_object[:3, 3])
        for pose, some in zip(poses, (first, second), strict=True)
    )
    assert stayed < 0.1 * went


@pytest.mark.parametrize("seed", range(4))
def test_what_is_to_stand_still_does(seed):
    posed = pushed(seed, 0.01)
    poses, left = apart(posed, still=1)
    assert left == []
    assert poses[0] is posed[0].camera_from_object
    assert poses[1] is not posed[1].camera_from_object
    assert reached([replace(some, camera_from_object=pose) for some, pose in zip(posed, poses, strict=True)]) <= DEEP
    assert apart(posed, still=2) == ([some.camera_from_object for some in posed], [])


def test_in_another_order_the_same_poses():
    one, other = pushed(6, 0.02), pushed(6, 0.02, ("t2", "t1"))
    there, back = apart(one)[0], apart(other)[0]
    assert np.allclose(there[0], back[1], atol=1e-6)
    assert np.allclose(there[1], back[0], atol=1e-6)


def test_what_reaches_nowhere_keeps_its_very_pose():
    rng = np.random.default_rng(7)
    poses = stand(rng, 5.0, across=0.8, deep=0.0)
    of = data(scene(rng, poses))
    posed = [posed_at(name, pose, of) for name, pose in poses.items()]
    moved, left = apart(posed)
    assert left == []
    assert all(pose is some.camera_from_object for pose, some in zip(moved, posed, strict=True))
    assert apart([]) == ([], [])


def test_bodies_one_inside_the_other_are_told():
    """No small move ends that: the pair is told, so that one of the two can go."""
    one = pushed(8, 0.01)[0]
    assert apart([one, one])[1] == [(0, 1)]


def test_whatever_is_accepted_satisfies_a4_to_a_millimetre():
    """Towers that touch, seen with noise: single poses may reach into each other.

    Accepted ones do not, and some were moved.
    """
    moved = both = 0
    for seed in range(9200, 9206):
        rng = np.random.default_rng(seed)
        poses = stand(rng, 5.0, across=0.4, deep=0.0)
        cycle = cycle_of(scene(rng, touching(poses), clutter=5).gamma)
        assert reached(list(cycle.accepted)) <= DEEP
        both += len(cycle.accepted) == 2
        moved += any(step["event"] == "move" for step in cycle.trace.document())
    assert both >= 4
    assert moved >= 1
