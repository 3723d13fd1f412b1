"""A list or an answer that a deadline cut short says so, and never passes for exact."""

from __future__ import annotations

import pytest
from situations import towers
from tangles import tangle

from plogic.base.errors import LimitError
from plogic.scene.asking import live, query
from plogic.scene.asking.live import LiveScene
from plogic.scene.worlds.ranked_worlds import ranked_worlds


@pytest.mark.parametrize("count", [22, 60])
def test_worlds_that_no_time_was_left_for_are_said_to_be_missing(count):
    ranking = ranked_worlds(tangle(count), 1000, seconds=0.0)
    assert len(ranking.worlds) < 1000
    assert (ranking.complete, ranking.exact) == (False, False)
    assert ranking.unlisted[1] > 0


def test_a_live_scene_says_so_too():
    ranking = LiveScene(tangle(40)).worlds(50, seconds=0.0)
    assert (len(ranking.worlds) < 50, ranking.complete) == (True, False)


def test_time_enough_gives_the_same_as_no_deadline():
    assert ranked_worlds(tangle(12), 20, seconds=3600.0) == ranked_worlds(tangle(12), 20)


def test_a_question_whose_grounding_runs_out_of_time_is_open(monkeypatch):
    def late(*_, **__):
        raise LimitError("the inference took longer")

    monkeypatch.setattr(live, "scene_answers", late)
    assert query.answers_until(towers("posterior"), "cause(A, H, F)", seconds=0.05) == ([], False)
    ((answer,), exact) = query.answers_until(towers("posterior"), "present(t1)", seconds=0.05)
    assert (answer.goal, answer.interval, exact) == ("present(t1)", (0.0, 1.0), False)
