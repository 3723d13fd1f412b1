"""The hit rates that Δh states of learned hypotheses that others hide in part: as the cycle judged them (§8)."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from learned_scenes import gamma_at, one_sided, pose_before, ready
from made_meshes import CORNERS, box_triangles

from geometry.frames import from_rotation_translation, transform_points
from kb.surfaces.surface import Surface
from plogic.cycle.delta import Options, delta_of
from plogic.cycle.judging import judge
from plogic.cycle.state import Cycle, Task, Trace
from plogic.match.judged.evidence import LEAST_HIT, MOST_HIT, as_counted, clarity
from plogic.match.judged.rivals import hidden_among
from plogic.match.kinds import Models
from plogic.match.learned.learned_models import LearnedModels


def behind_a_plate(hidden, status="accepted", *, opaque=True, away=0.4):
    """A learned thing of which a plate before it hides ``hidden`` of 30 features and the others are detected.

    The task, what is accepted, the thing as it is judged beside the others, and Δh of the two.
    """
    mine, pose = ready(one_sided(1, 30)), pose_before(np.random.default_rng(5))
    at = transform_points(pose, mine.cloud.at)
    slope = np.sort(at[:, 0] / at[:, 2])
    edge = away * np.concatenate([[slope[0] - 1], (slope[1:] + slope[:-1]) / 2, [slope[-1] + 0.01]])[hidden]
    wall = ready(one_sided(2, 12), Surface(CORNERS * (2.0, 2.0, 0.001), box_triangles()), name="plate")
    plate = replace(wall.kind, opaque=opaque)
    kb = replace(mine.kb, types=(mine.kind, plate))
    of = gamma_at(mine.cloud, np.flatnonzero(at[:, 0] / at[:, 2] * away > edge), pose)
    place = from_rotation_translation(np.eye(3), [edge - 2.0, -1.0, away])
    verdict = {"worth": 1.0, "surplus": 1.0, "ev": 0.5, "ev_reconsidered": 0.5}
    beside = replace(
        wall.index.settle(place, of, kb, rounds=0), known_type=plate, opaque=plate.opaque, status=status, **verdict
    )
    dv = dict.fromkeys(kb.words.names, 0.5)
    task = Task(of, kb, Models({"learned": LearnedModels({"thing": mine.index, "plate": wall.index})}), dv)
    accepted = [mine.index.settle(pose, of, kb, rounds=0).told(status="accepted", **verdict)]
    accepted += [beside] if status == "accepted" else []
    belief = judge(task, accepted[1:], accepted[0], 0).told(status="accepted")
    return task, accepted, belief, delta_of(Cycle((belief, beside), (), (), (), Trace()), of, kb, dv, Options())


def rates_of(belief, task, mask=None):
    """(F,) the hit rates of the thing, each as much as it is counted, where ``mask`` (F,) is hidden."""
    return as_counted(belief, task.data, task.kb, mask)[0]


def told_rates(delta):
    """(F,) the hit rates that Δh states of the thing; NaN for a feature that it sums up with others."""
    rates = np.full(30, np.nan)
    for fact in delta.situation.hypotheses[0].features:
        if fact.stands_for == 1:
            rates[int(fact.id.removeprefix("f")) - 1] = fact.hit_rate
    return rates


@settings(max_examples=10, deadline=None, derandomize=True)
@given(st.integers(0, 30))
def test_what_is_half_hidden_is_as_clear_to_the_program_as_to_the_cycle(hidden):
    task, accepted, belief, delta = behind_a_plate(hidden)
    mask = belief.hidden
    np.testing.assert_array_equal(mask, hidden_among(belief, accepted[1:]))
    assert hidden <= mask.sum() <= hidden + 1  # the plate is 1 mm thick: one may stand in the shadow of its side
    rates = told_rates(delta)
    told = ~np.isnan(rates)
    assert told.sum() >= 30 - mask.sum()
    np.testing.assert_array_equal(rates[told], rates_of(belief, task, mask)[told])
    whole = np.clip(belief.hit * clarity(belief, mask), LEAST_HIT, MOST_HIT)
    np.testing.assert_array_equal(rates[told], (1.0 - (1.0 - whole) ** belief.counted)[told])


@pytest.mark.parametrize(
    ("changed", "hides"),
    [({}, True), ({"status": "rival"}, False), ({"opaque": False}, False)],
    ids=["accepted and opaque", "not accepted", "not opaque"],
)
def test_only_accepted_opaque_objects_take_features_out_of_clarity(changed, hides):
    task, _, belief, delta = behind_a_plate(20, **changed)
    mask = behind_a_plate(20)[2].hidden
    assert clarity(belief, mask) > 1.5 * clarity(belief)
    rates = told_rates(delta)
    told = ~np.isnan(rates)
    assert told.any()
    np.testing.assert_array_equal(rates[told], rates_of(belief, task, mask if hides else None)[told])


def test_what_cannot_be_there_together_takes_nothing_out_of_clarity():
    """A rival in the accepted one's place: where the rival is, the accepted one is not, and hides nothing of it."""
    task, accepted, belief, _ = behind_a_plate(20)
    plate = accepted[1]
    body = Surface((CORNERS - 0.5) * (0.5, 0.5, 1.6), box_triangles())
    within = replace(belief, known_type=replace(belief.object_type, surface=body))
    delta = delta_of(
        Cycle((plate,), (replace(within, status="rival"),), (), (), Trace()),
        task.data,
        task.kb,
        task.dv,
        Options(),
    )
    assert delta.situation.overlaps == {("h1", "h2")}
    facts = [fact for fact in delta.situation.hypotheses[1].features if fact.stands_for == 1]
    assert any(fact.hidden_by for fact in facts)
    rates = rates_of(within, task)
    assert [fact.hit_rate for fact in facts] == [rates[int(fact.id.removeprefix("f")) - 1] for fact in facts]
