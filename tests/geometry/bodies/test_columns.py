"""Above and on, by hand and by their laws; contact by an independent measure of the gap."""

from itertools import product

import numpy as np
import pytest
import shapely
import trimesh
from geometry_bodies import at, box, bracket, posed, prism, random_rotations, wedge
from hypothesis import given, settings
from hypothesis import strategies as st

from geometry.bodies.columns import above, body_of, centre_of_mass, stands, steady
from geometry.bodies.overlap import Solid, gap
from geometry.frames import from_rotation_translation

QUICK = settings(max_examples=40, deadline=None, derandomize=True)
TOLERANCE = 0.01
UP = np.array([0.0, 0.0, 1.0])
BODIES = (box(), box(0.4, 0.3, 0.2), wedge(), bracket())


def placed(body, pose, camera_from_world=None):
    T = np.eye(4) if camera_from_world is None else camera_from_world
    return body_of(posed(body, T @ pose), T[:3, :3] @ UP)


def on(x, y):
    contact = stands(x, y, TOLERANCE)
    return contact is not None and steady([contact], TOLERANCE)


def relations(x, y):
    return above(x, y, TOLERANCE), above(y, x, TOLERANCE), on(x, y), on(y, x)


ON_END = [[1, 0, 0], [0, 0, -1], [0, 1, 0]]
UPSIDE_DOWN = [[1, 0, 0], [0, 0, 1], [0, -1, 0]]
GABLE = prism([(-1, 0), (1, 0), (0, 2)], 1.0)
BY_HAND = {
    "a cube on a cube": ((box(), at(0.2, 0.1, 1.0)), (box(), at()), (True, False, True, False)),
    "it floats": ((box(), at(0, 0, 1.2)), (box(), at()), (True, False, False, False)),
    "it sank in by what poses are wrong": ((box(), at(0, 0, 0.995)), (box(), at()), (True, False, True, False)),
    "it hangs over by more than half": ((box(), at(0.6, 0, 1.0)), (box(), at()), (True, False, False, False)),
    "side by side": ((box(), at(1.0, 0, 0)), (box(), at()), (False, False, False, False)),
    "higher, but beside": ((box(), at(1.5, 0, 3.0)), (box(), at()), (False, False, False, False)),
    "two thin sheets": ((box(1, 1, 0.002), at(0, 0, 0.002)), (box(1, 1, 0.002), at()), (True, False, True, False)),
    "in a standing U": ((box(1.0, 0.3, 0.4), at(0, -0.4, -0.2)), (bracket(), at(R=ON_END)), (True, False, True, False)),
    "across a standing U": (
        (box(2, 0.3, 0.4), at(0, -0.4, 0.6)),
        (bracket(), at(R=ON_END)),
        (True, False, True, False),
    ),
    "hung over an arm of it": (
        (bracket(), at(0.8, -0.8, 0.5, R=UPSIDE_DOWN)),
        (bracket(), at(R=ON_END)),
        (True, False, False, False),
    ),
    "crossed bars": ((box(2, 0.1, 0.1), at(0, 0, 0.1)), (box(0.1, 2, 0.1), at()), (True, False, True, False)),
    "on a sloping roof": ((box(0.2, 0.2, 0.2), at(0.2, 0, 1.45)), (wedge(), at()), (True, False, False, False)),
    "against a roof that is too steep": (
        (box(0.2, 0.2, 0.2), at(0.5, -0.5, 1.2)),
        (GABLE, at(R=ON_END)),
        (True, False, False, False),
    ),
}


@pytest.mark.parametrize("name", BY_HAND)
def test_by_hand(name):
    (x, T_x), (y, T_y), expected = BY_HAND[name]
    assert relations(placed(x, T_x), placed(y, T_y)) == expected


def test_a_block_between_the_arms_of_a_link_is_neither_above_nor_below():
    """A ring that stands, a bar through it: parts of the ring are over the bar, and parts under."""
    hole = trimesh.Trimesh(*box(1.4, 1.4, 2.0)).apply_translation([0, 0, -1])
    ring = trimesh.boolean.difference([trimesh.Trimesh(*box(2.0, 2.0, 0.3)), hole], engine="manifold")
    standing = placed((np.array(ring.vertices), np.array(ring.faces)), at(R=ON_END))
    bar = placed(box(0.2, 2.0, 0.2), at(0, 0, 0))
    assert relations(bar, standing) == (False, False, False, False)


