"""``plogic bench occlusion`` in small: every kind of pair, its oracles, neighbours, and what it promises."""

from collections import Counter

import pytest

from benchmarks.occlusion.bench import Judged, claims, judge
from benchmarks.occlusion.bodies import CAMERA, concave_bodies, convex_bodies
from benchmarks.occlusion.neighbours import neighbours
from benchmarks.occlusion.oracle import raster_relation
from benchmarks.occlusion.pairs import KINDS, pairs
from geometry.visibility.occlusion import occlusion
from geometry.visibility.roc import converse, parts_of

RCC_NEIGHBOURS = {
    ("DC", "EC"), ("EC", "PO"), ("PO", "TPP"), ("PO", "TPPi"), ("PO", "EQ"), ("TPP", "NTPP"), ("TPP", "EQ"), ("TPPi", "NTPPi"), ("TPPi", "EQ"),
}  # fmt: skip
TABLES = {"possible": 2, "reached": 2, "beyond": 0, "built": 1, "built wrong": 0}


@pytest.fixture(scope="module")
def judged():
    return [judge(pair) for kind in KINDS for pair in pairs(kind, 2 if kind == "clamps" else 11, 6)]


def test_every_pair_has_its_relation_the_converse_and_no_oracle_says_otherwise(judged):
    assert Counter(j.kind for j in judged).keys() == set(KINDS)
    assert [j.backward for j in judged] == [converse(j.relation) for j in judged]
    told = [(j.relation, other) for j in judged for other in (j.known, j.rays) if other is not None]
    assert len(told) > 60
    assert [pair for pair in told if pair[0] != pair[1]] == []


def test_the_bodies_are_closed_and_outward():
    solids = [one.solid.volume for one in (*convex_bodies(), *concave_bodies())]
    assert min(solids) > 0
    assert len(solids) == 10


def test_the_same_seed_gives_the_same_pairs():
    first, again = (
        [(p.x.camera_from_object.tobytes(), p.y.vertices.tobytes()) for p in pairs("concave", 3, 1)] for _ in range(2)
    )
    assert first == again


def test_a_raster_says_nothing_of_what_touches_and_of_equal_images():
    pair = next(p for p in pairs("equal", 20, 3) if occlusion(p.x, p.y, CAMERA) == "totally_occludes_eq")
    assert raster_relation(pair.x, pair.y) is None


def test_neighbours_in_the_image_are_neighbours_of_rcc_8_and_orders_change_by_way_of_both():
    found = neighbours(3, 2, ("nested", "stacks")) | neighbours(1, 0, ("clamps",))
    assert len(found) > 8
    for before, after in found:
        (here, front), (there, later) = parts_of(before), parts_of(after)
        assert here == there or {(here, there), (there, here)} & RCC_NEIGHBOURS
        assert {front, later} != {"x", "y"}
        assert (after, before) in found


def test_what_is_promised():
    good = Judged("convex", "non_occludes_dc", "non_occludes_dc", "non_occludes_dc", "non_occludes_dc", 1.0, 1.0)
    wrong = Judged("convex", "non_occludes_ec", "partially_occludes_po", None, "non_occludes_dc", 1.0, 1.0)
    fine = {c.claim: c.met for c in claims([good], TABLES, quick=True)}
    unmet = {c.claim for c in claims([good, wrong], TABLES | {"reached": 1}, quick=False) if not c.met}
    assert fine["pairs of which R(x, y) is not the converse of R(y, x)"]
    assert {"agreement with the rays where they decide", "composition: possible triples not reached"} <= unmet
    assert "pairs of which R(x, y) is not the converse of R(y, x)" in unmet
