"""Anytime (``plogic.cycle.choosing``): more time never makes the weight of Δi less.

Wherever the cycle is stopped, it answers with a stable Δi.
"""

from __future__ import annotations

import math
from bisect import bisect_left
from functools import cache
from itertools import pairwise

import numpy as np
import pytest
from interrupted import LATE, stopped_after
from many_objects import accepted_rows, few_of_seed, few_types
from stopping import stopped
from synthetic import one_before_the_other, perceiver, scene

from plogic.base.clock import Stopwatch
from plogic.cycle.delta import Options
from plogic.facts.interpretation import situation_of, text_of
from plogic.match.judged.rivals import same_place
from plogic.scene.worlds.ranked_worlds import ranked_worlds

STOPS = 9
"""Looks at the time at which one scene is stopped, the first and the last ones among them."""
READINGS = "score", "posterior"


@cache
def towers_of(seed):
    rng = np.random.default_rng(seed)
    return scene(rng, one_before_the_other(rng), clutter=6).gamma


SCENES = {f"towers {seed}": (perceiver, lambda seed=seed: towers_of(seed)) for seed in (6201, 6202, 6203)} | {
    f"objects {seed}": (few_types, lambda seed=seed: few_of_seed(seed).gamma) for seed in (5031, 5033)
}
"""Scenes of several seeds: what perceives them, and their Γ."""
TWO = "towers 6201", "objects 5031"
ENOUGH = 10**9
"""Looks at the time that no cycle takes."""


@cache
def cycle_of(name, looks):
    """Γ as arrays and the cycle, where it is stopped after so many looks at the time, and how many it took."""
    with stopped_after(looks) as clock:
        data, cycle = SCENES[name][0]().cycle(SCENES[name][1](), Options(end=LATE), Stopwatch())
    return data, cycle, clock.count


def interrupted(name, looks, reading="posterior"):
    """The interpretation by that cycle, which is the same in both readings."""
    data, cycle, _ = cycle_of(name, looks)
    options = Options(reading=reading, end=LATE)
    return SCENES[name][0]().document(SCENES[name][1](), data, cycle, options, None, Stopwatch())


def stops(name, number):
    """So many numbers of looks at the time, from none to all but the last."""
    return sorted({int(n) for n in np.linspace(0, cycle_of(name, ENOUGH)[2] - 1, number)})


@cache
def finished(name, reading):
    """The interpretation of one of them when there is time enough, and all its worlds."""
    document = interrupted(name, ENOUGH, reading)
    return document, ranked_worlds(situation_of(document), 10**6)


def weight(document):
    return math.fsum(h["log_likelihood_ratio"] for h in accepted_rows(document))


@pytest.mark.parametrize("name", TWO)
def test_more_time_never_makes_the_weight_less(name):
    weights, reasons = [], set()
    for n in stops(name, STOPS):
        document = interrupted(name, n)
        assert document["unfinished"] is True
        assert document["trace"][-1]["event"] == "deadline"
        assert cycle_of(name, n)[2] == n + 1, "the first look that is late ends it"
        weights.append(weight(document))
        reasons |= {h["why"] for h in document["hypotheses"] if h["status"] == "rejected"}
    weights.append(weight(finished(name, "posterior")[0]))
    assert all(less <= more + 1e-9 for less, more in pairwise(weights))
    assert weights[0] == 0.0
    least = bisect_left(range(cycle_of(name, ENOUGH)[2]), 1, key=lambda n: int(weight(interrupted(name, n)) > 0.0))
    assert 0.0 < weight(interrupted(name, least)) < weights[-1] - 10.0, "it grows step by step"
    assert "the deadline came first" in reasons, "what there was no time to tell says so"


@pytest.mark.parametrize("name", TWO)
def test_time_enough_gives_the_bytes_of_no_deadline(name):
    whole = finished(name, "posterior")[0]
    assert "unfinished" not in whole
    assert text_of(whole) == text_of(SCENES[name][0]()(SCENES[name][1](), Options(reading="posterior")))


