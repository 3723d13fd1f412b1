"""The six coarse relations by hand, their laws on random pairs, and the oracle: dense depth rasters."""

from collections import Counter

import numpy as np
import pytest
from geometry_bodies import CAMERA, LENS, at, bodies, box, bracket, posed, random_rotations, wedge

from geometry.bodies.overlap import Solid, solid_overlap
from geometry.errors import GeometryError
from geometry.frames import from_rotation_translation
from geometry.visibility.occlusion import PosedSurface, drawn, occlusion, visible_fraction
from geometry.visibility.rays import RayMesh, behind
from geometry.visibility.roc import coarse, coarse_converse, converse


def coarse_relation(*args, **options):
    """Which of the six coarse relations `occlusion` is a case of (§3.6)."""
    return coarse(occlusion(*args, **options))


SMALL, LARGE = box(0.4, 0.4, 0.4), box(2, 2, 0.4)
SLANT = np.array([[14, 0, 15], [0, np.hypot(14, 15), 0], [-15, 0, 14]]) / np.hypot(14, 15)  # z to (15, 0, 14)
THROUGH = at(0, 0.3, 4.4, SLANT) @ at(
    0, 0, -2
)  # before the bracket's left arm, through its hollow, behind its right arm
BY_HAND = {
    "DC": (posed(SMALL, at(-1, 0, 4)), posed(SMALL, at(1, 0, 4)), "non_occludes"),
    "EC, same depth": (posed(SMALL, at(-0.2, 0, 4)), posed(SMALL, at(0.2, 0, 4)), "non_occludes"),
    "PO, x in front": (posed(SMALL, at(0, 0, 3)), posed(SMALL, at(0.3, 0, 5)), "partially_occludes"),
    "PO, x behind": (posed(SMALL, at(0.3, 0, 5)), posed(SMALL, at(0, 0, 3)), "partially_occluded_by"),
    "NTPP, x in front": (posed(SMALL, at(0, 0, 3)), posed(LARGE, at(0, 0, 5)), "partially_occludes"),
    "TPP, x in front": (posed(box(0.4, 2, 1), at(0.8, 0, 4)), posed(box(2, 2, 1), at(0, 0, 5.0)), "partially_occludes"),
    "NTPPi, x in front": (posed(LARGE, at(0, 0, 3)), posed(SMALL, at(0, 0, 5)), "totally_occludes"),
    "NTPPi, x behind": (posed(SMALL, at(0, 0, 5)), posed(LARGE, at(0, 0, 3)), "totally_occluded_by"),
    "EQ, x in front": (posed(SMALL, at(0, 0, 3)), posed(box(0.8, 0.8, 0.8), at(0, 0, 6)), "totally_occludes"),
    "touching, one on the other": (posed(SMALL, at(0, 0.4, 4)), posed(SMALL, at(0, 0, 4)), "partially_occluded_by"),
    "PO, mutual": (posed(bracket(), at(0, 0, 4)), posed(box(0.1, 0.1, 4), THROUGH), "mutually_occludes"),
    "the same place": (posed(SMALL, at(0, 0, 4)), posed(SMALL, at(0, 0, 4)), "mutually_occludes"),
    "behind the camera": (posed(SMALL, at(0, 0, -4)), posed(SMALL, at(0, 0, 4)), "non_occludes"),
}


@pytest.mark.parametrize("case", BY_HAND)
@pytest.mark.parametrize("camera", [CAMERA, LENS])
def test_relations_by_hand(case, camera):
    x, y, expected = BY_HAND[case]
    assert coarse_relation(x, y, camera) == expected
    assert coarse_relation(y, x, camera) == coarse_converse(expected)


def test_the_converse_of_the_converse_is_the_relation():
    relations = {expected for _, _, expected in BY_HAND.values()}
    assert len(relations) == 6
    assert all(coarse_converse(coarse_converse(relation)) == relation for relation in relations)
    assert coarse_converse("mutually_occludes") == "mutually_occludes"


@pytest.fixture(scope="module")
def random_pairs():
    rng = np.random.default_rng(0)
    kinds = [*bodies(), box(2, 2, 0.3), box(0.3, 0.3, 0.3)]
    meshes = [(kind, RayMesh(*kind)) for kind in kinds]
    turns = random_rotations(rng, 800)
    places = np.c_[rng.uniform(-0.7, 0.7, (800, 2)), rng.uniform(3, 8, 800)]
    picks = rng.integers(len(kinds), size=800)
    surfaces = [
        PosedSurface(*meshes[pick][0], meshes[pick][1], from_rotation_translation(R, t))
        for pick, R, t in zip(picks, turns, places, strict=True)
    ]
    return list(zip(surfaces[::2], surfaces[1::2], strict=True))


def test_r_of_x_y_is_the_converse_of_r_of_y_x(random_pairs):
    found = [occlusion(x, y, CAMERA) for x, y in random_pairs]
    assert [converse(occlusion(y, x, CAMERA)) for x, y in random_pairs] == found
    assert set(Counter(map(coarse, found))) >= {expected for _, _, expected in BY_HAND.values()}


def test_relations_equal_dense_depth_rasters(random_pairs):
    """Oracle: rays through a grid over all of both bodies, of pairs that could stand in one world.

    (Bodies that share volume may be mutual over less than a pixel: we find that, and a raster does not.)
    """
    uv = np.stack(np.meshgrid(np.arange(-300, 940, 6.0), np.arange(-300, 780, 6.0)), axis=-1)
    rays, shape = CAMERA.rays(uv.reshape(-1, 2)), uv.shape[:2]
    pairs = [(x, y) for x, y in random_pairs[:250] if discrete(x, y)]
    depths = [(x.depth(rays).reshape(shape), y.depth(rays).reshape(shape)) for x, y in pairs]
    verdicts = [
        (coarse_relation(*pair, CAMERA), raster_relation(*both)) for pair, both in zip(pairs, depths, strict=True)
    ]
    agree = [found == expected for found, expected in verdicts if expected is not None]
    assert len(agree) > 40
    assert all(agree)


