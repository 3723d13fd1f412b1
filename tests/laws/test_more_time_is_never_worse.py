"""Anytime (``plogic.anytime``): wherever the cycle is stopped, it answers with a stable Δi, and more time never makes its weight less."""

from __future__ import annotations

import math
from functools import cache
from itertools import pairwise

import numpy as np
import pytest
from interrupted import LATE, stopped_after
from many_objects import accepted_rows, few_types, scene_of_seed
from synthetic import one_before_the_other, perceiver, scene

from plogic.delta import Options
from plogic.interpretation import situation_of, text_of
from plogic.worlds import ranked_worlds

STOPS = 10
"""Looks at the time at which one scene is stopped, the first and the last ones among them."""


@cache
def towers_of(seed):
    rng = np.random.default_rng(seed)
    return scene(rng, one_before_the_other(rng), clutter=6).gamma


SCENES = {"towers": lambda: (perceiver(), towers_of(6201)), "many objects": lambda: (few_types(), scene_of_seed(5031).gamma)}


def weight(document):
    return math.fsum(h["log_likelihood_ratio"] for h in accepted_rows(document))


def interrupted(perceiver, gamma, looks, reading="posterior"):
    with stopped_after(looks) as clock:
        return perceiver(gamma, Options(reading=reading, end=LATE)), clock.count


@cache
def whole(name, reading="posterior"):
    """The interpretation when there is time enough, and how many looks at the time it takes."""
    return interrupted(*SCENES[name](), 10**9, reading)


@pytest.mark.parametrize("name", SCENES)
def test_more_time_never_makes_the_weight_less(name):
    (finished, looks), weights, reasons = whole(name), [], set()
    for n in sorted({int(n) for n in np.linspace(0, looks - 1, STOPS)}):
        document, taken = interrupted(*SCENES[name](), n)
        assert document["unfinished"] is True
        assert document["trace"][-1]["event"] == "deadline"
        assert taken == n + 1, "the first look that is late ends it"
        weights.append(weight(document))
        reasons |= {h["why"] for h in document["hypotheses"] if h["status"] == "rejected"}
    weights.append(weight(finished))
    assert all(less <= more + 1e-9 for less, more in pairwise(weights))
    assert weights[0] == 0.0
    assert len({round(w, 6) for w in weights}) > 2, "it grows step by step"
    assert "the deadline came first" in reasons, "what there was no time to tell says so"


@pytest.mark.parametrize("name", SCENES)
def test_time_enough_gives_the_bytes_of_no_deadline(name):
    perceiver, gamma = SCENES[name]()
    assert "unfinished" not in whole(name)[0]
    assert text_of(whole(name)[0]) == text_of(perceiver(gamma, Options(reading="posterior")))


@pytest.mark.parametrize("reading", ["score", "posterior"])
def test_probabilities_are_intervals_that_contain_those_of_what_was_found(reading):
    found = []
    for share in (0.4, 0.9):
        document, _ = interrupted(*SCENES["many objects"](), int(share * whole("many objects")[1]), reading)
        exact = ranked_worlds(situation_of(document), 1000)
        every = {world.present: world.probability for world in exact.worlds}
        found += [(h["interval"], h["probability"], exact.marginals[h["id"]]) for h in document["hypotheses"] if h["status"] != "rejected"]
        found += [(world["interval"], world["probability"], every[tuple(world["present"])]) for world in document["worlds"]]
    assert len(found) > 4
    for (low, high), told, true in found:
        assert low <= told <= high
        assert low - 1e-9 <= true <= high + 1e-9
