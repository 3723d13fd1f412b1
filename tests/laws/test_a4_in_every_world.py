"""A4 in every world that is listed, not in the likeliest alone.

What is not told apart to a millimetre is not told together.
"""

from __future__ import annotations

from functools import cache
from itertools import combinations

import numpy as np
import pytest
from many_objects import camera, touching, twins

from benchmarks.many.score import depth
from plogic.cycle.delta import Options
from plogic.match.judged.rivals import DEEP
from plogic.run.perceive import Perceiver
from plogic.sequence.constancy.sight_lines import View
from plogic.sequence.views.panorama import Panorama, panorama_document


def deepest(document, kb, frame="T_camera_object"):
    """Metres, of all pairs that some listed world holds."""
    pairs = {pair for world in document["worlds"] for pair in combinations(world["present"], 2)}
    rows = {h["id"]: (kb.type(h["type"]), np.array(h[frame])) for h in document["hypotheses"]}
    return max((depth(*rows[x], *rows[y]) for x, y in pairs), default=0.0)


@cache
def with_twins():
    return Perceiver(twins())


@pytest.mark.parametrize("seed", [6019, 6044, 6054])
def test_in_no_listed_world_any_reaches_a_millimetre_into_another(seed):
    """Two that touch; each has a rival that looks the same, and is free to stand a little beside it."""
    document = with_twins()(touching(seed).gamma, Options(reading="posterior"))
    assert sum(h["status"] == "rival" for h in document["hypotheses"]) >= 2
    assert any(len(world["present"]) == 2 for world in document["worlds"])
    assert deepest(document, twins()) <= 1.01 * DEEP


@pytest.mark.parametrize("seed", [6018, 6019, 6024])
def test_nor_of_what_several_views_tell_together(seed):
    """The same from three sides, where the poses that fit all views best reach too deep.

    Unless they are moved, no world holds both.
    """
    panorama = Panorama(with_twins(), Options(reading="posterior"))
    views = [
        View(f"v{n}", touching(seed, degrees).gamma, camera(degrees)) for n, degrees in enumerate((0.0, 8.0, 16.0), 1)
    ]
    document = panorama_document(panorama, [(view.id, panorama.look(view)) for view in views])
    assert any(len(world["present"]) == 2 for world in document["worlds"])
    assert deepest(document, twins(), "T_world_object") <= 1.01 * DEEP
