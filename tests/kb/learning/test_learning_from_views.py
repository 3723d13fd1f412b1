"""Learning a painted cube from a few small pictures.

What is seen lies on its faces, and its cloud says from where, how often and how large.
"""

from dataclasses import fields, replace
from functools import cache

import numpy as np
import pytest
from painted_cube import CORNER, COUNT, F_REF, PIXELS, SIDE, cloud, cube, facing, seen, seen_of, sizes

from geometry.cones import even_directions, spacing
from kb.clouds.learned import cloud_bytes, read_cloud
from kb.learning.features import BEYOND, END, LEAST_SEEN, NEARER, STEP, _alike, _places, cloud_of, reaches
from kb.learning.observations import AWAY, EDGE, MARGIN, OFTEN, bare, distance, joined, variants
from sensing.pixels.turntable import turned

FEW = facing(CORNER, 25.0)


@cache
def few():
    """What is seen of the cube from FEW."""
    with sizes():
        return seen_of(cube(), FEW)


def test_observations_lie_on_the_faces_that_their_normals_say():
    some = seen()
    face = np.abs(some.at).argmax(axis=1)
    rows = np.arange(len(some))
    assert len(some) > 500
    assert (np.abs(np.abs(some.at[rows, face]) - SIDE / 2) < 1.5 * some.pixel).all()
    assert (np.abs(some.at).max(axis=1) < SIDE / 2 + 1.5 * some.pixel).all()
    inner = np.sort(np.abs(some.at), axis=1)[:, 1] < SIDE / 2 - 3 * some.pixel
    turned_by = (some.normal[rows, face] * np.sign(some.at[rows, face]))[inner]
    assert np.quantile(turned_by, 0.02) > np.cos(np.radians(5.0))
    assert ((some.normal * some.direction).sum(axis=1) > 0).all()


def test_observations_are_unit_and_perpendicular_and_of_the_size_of_things():
    some = seen()
    for name in ("normal", "direction", "up"):
        np.testing.assert_allclose(np.linalg.norm(getattr(some, name), axis=1), 1.0, atol=1e-6)
    assert np.abs((some.up * some.direction).sum(axis=1)).max() < 1e-6
    diameter = SIDE * 3**0.5
    np.testing.assert_allclose(
        some.pixel * np.array(PIXELS)[some.level] / diameter, 1.0, atol=0.13
    )  # nearer or farther than the middle
    assert ((some.size > some.pixel) & (some.size < diameter)).all()
    assert ((some.hit >= OFTEN) & (some.hit <= 1)).all()
    near = (some.direction * even_directions(COUNT)[some.view]).sum(axis=1)
    assert (near > np.cos(np.arctan(0.5 / 4.5))).all()


def test_a_keypoint_is_seen_where_the_same_place_is_seen_in_a_larger_picture():
    """Places of one spot from pictures of different sizes agree to a part of a pixel.

    There is no half-pixel bias between levels.
    """
    some = seen()
    groups = [g for g in _places(some, np.arange(len(some))) if len(set(some.level[g].tolist())) == len(PIXELS)]
    assert len(groups) > 20
    camera_right = [np.cross(some.up[g[0]], some.direction[g[0]]) for g in groups]
    off = [
        ((some.at[g][some.level[g] == 2].mean(axis=0) - some.at[g][some.level[g] == 0].mean(axis=0)) @ across)
        / some.pixel[g].max()
        for g, across in zip(groups, camera_right, strict=True)
    ]
    assert abs(np.median(off)) < 0.1


def test_features_are_where_they_were_seen_and_their_lobes_hold_who_saw_them():
    some, here = seen(), cloud(seen())
    groups = sorted((g for g in _places(some, np.arange(len(some))) if len(g) >= LEAST_SEEN), key=lambda g: int(g[0]))
    assert len(here.at) == len(groups) > 50
    assert sorted(i for g in _places(some, np.arange(len(some))) for i in g.tolist()) == list(range(len(some)))
    for number, group in enumerate(groups):
        assert np.linalg.norm(some.at[group] - here.at[number], axis=1).max() <= 2 * reaches(some)[group].max()
        lobes = _alike(some, group)
        mine = np.flatnonzero(here.feature == number)
        assert sorted(i for lobe in lobes for i in lobe.tolist()) == sorted(group.tolist())
        assert len(mine) == len(lobes)
        for row, lobe in zip(mine, lobes, strict=True):
            assert (some.direction[lobe] @ here.axis[row] >= np.cos(here.half_angle[row])).all()
            levels = some.level[lobe].tolist()
            nearest, farthest = (distance(PIXELS[level], SIDE * 3**0.5, F_REF) for level in (min(levels), max(levels)))
            assert here.r_min[row] == pytest.approx(nearest / (NEARER if min(levels) == 0 else STEP))
            assert here.r_max[row] == pytest.approx(farthest * (END if max(levels) == len(PIXELS) - 1 else STEP))
            assert here.size[row] == pytest.approx(np.exp(np.log(some.size[lobe]).mean()))


def test_the_cloud_is_one_that_can_be_read():
    here = cloud(seen())
    assert ((here.hit > 0) & (here.hit <= 1)).all()
    assert (here.half_angle >= BEYOND * spacing(COUNT)).all()
    assert np.abs((here.up * here.axis).sum(axis=1)).max() < 1e-9
    assert len(read_cloud(cloud_bytes(here)).at) == len(here.at)


