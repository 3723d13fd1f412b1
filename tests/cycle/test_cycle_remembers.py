"""What the cycle remembers of a pose from round to round is what it would find again."""

import numpy as np
import pytest
from synthetic import cycle_of, one_before_the_other, scene, side_by_side

from plogic.cycle import choosing, judging


def told(cycle):
    """All that a cycle says, bit for bit."""
    return [
        [
            (
                b.object_type.name,
                b.camera_from_object.tobytes(),
                b.matches.tolist(),
                b.worth,
                b.ev,
                b.why,
            )
            for b in some
        ]
        for some in (cycle.accepted, cycle.considered, cycle.rejected)
    ]


@pytest.mark.parametrize("stand", [one_before_the_other, side_by_side])
@pytest.mark.parametrize("seed", [6100, 6101, 6102])
def test_a_cycle_that_remembers_nothing_comes_to_the_same(monkeypatch, stand, seed):
    rng = np.random.default_rng(seed)
    gamma = scene(rng, stand(rng)).gamma
    with_memory = told(cycle_of(gamma))
    for module in (judging, choosing):
        monkeypatch.setattr(module, "apart_on_screen", lambda *_: False)
    assert told(cycle_of(gamma)) == with_memory