def discrete(x, y):
    a, b = (Solid(body.vertices, body.triangles) for body in (x, y))
    return solid_overlap(a, x.camera_from_object, b, y.camera_from_object) == 0


def raster_relation(x, y):
    """The relation by a grid of depths; None where some cells more or less would change it: a raster cannot tell."""
    from scipy.ndimage import binary_dilation

    seen_x, seen_y = np.isfinite(x), np.isfinite(y)
    common, wide_x, wide_y = (
        seen_x & seen_y,
        binary_dilation(seen_x, iterations=2),
        binary_dilation(seen_y, iterations=2),
    )
    if not common.any():
        return None if (wide_x & wide_y).any() else "non_occludes"
    x_first, y_first = (common & (x < y * (1 - 1e-4))).sum(), (common & (y < x * (1 - 1e-4))).sum()
    if 0 < x_first < 5 or 0 < y_first < 5:
        return None
    if x_first and y_first:
        return "mutually_occludes"
    back, wide_back, front = (seen_y, wide_y, seen_x) if x_first else (seen_x, wide_x, seen_y)
    if (wide_back & ~front).any() and (back & ~front).sum() < 5:
        return None
    name = "partially" if (back & ~front).any() else "totally"
    return f"{name}_occludes" if x_first else f"{name}_occluded_by"


def test_total_by_outlines_is_total_by_points(random_pairs):
    """The law of §3.5: a covered object behind everywhere has no self-visible point that is not Behind the other."""
    checked = 0
    for x, y in random_pairs:
        if coarse(occlusion(x, y, CAMERA)) == "totally_occludes" and discrete(x, y):
            points = y.vertices[y.triangles].mean(axis=1) @ y.camera_from_object[:3, :3].T + y.camera_from_object[:3, 3]
            visible = points[~behind(points, y.rays, y.camera_from_object, 1e-3)]
            assert behind(visible, x.rays, x.camera_from_object, 1e-3).all()
            checked += len(visible)
    assert checked > 20


def test_the_relation_does_not_depend_on_where_x_y_and_the_image_lie():
    """Turning the camera about its own centre turns both images; who hides whom stays."""
    rng = np.random.default_rng(3)
    turn = from_rotation_translation(np.array([[0.0, -1, 0], [1, 0, 0], [0, 0, 1]]), [0, 0, 0])
    pairs = [
        (
            posed(wedge(), from_rotation_translation(a, [0, 0, 4])),
            posed(bracket(), from_rotation_translation(b, [0.5, 0, 6])),
        )
        for a, b in zip(random_rotations(rng, 30), random_rotations(rng, 30), strict=True)
    ]
    here = [coarse_relation(x, y, CAMERA) for x, y in pairs]
    there = [
        coarse_relation(
            posed(wedge(), turn @ x.camera_from_object), posed(bracket(), turn @ y.camera_from_object), CAMERA
        )
        for x, y in pairs
    ]
    assert here == there
    assert len(set(here)) > 1


def test_outlines_that_are_known_need_not_be_drawn_again():
    x, y = posed(SMALL, at(0, 0, 3)), posed(SMALL, at(0.3, 0, 5))
    assert (
        coarse_relation(x, y, CAMERA, images=(drawn(x, CAMERA), drawn(y, CAMERA)))
        == coarse_relation(x, y, CAMERA)
        == "partially_occludes"
    )


def test_a_sliver_in_common_is_no_interior_within_the_tolerance():
    x, y = (
        posed(SMALL, at(0, 0, 3)),
        posed(SMALL, at(0.2 + 39.5 / 600 * 5.2, 0, 4.8)),
    )  # x reaches to 40 px, y from 39.5
    assert coarse_relation(x, y, CAMERA, 0.0) == "partially_occludes"
    assert coarse_relation(x, y, CAMERA, 0.2) == "partially_occludes"
    assert coarse_relation(x, y, CAMERA, 0.3) == "non_occludes"


def test_a_pose_that_is_not_rigid_is_refused():
    with pytest.raises(GeometryError, match="must be rigid"):
        posed(SMALL, np.eye(4) * 2)


def test_visible_fractions_by_hand():
    back, middle, half = posed(LARGE, at(0, 0, 5)), posed(SMALL, at(0, 0, 3)), posed(box(4, 4, 0.1), at(-2, 0, 3))
    assert visible_fraction(back, [], CAMERA) == 1.0
    assert visible_fraction(back, [half], CAMERA) == pytest.approx(0.5, abs=0.02)
    hidden_part = (0.4 / 3 / (2 / 5)) ** 2
    assert visible_fraction(back, [middle], CAMERA) == pytest.approx(1 - hidden_part, abs=0.01)
    assert visible_fraction(middle, [back], CAMERA) == 1.0
    assert visible_fraction(posed(SMALL, at(0, 0, 5)), [posed(LARGE, at(0, 0, 3))], CAMERA) == 0.0
    assert visible_fraction(posed(SMALL, at(0, 0, -5)), [], CAMERA) == 0.0


def test_what_leaves_the_picture_is_not_visible():
    edge = posed(box(1, 1, 0.001), at(-320.5 / 600 * 5, 0, 5))  # its middle on the picture's left border
    assert visible_fraction(edge, [], CAMERA) == pytest.approx(0.5, abs=0.02)