def test_a_hit_rate_is_what_was_found_of_the_pictures_that_could_have_shown_it():
    """Also those of directions within the lobe that saw nothing, and of sizes between the extremes that did.

    A lobe that holds fewer directions than a cone of its size holds on average counts as many as that.
    """
    some, here, row = seen(), cloud(seen()), 0
    for group in sorted(
        (g for g in _places(some, np.arange(len(some))) if len(g) >= LEAST_SEEN), key=lambda g: int(g[0])
    ):
        for lobe in _alike(some, group):
            levels = some.level[lobe].tolist()
            could = [
                i for i, d in enumerate(even_directions(COUNT)) if d @ here.axis[row] >= np.cos(here.half_angle[row])
            ]
            average = COUNT * (1 - np.cos(here.half_angle[row])) / 2
            found = some.hit[lobe].sum() / (max(len(could), average) * (max(levels) - min(levels) + 1))
            assert here.hit[row] == pytest.approx(min(1.0, found))
            row += 1
    assert row == len(here.hit)


def test_the_same_seed_gives_the_same_bytes_and_another_does_not():
    with sizes():
        again, other = (seen_of(cube(), FEW, seed=seed) for seed in (0, 4))
    assert cloud_bytes(cloud(few())) == cloud_bytes(cloud(again))
    assert cloud_bytes(cloud(few())) != cloud_bytes(cloud(other))


def test_views_can_be_looked_at_apart():
    """What is seen from one direction does not depend on which others a process has."""
    with sizes():
        whole, apart = few(), joined([seen_of(cube(), [number]) for number in FEW])
    assert len(whole.at) > 0
    for f in fields(whole):
        assert np.array_equal(getattr(whole, f.name), getattr(apart, f.name)), f.name


def test_millimetres_read_as_metres_scale_lengths_and_nothing_else():
    with sizes():
        small, large = few(), seen_of(cube(1000 * SIDE), FEW)
    one, other = cloud(small), cloud(large, 1000 * SIDE * 3**0.5)
    lengths = {"at", "sigma", "r_min", "r_max", "size"}
    assert len(one.at) > 0
    for f in fields(one):
        mine, its = getattr(one, f.name), getattr(other, f.name)
        expected = mine * (1000 if f.name in lengths else 1)
        np.testing.assert_allclose(its, expected, rtol=1e-4, atol=2e-3 if f.name == "at" else 2e-4, err_msg=f.name)


def test_a_mesh_elsewhere_in_its_frame_is_the_same_elsewhere():
    with sizes():
        moved = cloud(seen_of(cube(middle=(0.3, -0.2, 0.5)), FEW))
    here = cloud(few())
    assert abs(len(moved.at) - len(here.at)) <= 0.05 * len(here.at)
    close = np.linalg.norm((moved.at - [0.3, -0.2, 0.5])[:, None] - here.at[None], axis=2).min(axis=1)
    assert np.median(close) < 1e-4


def test_orb_learns_too():
    here = cloud(seen("orb"))
    assert here.detector == "orb"
    assert here.descriptor.shape[1] == 32
    assert len(here.at) > 20
    assert np.abs(np.abs(here.at).max(axis=1) - SIDE / 2).max() < 0.003


def test_of_what_is_plain_there_are_regions_alone():
    """Its outline, before whatever lies behind: one colour in all cells, large, and no print."""
    with sizes():
        some = seen_of(replace(cube(), texture=np.full((8, 8, 3), (40, 60, 160), np.uint8)), FEW[:3])
    colour = some.descriptor[:, 128:].reshape(len(some), -1, 2)
    regions = (np.abs(colour - colour[:, :1]).max(axis=(1, 2)) == 0) & (some.size > 0.3 * SIDE)
    assert regions.sum() > 10
    assert (~regions).sum() < 0.3 * len(some)


def test_what_nothing_is_seen_of_has_an_empty_cloud():
    some = seen()
    nothing = replace(some, **{f.name: getattr(some, f.name)[:0] for f in fields(some)})
    here = cloud_of(nothing, 0.1, F_REF, COUNT)
    assert here.at.shape == (0, 3)
    assert here.descriptor.shape == (0, 138)
    assert read_cloud(cloud_bytes(here)).descriptor.shape == (0, 138)


def test_the_most_seen_features_are_kept_in_order():
    with sizes():
        few = cloud_of(seen(), SIDE * 3**0.5, F_REF, COUNT, most=20)
    whole = cloud(seen())
    assert len(few.at) == 20
    places = [int(np.flatnonzero((whole.at == at).all(axis=1))[0]) for at in few.at]
    assert places == sorted(places)


def test_a_variant_shows_the_object_before_a_background_that_is_never_the_same():
    view = next(iter(turned(cube(), [even_directions(COUNT)[FEW[0]]], PIXELS[0], MARGIN, AWAY)))
    firsts, seconds, others = (variants(bare(view, PIXELS[1]), np.random.default_rng(seed), 1)[0] for seed in (1, 1, 2))
    for one, again, other in zip(firsts, seconds, others, strict=True):
        check_variant(view, one, again, other)
    busy, calm = (picture[:5].astype(float) for picture in firsts)
    assert calm.std(axis=(0, 1)).max() < 0.5 * busy.std(axis=(0, 1)).min()
    middle = tuple(slice(side // 2 - 3, side // 2 + 3) for side in firsts[0].shape[:2])
    assert np.array_equal(
        firsts[0][middle], firsts[1][middle]
    )  # the object itself is the same in both, its light and noise too


def check_variant(view, one, again, other):
    assert one.dtype == np.uint8
    assert one.shape == (*(round(side * PIXELS[1] / view.pixels) for side in view.image.shape[:2]), 3)
    assert np.array_equal(one, again)
    assert np.abs(one[:5].astype(int) - other[:5]).mean() > 20
    assert EDGE < view.mask.sum() < view.mask.size
