"""What was accepted first makes room, or gives way, for what explains more: Δi is the heaviest set that holds."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from planks import interleaved, planks

from geometry.frames import pose_error
from plogic.cycle import choosing, judging, perception
from plogic.match.judged.rivals import DEEP, contacts
from plogic.run.perceive import Perceiver

THIN = (0.006, 0.08, 1.0)
"""Half of a plank's thickness, m; its slope; noise of data, pixels."""
STUCK = (11, 13)
"""Seeds, the first two: as estimated, the third shares volume with one that was accepted before."""


@cache
def perceiver(thick):
    return Perceiver(planks(thick))


def accepted_in(seed, thick, slope, noise):
    """What is accepted, and which of the three true poses are, within 5° and 5 % of the distance."""
    gamma, poses = interleaved(seed, thick, slope, noise)
    accepted = [hypothesis for hypothesis, _ in perceiver(thick).accepted(gamma)]
    off = [[pose_error(h.camera_from_object, true, np.eye(4)[None]) for h in accepted] for true in poses]
    right = [
        any(turned < np.radians(5.0) and moved < 0.05 * true[2, 3] for turned, moved in row)
        for row, true in zip(off, poses, strict=True)
    ]
    return accepted, sum(right)


@pytest.mark.parametrize("seed", STUCK)
def test_one_that_shares_volume_as_estimated_is_accepted_where_all_can_be_moved_apart(seed, monkeypatch):
    accepted, right = accepted_in(seed, *THIN)
    assert (len(accepted), right) == (3, 3)
    assert all(c.reach.depth < 1.1 * DEEP for c in contacts(accepted, [h.camera_from_object for h in accepted]))
    monkeypatch.setattr(judging, "_touching", lambda *_: False)  # not at once, but when all others are known
    assert len(accepted_in(seed, *THIN)[0]) == 3
    monkeypatch.setattr(perception, "exchanged", lambda _, state: state)
    before, _ = accepted_in(seed, *THIN)
    assert len(before) == 2
    assert sum(h.worth for h in accepted) > sum(h.worth for h in before) + 20.0


THICK = (0.015, 0.13, 0.5)
"""The same of planks of 3 cm that no data of half a pixel mistake: their truth shares no volume."""
ASIDE = (1, (0.015, 0.145, 0.5))
"""A seed of which the nearest way out of a contact is the wrong one."""


def test_three_interleaved_planks_are_found_each_time():
    found = [accepted_in(seed, *THICK) for seed in range(5)]
    assert sum(right for _, right in found) >= 14
    assert all(len(accepted) == 3 for accepted, _ in found)


def test_two_leave_each_other_by_the_far_side_where_they_explain_more_so(monkeypatch):
    seed, which = ASIDE
    accepted, right = accepted_in(seed, *which)
    assert right == 3
    monkeypatch.setattr(choosing, "FALL", np.inf)
    nearest, fewer = accepted_in(seed, *which)
    assert (len(nearest), fewer) == (3, 2)
    assert sum(h.worth for h in accepted) > sum(h.worth for h in nearest) + 40.0
