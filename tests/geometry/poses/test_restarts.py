import numpy as np
import pytest
from softposit_scenes import right, scene

from geometry.errors import GeometryError
from geometry.frames import transform_points
from geometry.poses.softposit import random_starts, softposit


def test_with_types_most_random_starts_find_the_pose():
    model, xy, pose, equal, truth, rng = scene(3, types=20, noise=0.5)
    found = softposit(model, xy, random_starts(model, xy, 30, rng, depth=(3, 12)), allowed=equal)
    assert right(found, pose).mean() > 0.8  # seen: 1
    assert (found.matches == truth).all(axis=1).mean() > 0.7  # seen: 1


def test_random_starts_are_seeded_spread_and_within_their_bounds():
    model, xy, _, _, _, _ = scene(12)
    starts = random_starts(model, xy, 500, 7, depth=(2, 8))
    assert np.array_equal(starts, random_starts(model, xy, 500, np.random.default_rng(7), depth=(2, 8)))
    middle = transform_points(starts, model.mean(axis=0)[None])[:, 0]
    assert np.all((middle[:, 2] >= 2) & (middle[:, 2] <= 8))
    seen = middle[:, :2] / middle[:, 2:]
    assert np.all((seen >= xy.min(axis=0) - 1e-9) & (seen <= xy.max(axis=0) + 1e-9))
    assert np.abs(starts[:, :3, :3].mean(axis=0)).max() < 0.12


@pytest.mark.parametrize(("points", "depth"), [(5, (0.0, 2.0)), (5, (3.0, 2.0)), (0, (1.0, 2.0))])
def test_random_starts_need_points_and_depths(points, depth):
    with pytest.raises(GeometryError, match="random starts need"):
        random_starts(np.zeros((points, 3)), np.zeros((4, 2)), 3, 0, depth=depth)