def drawn(seed):
    """Two bodies, the one dropped somewhere near the top of the other, now and then exactly onto it."""
    rng = np.random.default_rng(seed)
    x, y = (BODIES[k] for k in rng.integers(0, len(BODIES), 2))
    turn = random_rotations(rng, 1)[0] if rng.random() < 0.3 else np.eye(3)
    T_x = from_rotation_translation(turn, [*rng.uniform(-0.6, 0.6, 2), 0.0])
    top, bottom = np.ptp(y[0][:, 2]) + y[0][:, 2].min(), (x[0] @ turn.T)[:, 2].min()
    T_x[2, 3] = top - bottom + (0.0 if rng.random() < 0.5 else rng.uniform(-0.3, 0.3))
    return (x, T_x), (y, np.eye(4))


@QUICK
@given(st.integers(0, 9999))
def test_above_is_asymmetric_and_a_turned_world_keeps_above_and_on(seed):
    (x, T_x), (y, T_y) = drawn(seed)
    told = relations(placed(x, T_x), placed(y, T_y))
    assert not (told[0] and told[1])
    camera_from_world = from_rotation_translation(random_rotations(np.random.default_rng(seed), 1)[0], [0.3, -0.2, 4])
    assert relations(placed(x, T_x, camera_from_world), placed(y, T_y, camera_from_world)) == told


def test_on_implies_above_and_contact():
    """Contact by the gap of the two surfaces, which columns know nothing of."""
    found = 0
    for seed in range(150):
        (x, T_x), (y, T_y) = drawn(seed)
        over, _, stood, _ = relations(placed(x, T_x), placed(y, T_y))
        if stood:
            found += 1
            assert over
            assert gap(posed(x, T_x), posed(y, T_y), (Solid(*x), Solid(*y))) <= TOLERANCE
    assert found > 20


def test_a_plank_on_two_blocks_stands_on_both_together():
    plank = placed(box(2, 0.3, 0.1), at(0, 0, 1))
    contacts = [stands(plank, placed(box(0.4, 0.4, 1.0), at(x, 0, 0)), TOLERANCE) for x in (-0.8, 0.8)]
    assert [steady([one], TOLERANCE) for one in contacts] == [False, False]
    assert steady(contacts, TOLERANCE)


@pytest.mark.parametrize(
    ("body", "expected"), [(box(2, 1, 3), (0, 0, 1.5)), (bracket(), (0, (0.8 * -0.4 + 0.64 * 0.2) / 1.44, 0.4))]
)
def test_the_centre_of_mass_is_that_of_the_filled_body(body, expected):
    moved = body[0] + [5.0, -3.0, 2.0]
    assert centre_of_mass(moved, body[1]) == pytest.approx(np.add(expected, [5, -3, 2]))


def test_a_sheet_has_the_centre_of_its_area():
    vertices, triangles = (
        np.array([[0, 0, 0], [3, 0, 0], [3, 1, 0], [0, 1, 0]], float),
        np.array([[0, 1, 2], [0, 2, 3]]),
    )
    assert centre_of_mass(vertices, triangles) == pytest.approx([1.5, 0.5, 0])


@pytest.mark.parametrize("tolerance", [0.005, 0.02])
def test_contact_ends_where_the_tolerance_does(tolerance):
    floor = placed(box(2, 2, 0.1), at(0, 0, -0.1))
    for off, expected in product((-1, 1), (True, False)):
        height = off * tolerance * (0.9 if expected else 1.1)
        contact = stands(placed(box(0.2, 0.2, 0.2), at(0, 0, height)), floor, tolerance)
        assert (contact is not None) == expected


def test_the_footprint_of_many_facets_is_their_hulls_in_any_unit():
    """What is fine for pixels is fine for millimetres, not for metres."""
    ball = trimesh.creation.icosphere(subdivisions=3, radius=0.04)
    pose = at(R=random_rotations(np.random.default_rng(3), 1)[0])
    for unit in (1.0, 1000.0):
        body = unit * np.asarray(ball.vertices), np.asarray(ball.faces)
        hull = shapely.MultiPoint((body[0] @ pose[:3, :3].T)[:, :2]).convex_hull.area
        assert placed(body, pose).footprint.area == pytest.approx(hull, rel=1e-9)
