"""A sequence of which a view was not searched to the end.

Wherever that is, it is told, and nothing is proved of what stands in the world.
"""

from __future__ import annotations

import numpy as np
import pytest
from interrupted import LATE, stopped_after
from synthetic import one_before_the_other, perceiver, scene

from plogic.cycle.delta import Options
from plogic.sequence.constancy.sight_lines import View
from plogic.sequence.next_view.reading import of_last_view
from plogic.sequence.views.panorama import Panorama, panorama_document


def seen_twice(looks):
    """The panorama of two views from one place; the second is stopped after so many looks at the time."""
    rng = np.random.default_rng(6201)
    gamma = scene(rng, one_before_the_other(rng), clutter=6).gamma
    panorama = Panorama(perceiver(), Options(reading="posterior", end=LATE))
    views = [panorama.look(View("v1", gamma, np.eye(4)))]
    with stopped_after(looks):
        views.append(panorama.look(View("v2", gamma, np.eye(4))))
    return panorama_document(panorama, [("a", views[0]), ("b", views[1])])


@pytest.mark.parametrize("looks", [0, 1])
def test_a_view_with_no_time_for_what_is_remembered(looks):
    document = seen_twice(looks)
    assert [view["interpretation"].get("stopped") for view in document["views"]] == [None, "search"]
    assert (document["unfinished"], document["stopped"], document["unlisted_mass"]) == (True, "search", [0.0, 1.0])
    rows = [row for key in ("objects", "hypotheses", "worlds") for row in document[key]]
    assert len(rows) > 2
    assert all(row["interval"] == [0.0, 1.0] for row in rows)
    assert of_last_view(document)["stopped"] == "search"


def test_time_enough_marks_nothing():
    document = seen_twice(10**9)
    assert not {"unfinished", "stopped"} & set(document)
    assert not any("interval" in row for key in ("objects", "hypotheses", "worlds") for row in document[key])
    assert "stopped" not in of_last_view(document)
