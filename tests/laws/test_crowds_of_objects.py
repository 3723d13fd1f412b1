"""More than ten objects in one image, one behind another, several of a type.

Each is found, or there is little of it to see.
"""

from __future__ import annotations

import numpy as np
import pytest
from many_objects import accepted_rows, few_kb, few_types

from benchmarks.many.placing import CROWD
from benchmarks.many.scenes import scene
from benchmarks.many.score import deepest, verdict
from benchmarks.recognition.score import Found
from plogic.cycle.delta import Options
from plogic.match.judged.rivals import DEEP


@pytest.mark.parametrize(("seed", "number"), [(7004, (12, 12)), (7024, (12, 12)), (7006, CROWD)])
def test_of_more_than_ten_objects_nearly_all_are_found_and_none_is_made_up(seed, number):
    """Of twelve, and of eighteen."""
    posed = scene(few_kb(), seed, number)
    document = few_types()(posed.gamma, Options(reading="posterior"))
    found = [Found(h["type"], np.array(h["T_camera_object"])) for h in accepted_rows(document)]
    assert len(posed.truths) >= CROWD[0] > len({truth.type for truth in posed.truths}), "several of a type"
    assert min(truth.fraction for truth in posed.truths) < 0.5, "one behind another"
    told = verdict(found, posed.truths)
    assert len(told.seen) > 10, "at least 40 % visible"
    assert sum(seen.turned is not None for seen in told.seen) >= 0.9 * len(told.seen)
    assert told.right >= 0.9 * told.accepted
    assert deepest(found, few_kb()) <= 1.01 * DEEP
    assert any(feature["hidden_by"] for h in accepted_rows(document) for feature in h["features"])
