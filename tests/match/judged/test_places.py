"""Poses of a type, no two of them in one place: as each is compared with each."""

from __future__ import annotations

import numpy as np
import pytest

from geometry.frames import turn_about
from plogic.match.judged.rivals import Places, distinct_poses, same_place
from plogic.run.sources import kb_of


@pytest.mark.parametrize("name", ["t1", "t2"])
@pytest.mark.parametrize("seed", range(3))
def test_a_place_is_free_where_no_pose_before_is_in_it(name, seed):
    kind, rng = kb_of("towers").type(name), np.random.default_rng(seed)
    poses = np.tile(np.eye(4), (120, 1, 1))
    for i, pose in enumerate(poses):
        axis = rng.normal(size=3)
        pose[:3, :3] = turn_about(axis / np.linalg.norm(axis), rng.uniform(0.0, 0.3) * (i % 3))
        if len(kind.symmetries):
            pose[:3, :3] = pose[:3, :3] @ kind.symmetries[rng.integers(len(kind.symmetries))][:3, :3]
        pose[:3, 3] = np.array([0.0, 0.0, 1.0]) + rng.normal(size=3) * 0.03 * (i % 4)
    kept = []
    for pose in poses:
        if not any(same_place(kind, pose, old) for old in kept):
            kept.append(pose)
    assert 8 < len(kept) < len(poses)
    places = Places(kind)
    assert np.array_equal([pose for pose in poses if places.add(pose)], kept)
    assert np.array_equal(distinct_poses(kind, poses, 5), kept[:5])
    assert len(distinct_poses(kind, poses, 1000)) == len(kept)
