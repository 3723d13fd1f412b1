"""What a goal is about: leaving out the rest changes no probability."""

from __future__ import annotations

from dataclasses import replace

import pytest
from hypothesis import assume, given, settings
from situations import random_situations, towers

from plogic.base.errors import InconsistentError
from plogic.scene.asking.relevant import relevant
from plogic.scene.worlds.ranked_worlds import ranked_worlds


def marginals(situation):
    try:
        return ranked_worlds(situation, 1).marginals
    except InconsistentError:
        return None


@settings(derandomize=True, deadline=None, max_examples=60)
@given(random_situations())
def test_a_hypothesis_is_as_probable_in_its_part_as_in_the_whole(situation):
    whole = marginals(situation)
    assume(whole is not None)
    alone = {
        h.id: ranked_worlds(relevant(situation, [f"present({h.id})"]), 1).marginals[h.id] for h in situation.hypotheses
    }
    assert alone == pytest.approx(whole, abs=1e-9)


def test_what_hangs_together_is_kept_and_what_does_not_is_left_out():
    scene = towers()
    alone = replace(scene.hypotheses[0], id="far", group="far", features=())
    wide = replace(scene, hypotheses=(*scene.hypotheses, alone))
    assert {h.id for h in relevant(wide, ["present(t2), \\+ present(t1)"]).hypotheses} == {
        h.id for h in scene.hypotheses
    }
    assert {h.id for h in relevant(wide, ["present(far)"]).hypotheses} == {"far"}


@pytest.mark.parametrize(
    "goal",
    ["present(H)", "left_of(t1, X)", "my_rule(t1)", "findall(H, present(H), L)", "not ( well", "present(nobody)"],
)
def test_a_goal_that_may_be_about_others_keeps_the_whole(goal):
    scene = towers()
    wide = replace(
        scene, hypotheses=(*scene.hypotheses, replace(scene.hypotheses[0], id="far", group="far", features=()))
    )
    assert relevant(wide, [goal]) is wide
