"""What the view cells show (§6.3): the camera's own projection, the lobes and rays are the oracle."""

from dataclasses import replace

import numpy as np
import pytest
from oriented_scenes import clouds, flat_cap, kb_of, seen_from, with_other_look
from synthetic import perceiver

from geometry.camera import Camera
from geometry.frames import transform_points
from kb.clouds.lobes import in_lobe
from plogic.match.gamma.grid import wrapped
from plogic.match.hand.view_cells import DISTANCE
from plogic.match.oriented.pair_index import sights_of

CELLS = (0, 17, 60, 99, 161)


def indices(which):
    if which == "towers":
        return list(perceiver().models.values())
    if which == "two looks":
        return kb_of(with_other_look(clouds().kb.types[0], "a007")).rows
    if which == "glass":
        return kb_of(replace(clouds().kb.types[1], opaque=False)).rows
    return flat_cap().rows if which == "no surface" else clouds().rows


def sights(rows):
    names = sorted({name for index in rows for name in index.object_type.lobes.types})
    return names, sights_of(rows, {name: i for i, name in enumerate(names)})


def shown(index, cell):
    """The (feature, appearance type) that are seen from the cell's viewpoint: by lobes and rays."""
    kind, table = index.object_type, index.object_type.lobes
    viewpoint = index.cells.centre + DISTANCE * index.cells.diameter * index.cells.directions[cell]
    held = in_lobe(table, viewpoint)[0]
    if kind.surface is not None and kind.opaque:
        held &= ~kind.surface.rays.blocks(viewpoint, table.at, 0.004 * kind.surface.diameter)
    return sorted((int(table.feature[lobe]), table.types[lobe]) for lobe in np.flatnonzero(held))


@pytest.mark.parametrize("which", ["clouds", "towers", "two looks", "glass", "no surface"])
def test_a_cell_shows_what_a_lobe_holds_and_the_surface_does_not_hide(which):
    rows = indices(which)
    names, got = sights(rows)
    total = 0
    for kind, index in enumerate(rows):
        for cell in CELLS:
            there = got.looks[kind, cell] >= 0
            assert (there == (got.feature[kind, cell] >= 0)).all()
            pairs = zip(got.feature[kind, cell][there], got.looks[kind, cell][there], strict=True)
            found = sorted((int(f), names[look]) for f, look in pairs)
            assert found == shown(index, cell)
            total += len(found)
    assert total > 20


@pytest.mark.parametrize("which", ["clouds", "towers", "two looks", "no surface"])
def test_a_sights_place_and_angle_are_those_of_a_picture_from_there(which):
    """A camera at the cell whose focal length is the distance: pixels are metres in the plane through the centre."""
    rows = indices(which)
    got, checked = sights(rows)[1], 0
    for kind, index in enumerate(rows):
        distance = DISTANCE * index.cells.diameter
        camera = Camera(100, 100, np.diag([distance, distance, 1.0]))
        for cell in CELLS:
            pose, some = seen_from(index, cell), np.flatnonzero(got.feature[kind, cell] >= 0)
            features = [index.object_type.features[f] for f in got.feature[kind, cell][some]]
            at = np.array([feature.at for feature in features]).reshape(-1, 3)
            along = np.array([feature.rotation[:, 0] for feature in features]).reshape(-1, 3)
            uv = camera.project(transform_points(pose, at))
            step = camera.project(transform_points(pose, at + 1e-5 * index.cells.diameter * along)) - uv
            clear = np.linalg.norm(step, axis=1) > 1e-7 * index.cells.diameter  # not straight at the camera
            assert np.allclose(got.xy[kind, cell][some], uv, atol=1e-5 * index.cells.diameter)
            turned = wrapped(got.angle[kind, cell][some] - np.arctan2(step[:, 1], step[:, 0]))
            assert np.abs(turned[clear]).max(initial=0.0) < 2e-3
            checked += int(clear.sum())
    assert checked > 20


def test_a_feature_that_looks_two_ways_is_seen_one_way_from_each_side():
    """The lobes are opposite cones of 65 degrees: no viewpoint is in both, and glass shows the far ones too."""
    (index,) = kb_of(replace(with_other_look(clouds().kb.types[0], "a007"), opaque=False)).rows
    names, got = sights([index])
    other = got.looks[0] == names.index("a007")
    assert other.any(axis=1).all()
    for features in got.feature[0]:
        some = features[features >= 0]
        assert len(np.unique(some)) == len(some)


def test_what_a_type_shows_does_not_hang_on_the_others():
    rows = clouds().rows
    assert len(rows) > 1
    names = {
        name: i for i, name in enumerate(sorted({name for index in rows for name in index.object_type.lobes.types}))
    }
    together = sights_of(rows, names)
    for kind, index in enumerate(rows):
        alone = sights_of([index], names)
        wide = alone.feature.shape[2]
        for name in ("feature", "looks", "xy", "angle"):
            assert np.array_equal(getattr(together, name)[kind, :, :wide], getattr(alone, name)[0])
        assert (together.looks[kind, :, wide:] == -1).all()
        assert together.diameter[kind] == alone.diameter[0] == index.cells.diameter
