"""How a pose settles: match, refine, match again; with a worth, the best on the way."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from plogic.match.judged.expectation import settled

LISTS = st.lists(st.integers(0, 4), min_size=1, max_size=8)


def run(matches, worths, rounds, end=99, *, worth=True, as_good=0.0):
    """Pose number i is matched as ``matches[i]`` and worth ``worths[i]``; from ``end`` on no pose is better.

    The pose, and those looked at.
    """
    looked = []

    def match(pose):
        looked.append(int(pose))
        return SimpleNamespace(number=int(pose), matches=np.array([matches[int(pose)]]))

    def better(posed):
        return None if posed.number >= min(end, len(matches) - 1) else posed.number + 1

    return settled(
        0, match, better, rounds, (lambda posed: worths[posed.number]) if worth else None, as_good
    ).number, looked


@settings(max_examples=100, deadline=None, derandomize=True)
@given(LISTS, st.data(), st.integers(0, 9), st.integers(0, 9))
def test_it_goes_on_until_nothing_changes_and_keeps_the_best(matches, draw, rounds, end):
    worths = draw.draw(st.lists(st.integers(0, 3), min_size=len(matches), max_size=len(matches)))
    last = next((i for i in range(1, len(matches)) if matches[i] == matches[i - 1]), len(matches) - 1)
    last = min(last, rounds, end)
    best = max(range(last + 1), key=lambda i: (worths[i], i))  # of equal ones the later
    assert run(matches, worths, rounds, end) == (best, list(range(last + 1)))
    assert run(matches, worths, rounds, end, worth=False) == (last, list(range(last + 1)))


def test_a_pose_that_fits_better_and_explains_less_is_not_kept():
    assert run([1, 2, 3], [5.0, 9.0, 4.0], 2)[0] == 1
    assert run([1, 2, 3], [5.0, 4.0, 3.0], 2)[0] == 0
    assert run([1, 2, 3], [5.0, 5.0, 5.0], 2)[0] == 2


@settings(max_examples=100, deadline=None, derandomize=True)
@given(st.lists(st.integers(0, 6), min_size=1, max_size=8), st.integers(0, 4), st.integers(0, 9))
def test_of_those_that_are_about_as_good_as_any_before_it_is_the_last(worths, as_good, rounds):
    last = min(rounds, len(worths) - 1)
    kept = max(i for i in range(last + 1) if worths[i] >= max(worths[: i + 1]) - as_good)
    assert run(list(range(len(worths))), worths, rounds, as_good=as_good)[0] == kept


def test_where_nothing_is_refined_nothing_is_weighed():
    weighed = []
    assert settled(np.eye(4), lambda _: "as it is", lambda _: None, 0, weighed.append) == "as it is"
    assert not weighed
