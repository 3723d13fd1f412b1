"""Accepted hypotheses that do not hold release their data (§7), which are searched again without them."""

from __future__ import annotations

import numpy as np
import pytest
from synthetic import cycle_of, scene, side_by_side

from plogic.cycle import choosing
from plogic.cycle.state import same_hypothesis
from plogic.match.hand import hand_models
from plogic.match.judged.rivals import claims


@pytest.mark.parametrize("seed", [6300, 6301])
def test_the_data_of_one_that_had_to_go_are_searched_again(monkeypatch, seed):
    """Two towers that, so it is told, cannot be kept apart.

    The one of less worth goes, and its data are looked at once more.
    """
    rng = np.random.default_rng(seed)
    gamma = scene(rng, side_by_side(rng)).gamma
    both = cycle_of(gamma).accepted
    assert len(both) == 2
    stronger, weaker = sorted(both, key=lambda belief: -belief.worth)
    searched, generate, moved_apart = [], hand_models.generate, choosing.moved_apart

    def looked_at(index, left, *others, **options):
        searched.append(set(left.ids))
        return generate(index, left, *others, **options)

    def never_apart(posed, information, through=()):
        return moved_apart(posed, information)[0], [(0, 1)] if len(posed) > 1 else []

    monkeypatch.setattr(hand_models, "generate", looked_at)
    monkeypatch.setattr(choosing, "moved_apart", never_apart)
    found = cycle_of(gamma)
    assert [same_hypothesis(belief, stronger) for belief in found.accepted] == [True]
    released = {gamma.appearances[i].id for i in claims(weaker)}
    free = [released <= some for some in searched]
    assert free[0]
    assert not all(free), "claimed for a while"
    assert free[-1], "and looked at again"
    assert any("did not hold beside the others" in belief.why for belief in found.rejected), (
        "but not for the same again"
    )
    assert [belief.why for belief in found.rejected].count("shares volume with an accepted object (A4)") >= 1