@pytest.mark.parametrize("reading", READINGS)
@pytest.mark.parametrize("name", TWO)
def test_a_deadline_that_is_given_to_the_whole_is_kept_as_by_its_parts(name, reading):
    """A cycle that is stopped and then written down in a reading, as below, is what one call gives."""
    (n,) = stops(name, 3)[1:2]
    with stopped_after(n):
        document = SCENES[name][0]()(SCENES[name][1](), Options(reading=reading, end=LATE))
    assert text_of(document) == text_of(interrupted(name, n, reading))


@pytest.mark.parametrize("reading", READINGS)
def test_probabilities_are_intervals_that_contain_those_of_what_was_found(reading):
    name, found = "objects 5031", []
    for share in (0.4, 0.9):
        document = interrupted(name, int(share * cycle_of(name, ENOUGH)[2]), reading)
        exact = ranked_worlds(situation_of(document), 1000)
        every = {world.present: world.probability for world in exact.worlds}
        found += [
            (h["interval"], h["probability"], exact.marginals[h["id"]])
            for h in document["hypotheses"]
            if h["status"] != "rejected"
        ]
        found += [
            (world["interval"], world["probability"], every[tuple(world["present"])]) for world in document["worlds"]
        ]
    assert len(found) > 4
    for (low, high), told, true in found:
        assert low <= told <= high
        assert low - 1e-9 <= true <= high + 1e-9


def against(document, name, reading):
    """(interval, told, exact probability) of each presence, world and relation, and of the unlisted rest."""
    final, ranking = finished(name, reading)
    kb, every = SCENES[name][0]().kb, {frozenset(w.present): w.probability for w in ranking.worlds}
    became = {h["id"]: counterpart(h, final, kb) for h in document["hypotheses"]}
    for h in document["hypotheses"]:
        if "interval" in h:
            yield h["interval"], h["probability"], 0.0 if became[h["id"]] is None else became[h["id"]]["probability"]
    listed = 0.0
    for world in document["worlds"]:
        ids = [None if became[h] is None else became[h]["id"] for h in world["present"]]
        true = 0.0 if None in ids else every.get(frozenset(ids), 0.0)
        listed += true
        yield world["interval"], world["probability"], true
    yield document["unlisted_mass"], None, 1.0 - min(listed, 1.0)
    for row in document["relations"]:
        args = [became[h] and became[h]["id"] for h in row["args"]]
        held = [r["probability"] for r in final["relations"] if (r["relation"], r["args"]) == (row["relation"], args)]
        yield row["interval"], row["probability"], math.fsum(held)


def counterpart(h, final, kb):
    """The same hypothesis of the finished interpretation: of one type, in one place.

    None where more time rejects it, or moves it away.
    """
    kind, pose = kb.type(h["type"]), np.array(h["T_camera_object"])
    same = [
        o
        for o in final["hypotheses"]
        if o["type"] == h["type"] and same_place(kind, pose, np.array(o["T_camera_object"]))
    ]
    return next((o for o in same if o["status"] != "rejected"), None)


@pytest.mark.parametrize("name", SCENES)
def test_every_interval_contains_what_more_time_gives(name):
    for reading in READINGS:
        checked, moved = 0, 0
        for n in stops(name, 5):
            document = interrupted(name, n, reading)
            assert (document["unfinished"], document["stopped"]) == (True, "search")
            assert all("interval" in row for key in ("hypotheses", "worlds", "relations") for row in document[key])
            for (low, high), told, true in against(document, name, reading):
                assert low - 1e-9 <= true <= high + 1e-9
                checked, moved = checked + 1, moved + (told is not None and abs(told - true) > 1e-6)
        assert checked > 10
        assert moved > 0, "points would not hold"


@pytest.mark.parametrize("name", TWO)
def test_where_only_the_worlds_were_late_their_own_intervals_hold(name):
    for reading in READINGS:
        final, widths = finished(name, reading)[0], set()
        for checks in (0, 5, 10, 20, 40, 80):
            with stopped(checks, 0.0):
                document = interrupted(name, ENOUGH, reading)
            if "unfinished" not in document:
                continue
            assert document["stopped"] == "worlds"
            assert [h["id"] for h in document["hypotheses"]] == [h["id"] for h in final["hypotheses"]]
            for (low, high), _, true in against(document, name, reading):
                assert low - 1e-9 <= true <= high + 1e-9
                widths.add(round(high - low, 6))
        assert any(width < 1.0 for width in widths), "more is proved than nothing"
        assert max(widths) > 0.0, "and not everything"
