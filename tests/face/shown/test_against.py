"""Hatched is where few features are found of those that were found when the type was learned."""

from __future__ import annotations

import numpy as np

from plogic.face.shown.against import missed_on

SIZE = 200, 100


def row(case_of, **more):
    """A rectangle with a feature every four pixels, half of which were found in learning."""
    features = [
        {"uv": [float(u), float(v)], "case": case_of(u), "learned_rate": 0.5} | more
        for u in range(42, 160, 4)
        for v in range(22, 80, 4)
    ]
    return {"id": "h1", "outline": [[[40, 20], [160, 20], [160, 80], [40, 80]]], "features": features}


def test_half_that_misses_all_is_hatched_and_half_that_is_found_is_not():
    mask = missed_on(row(lambda u: "A" if u < 100 else "C"), SIZE)
    assert mask.shape == (100, 200)
    assert not mask[:, :95].any()
    assert mask[22:79, 108:158].all()
    assert not mask[:19].any()
    assert not mask[82:].any()


def test_as_many_as_in_learning_are_enough():
    assert not missed_on(row(lambda u: "A" if u // 4 % 2 else "C"), SIZE).any()


def test_what_others_hide_and_what_was_not_learned_is_not_hatched():
    assert not missed_on(row(lambda u: "A" if u < 100 else "B"), SIZE).any()
    plain = row(lambda _: "C")
    for feature in plain["features"]:
        del feature["learned_rate"]
    assert not missed_on(plain, SIZE).any()


def test_no_outline_and_a_place_outside_do_no_harm():
    bare = row(lambda _: "C") | {"outline": []}
    assert not missed_on(bare, SIZE).any()
    far = row(lambda _: "C", uv=[500.0, -3.0])
    assert missed_on(far, SIZE).dtype == np.bool_
