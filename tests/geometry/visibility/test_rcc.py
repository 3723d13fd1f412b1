"""RCC-8 of two areas at a tolerance.

By hand, jointly exhaustive and pairwise disjoint, converse, and its tolerances (§3.7).
"""

import pytest
import shapely
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from geometry.visibility.occlusion import related
from geometry.visibility.roc import RCC8, rcc_converse

T = 0.25
WHOLE = shapely.box(0, 0, 10, 10)
FRAME = WHOLE.difference(shapely.box(3, 3, 7, 7))
BY_HAND = {
    "DC": shapely.box(12, 0, 14, 10),
    "EC": shapely.box(10, 0, 14, 10),
    "PO": shapely.box(8, 2, 14, 6),
    "TPP": shapely.box(0, 2, 4, 6),
    "NTPP": shapely.box(2, 2, 4, 6),
    "EQ": shapely.box(0, 0, 10, 10),
    "TPPi": shapely.box(0, 0, 12, 12),
    "NTPPi": shapely.box(-2, -2, 12, 12),
}


def rcc8(a, b, tolerance):
    return related(a, b, tolerance).rcc


@pytest.mark.parametrize("term", RCC8)
def test_by_hand(term):
    assert rcc8(BY_HAND[term], WHOLE, T) == term
    assert rcc8(WHOLE, BY_HAND[term], T) == rcc_converse(term)
    assert rcc8(BY_HAND[term], WHOLE, 0.0) == term


@pytest.mark.parametrize(
    ("a", "within", "beyond"),
    [
        (shapely.box(10.2, 0, 14, 10), "EC", "DC"),
        (shapely.box(9.7, 0, 14, 10), "EC", "PO"),
        (shapely.box(0.2, 2, 4, 6), "TPP", "NTPP"),
        (shapely.box(-0.2, 2, 4, 6), "TPP", "PO"),
        (shapely.box(0.2, 0, 10, 10.2), "EQ", "PO"),
        (shapely.box(0.15, 0.15, 9.85, 9.85), "EQ", "NTPP"),
    ],
)
def test_what_is_within_the_tolerance_and_what_is_beyond_it(a, within, beyond):
    assert rcc8(a, WHOLE, T) == within
    assert rcc8(a, WHOLE, 0.1) == beyond


def test_what_stands_in_a_hole_is_outside_and_what_fills_it_touches():
    assert rcc8(shapely.box(4, 4, 6, 6), FRAME, T) == "DC"
    assert rcc8(shapely.box(3, 3, 7, 7), FRAME, T) == "EC"
    assert rcc8(FRAME, WHOLE, T) == "TPP"
    assert rcc8(FRAME, shapely.box(2, 2, 8, 8), T) == "PO"


def test_nothing_is_dc_from_everything():
    assert (
        rcc8(shapely.Polygon(), WHOLE, T)
        == rcc8(WHOLE, shapely.Polygon(), T)
        == rcc8(shapely.Polygon(), shapely.Polygon(), T)
        == "DC"
    )


def test_a_crack_of_rounding_is_no_boundary():
    cracked = WHOLE.difference(shapely.Polygon([(5, -1), (5 + 1e-11, -1), (5, 6)]))
    assert len(cracked.exterior.coords) > 5
    assert rcc8(shapely.box(4, 4, 6, 6), cracked, T) == "NTPP"
    assert rcc8(shapely.box(0, 4, 6, 6), cracked, T) == "TPP"


coordinates = st.integers(0, 12).map(lambda n: n * 0.2)
points = st.tuples(coordinates, coordinates)


def area(corners):
    return shapely.union_all([shapely.MultiPoint(part).convex_hull.buffer(0) for part in (corners[:4], corners[4:])])


areas = st.lists(points, min_size=8, max_size=8).map(area)


@settings(max_examples=120, deadline=None)
@given(areas, areas, st.sampled_from([0.05, T]))
def test_each_pair_has_one_relation_its_converse_the_other_way_and_an_interior_where_it_says_so(a, b, tolerance):
    assume(not a.is_empty and not b.is_empty)
    there, back = related(a, b, tolerance), related(b, a, tolerance)
    assert there.rcc in RCC8
    assert back.rcc == rcc_converse(there.rcc)
    assert back.interior.wkb == there.interior.wkb
    assert there.interior.is_empty == (there.rcc in ("DC", "EC"))


@settings(max_examples=100, deadline=None)
@given(areas)
def test_an_area_equals_itself_unless_it_is_too_thin(a):
    thick = not a.buffer(-T, join_style="mitre").is_empty
    assert rcc8(a, a, T) == ("EQ" if thick else "DC" if a.is_empty else "EC")
