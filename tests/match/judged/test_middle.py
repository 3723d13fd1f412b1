"""The middle of a posed object, and the four cases that its arrays count."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from learned_scenes import gamma_at, one_sided, pose_before, ready
from made_meshes import CORNERS, box_triangles
from synthetic import CAMERA, camera_pose, towers

from geometry.frames import transform_points
from kb.surfaces.surface import Surface
from plogic.match.gamma.data import data_of
from plogic.match.judged.expectation import pose_of
from plogic.match.learned.learned_match import pose_of as learned_pose_of
from plogic.measures.explanatory import case_of

EMPTY = data_of([], CAMERA)


def posed_tower(name, seed):
    return pose_of(towers().type(name), camera_pose(np.random.default_rng(seed)), EMPTY, towers())


@settings(max_examples=20, deadline=None, derandomize=True)
@given(st.integers(0, 999), st.sampled_from(["t1", "t2"]))
def test_it_is_the_middle_of_the_surface_wherever_the_object_is(seed, name):
    posed = posed_tower(name, seed)
    surface = towers().type(name).surface
    assert posed.middle.tolist() == pytest.approx(
        transform_points(posed.camera_from_object, surface.centre[None])[0].tolist()
    )
    back = np.linalg.inv(posed.camera_from_object) @ [*posed.middle, 1.0]
    assert back[:3] == pytest.approx(surface.centre)


@settings(max_examples=20, deadline=None, derandomize=True)
@given(st.integers(0, 999), st.integers(1, 9))
def test_without_a_surface_it_is_that_of_the_features_box(seed, count):
    thing, pose = ready(one_sided(seed, count)), pose_before(np.random.default_rng(seed))
    posed = learned_pose_of(thing.index, pose, gamma_at(thing.cloud, [], pose), thing.kb)
    low, high = ([extreme(at[axis] for at in posed.at.tolist()) for axis in range(3)] for extreme in (min, max))
    assert posed.middle.tolist() == pytest.approx([(a + b) / 2 for a, b in zip(low, high, strict=True)])
    boxed = ready(thing.cloud, Surface((CORNERS - 0.25) * 0.3, box_triangles()))
    posed = learned_pose_of(boxed.index, pose, gamma_at(thing.cloud, [], pose), boxed.kb)
    assert posed.middle == pytest.approx(transform_points(pose, np.full((1, 3), 0.075))[0])


@settings(max_examples=40, deadline=None, derandomize=True)
@given(st.integers(0, 999), st.sampled_from(["t1", "t2"]), st.booleans())
def test_the_support_is_the_tally_of_a_loop(seed, name, occluded):
    rng, posed = np.random.default_rng(seed), posed_tower(name, 1)
    count = len(posed.uv)
    arrays = {key: rng.random(count) < 0.6 for key in ("in_image", "in_lobe", "self_hidden")}
    posed = replace(posed, **arrays, matches=rng.integers(-1, 2, count))
    hidden = rng.random(count) < 0.3 if occluded else None
    counts = {}
    for f, feature in enumerate(posed.object_type.features):
        if arrays["in_image"][f]:
            expected = bool(posed.candidate[f]) and not (occluded and hidden[f])
            cell = counts.setdefault(feature.type, dict.fromkeys("ACBD", 0))
            cell[case_of(expected=expected, detected=bool(posed.matches[f] >= 0))] += 1
    support = posed.support(hidden)
    assert list(support) == sorted(counts)
    assert {name: vars(cells) for name, cells in support.items()} == counts


def test_the_codes_of_types_name_each_features_type():
    assert [kind.name for kind in towers().types] == ["t1", "t2"]
    for kind in towers().types:
        names, code = kind.kind_codes
        assert list(names) == sorted({f.type for f in kind.features})
        assert [names[c] for c in code] == [f.type for f in kind.features]
