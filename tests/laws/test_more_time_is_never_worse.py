"""Anytime (``plogic.cycle.choosing``): wherever the cycle is stopped, it answers with a stable Δi, and more time never makes its weight less."""

from __future__ import annotations

import math
from functools import cache
from itertools import pairwise

import numpy as np
import pytest
from interrupted import LATE, stopped_after
from many_objects import accepted_rows, few_types, scene_of_seed
from stopping import stopped
from synthetic import one_before_the_other, perceiver, scene

from plogic.cycle.delta import Options
from plogic.facts.interpretation import situation_of, text_of
from plogic.match.judged.rivals import same_place
from plogic.scene.worlds.ranked_worlds import ranked_worlds

STOPS = 10
"""Looks at the time at which one scene is stopped, the first and the last ones among them."""


@cache
def towers_of(seed):
    rng = np.random.default_rng(seed)
    return scene(rng, one_before_the_other(rng), clutter=6).gamma


SCENES = {
    "towers": lambda: (perceiver(), towers_of(6201)),
    "many objects": lambda: (few_types(), scene_of_seed(5031).gamma),
}


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


DRAWN = {f"towers {seed}": (perceiver, lambda seed=seed: towers_of(seed)) for seed in (6201, 6202, 6203)} | {
    f"many objects {seed}": (few_types, lambda seed=seed: scene_of_seed(seed).gamma) for seed in (5031, 5033)
}
"""Scenes of several seeds: what perceives them, and their Γ."""


@cache
def finished(name, reading):
    """The interpretation of one with time enough, how many looks at the time it takes, and all its worlds."""
    document, looks = interrupted(DRAWN[name][0](), DRAWN[name][1](), 10**9, reading)
    return document, looks, ranked_worlds(situation_of(document), 10**6)


def against(document, name, reading):
    """(interval, told, exact probability) of each presence, world and relation, and of the unlisted rest."""
    final, _, ranking = finished(name, reading)
    kb, every = DRAWN[name][0]().kb, {frozenset(w.present): w.probability for w in ranking.worlds}
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


@pytest.mark.parametrize("reading", ["score", "posterior"])
@pytest.mark.parametrize("name", DRAWN)
def test_every_interval_contains_what_more_time_gives(name, reading):
    looks, checked, moved = finished(name, reading)[1], 0, 0
    for n in sorted({int(n) for n in np.linspace(0, looks - 1, 5)}):
        document, _ = interrupted(DRAWN[name][0](), DRAWN[name][1](), n, reading)
        assert (document["unfinished"], document["stopped"]) == (True, "search")
        assert all("interval" in row for key in ("hypotheses", "worlds", "relations") for row in document[key])
        for (low, high), told, true in against(document, name, reading):
            assert low - 1e-9 <= true <= high + 1e-9
            checked, moved = checked + 1, moved + (told is not None and abs(told - true) > 1e-6)
    assert checked > 10
    assert moved > 0, "points would not hold"


@pytest.mark.parametrize("reading", ["score", "posterior"])
@pytest.mark.parametrize("name", ["towers 6201", "many objects 5031"])
def test_where_only_the_worlds_were_late_their_own_intervals_hold(name, reading):
    widths = set()
    for checks in (0, 5, 10, 20, 40, 80):
        with stopped(checks, 0.0):
            document, _ = interrupted(DRAWN[name][0](), DRAWN[name][1](), 10**9, reading)
        if "unfinished" not in document:
            continue
        assert document["stopped"] == "worlds"
        assert [h["id"] for h in document["hypotheses"]] == [h["id"] for h in finished(name, reading)[0]["hypotheses"]]
        for (low, high), _, true in against(document, name, reading):
            assert low - 1e-9 <= true <= high + 1e-9
            widths.add(round(high - low, 6))
    assert any(width < 1.0 for width in widths), "more is proved than nothing"
    assert max(widths) > 0.0, "and not everything"
