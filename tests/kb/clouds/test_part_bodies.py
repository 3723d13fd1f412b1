"""The bodies of parts: what of the type's surface is which part's (§3.5)."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from kb.clouds import cloud
from kb.clouds.lobes import Branch, build_tree, features_of
from kb.files.folder import shipped
from kb.files.read import read_kb


@pytest.fixture(scope="module")
def towers():
    return {kind.name: kind for kind in read_kb(shipped("towers")).types}


@pytest.mark.parametrize("name", ["t1", "t2"])
def test_parts_share_the_surface_without_sharing_a_facet(towers, name):
    kind = towers[name]
    bodies = kind.part_bodies
    assert list(bodies) == ["body", "roof"]
    corners = [{row.tobytes() for row in body.vertices[body.triangles]} for body in bodies.values()]
    whole = {row.tobytes() for row in kind.surface.vertices[kind.surface.triangles]}
    assert not corners[0] & corners[1]
    assert corners[0] | corners[1] == whole


def test_the_pyramids_roof_is_its_four_sides(towers):
    roof = towers["t2"].part_bodies["roof"]
    top = towers["t2"].surface.vertices[:, 2].max()
    assert len(roof.triangles) == 4
    assert np.allclose(roof.vertices[roof.triangles][:, :, 2].max(axis=1), top)


def test_a_part_of_a_part_is_part_of_its_body(towers):
    kind = towers["t2"]
    apex = next(f for f in kind.features if f.name == "roof/apex")
    leaf = Branch("object", "tip", "tip", apex.at, parts=[Branch("feature", "apex", "apex")])
    foot = Branch("object", "foot", "foot", parts=[Branch("feature", "corner", "corner")])
    tree = build_tree(Branch("object", "t2", "t2", parts=[Branch("object", "roof", "roof", parts=[leaf]), foot]))
    features, everything = features_of(tree)
    nested = replace(kind, tree=tree, features=features, all_features=everything).part_bodies
    assert set(nested) == {"roof", "roof/tip", "foot"}
    assert np.array_equal(nested["roof"].vertices, nested["roof/tip"].vertices)
    assert len(nested["roof"].triangles) + len(nested["foot"].triangles) == len(kind.surface.triangles)


def test_without_a_surface_or_without_parts_there_are_no_bodies(towers):
    kind = towers["t1"]
    assert replace(kind, surface=None).part_bodies == {}
    alone = build_tree(Branch("object", "t1", "t1", parts=[Branch("feature", "corner", "corner")]))
    assert replace(kind, tree=alone).part_bodies == {}


@given(st.integers(0, 2**32 - 1), st.integers(1, 60), st.integers(1, 20))
def test_of_many_a_tree_finds_what_all_distances_find(seed, points, places):
    rng = np.random.default_rng(seed)
    at, spots = rng.integers(0, 4, (points, 3)) * 0.1, rng.integers(0, 4, (places, 3)) * 0.1  # many are equally near
    few, cloud.FEW = cloud.FEW, 0
    try:
        by_tree = cloud._nearest(at, spots)
    finally:
        cloud.FEW = few
    assert by_tree.tolist() == cloud._nearest(at, spots).tolist()
