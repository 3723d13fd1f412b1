"""The score of ``plogic bench many``, by hand: who is found, who is wrong, how far bodies reach into each other."""

from __future__ import annotations

import numpy as np
import pytest
from learned_cube import CUBE

from benchmarks.clutter.types import EASY, knowledge_base, made
from benchmarks.many.score import deepest, depth, verdict
from benchmarks.recognition.score import Found, Truth
from geometry.frames import from_rotation_translation, rotation_from_quat_xyzw

SIDE = 0.2


def cube(name):
    return made(name, CUBE, np.array([[0.1, 0, 0]]), np.eye(3)[None], ["a"], np.ones(1))


KB = knowledge_base([cube("one"), cube("two")], ("a",), EASY)
BOX = np.array([[0.0, 0.0], [639.0, 479.0]])


def at(x, z=2.0, degrees=0.0):
    half = np.radians(degrees) / 2
    return from_rotation_translation(rotation_from_quat_xyzw([0, 0, np.sin(half), np.cos(half)]), np.array([x, 0.0, z]))


def truth(kind, pose, fraction=1.0):
    return Truth(kind, pose, fraction, BOX, np.zeros(3), np.eye(4)[None])


def test_right_ones_are_found_once_each():
    truths = [truth("one", at(0.0)), truth("one", at(0.5)), truth("two", at(-0.5))]
    v = verdict([Found("one", at(0.5, degrees=3)), Found("one", at(0.0)), Found("one", at(0.001))], truths)
    assert [s.turned is not None for s in v.seen] == [True, True, False]
    assert v.seen[1].turned == pytest.approx(np.radians(3))
    assert (v.accepted, v.right, v.askew) == (3, 2, 0)


def test_who_is_turned_too_far_or_moved_too_far_or_of_another_type_is_wrong():
    truths = [truth("one", at(0.0)), truth("two", at(0.5))]
    v = verdict([Found("one", at(0.0, degrees=6)), Found("two", at(0.5, z=2.2)), Found("two", at(-0.5))], truths)
    assert all(s.turned is None for s in v.seen)
    assert (v.accepted, v.right, v.askew) == (3, 0, 2)


def test_who_is_little_visible_need_not_be_found_and_is_no_mistake():
    truths = [truth("one", at(0.0), 0.39), truth("two", at(0.5), 0.4)]
    found, missed = verdict([Found("one", at(0.0))], truths), verdict([], truths)
    assert [s.type for s in found.seen] == [s.type for s in missed.seen] == ["two"]
    assert (found.accepted, found.right, missed.accepted) == (1, 1, 0)


@pytest.mark.parametrize("inside", [0.0005, 0.003, 0.05])
def test_reach_is_how_far_two_cubes_stand_in_each_other(inside):
    one, two = KB.types
    assert depth(one, at(0.0), two, at(SIDE - inside)) == pytest.approx(inside, rel=1e-6)
    assert depth(two, at(SIDE - inside), one, at(0.0)) == pytest.approx(inside, rel=1e-6)
    assert depth(one, at(0.0), two, at(SIDE + inside)) == 0.0


def test_reach_of_several_is_the_greatest():
    found = [Found("one", at(0.0)), Found("two", at(SIDE - 0.001)), Found("one", at(2 * SIDE - 0.003))]
    assert deepest(found, KB) == pytest.approx(0.002)
    assert deepest(found[:1], KB) == 0.0
