import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from small_kb import OBJECT, write_small
from written_kb import kb_files, write_kb

from kb.files.folder import shipped
from kb.files.read import read_kb
from kb.files.schema import SymmetryModel
from kb.files.write import flow
from kb.files.yaml_text import load
from kb.surfaces.symmetries import motions, symmetry_entries


def assert_same_type(first, second):
    assert (first.name, first.opaque) == (second.name, second.opaque)
    assert list(first.tree.nodes) == list(second.tree.nodes)
    assert list(first.tree.graph.edges) == list(second.tree.graph.edges)
    for edge in first.tree.graph.edges:
        np.testing.assert_allclose(
            first.tree.graph.edges[edge]["parent_from_child"],
            second.tree.graph.edges[edge]["parent_from_child"],
            atol=1e-12,
        )
    for a, b in zip(first.all_features, second.all_features, strict=True):
        assert (a.name, a.type, a.parts) == (b.name, b.type, b.parts)
        np.testing.assert_allclose(a.arms, b.arms, atol=1e-12)
        assert [look.type for look in a.appearances] == [look.type for look in b.appearances]
    for name in ("at", "axis", "cos_half", "r_min", "r_max"):
        np.testing.assert_allclose(getattr(first.lobes, name), getattr(second.lobes, name), atol=1e-12)
    np.testing.assert_allclose(first.surface.vertices, second.surface.vertices, atol=1e-12)
    np.testing.assert_array_equal(first.surface.triangles, second.surface.triangles)
    assert len(first.symmetries) == len(second.symmetries)


@pytest.fixture(params=["towers", "small"])
def folder(request, tmp_path):
    return shipped("towers") if request.param == "towers" else write_small(tmp_path / "small", rules="a :- b.\n")


def test_what_is_written_is_read_back(folder, tmp_path):
    kb = read_kb(folder)
    write_kb(kb, tmp_path / "copy")
    again = read_kb(tmp_path / "copy")
    assert (again.name, again.f_ref, again.appearance_types) == (kb.name, kb.f_ref, kb.appearance_types)
    assert (again.rates, again.rules) == (kb.rates, kb.rules)
    for first, second in zip(kb.types, again.types, strict=True):
        assert_same_type(first, second)


def test_the_second_writing_has_the_same_bytes(folder, tmp_path):
    first = kb_files(read_kb(folder))
    write_kb(read_kb(folder), tmp_path / "copy")
    assert kb_files(read_kb(tmp_path / "copy")) == first
    assert sorted(path.name for path in (tmp_path / "copy").rglob(".*")) == []


@pytest.mark.parametrize(
    "name", ["y", "1e5", "a: b", "\N{GRINNING FACE}", "a\x85b", "a\x7fb", "\ufeffa", "a\u2028b", "'", '"', "\\\\x"]
)
def test_any_text_is_quoted_as_yaml_reads_it(name):
    assert load("f", f"name: {flow(name)}\n".encode()).data == {"name": name}


def test_names_that_yaml_would_read_otherwise_are_quoted(tmp_path):
    text = OBJECT.replace("part: body", "part: 'null'").replace("feature: apex", 'feature: "1: [x] ä"')
    kb = read_kb(write_small(tmp_path / "a", object=text))
    write_kb(kb, tmp_path / "b")
    assert list(read_kb(tmp_path / "b").type("tent").tree.nodes) == list(kb.type("tent").tree.nodes)
    assert "null" in kb.type("tent").tree.nodes


@settings(max_examples=40, deadline=None)
@given(st.lists(st.integers(-5, 5), min_size=3, max_size=3).filter(any), st.integers(2, 12))
def test_turns_about_an_axis_are_written_as_one_fold(axis, fold):
    group = motions([SymmetryModel.model_validate({"axis": axis, "fold": fold})])
    (entry,) = symmetry_entries(group)
    assert entry["fold"] == fold == len(group)
    assert same_motions(group, motions([SymmetryModel.model_validate(entry)]))


def test_a_cubes_24_turns_come_back():
    turns = [SymmetryModel.model_validate({"axis": axis, "fold": 4}) for axis in ([0, 0, 1], [1, 0, 0])]
    group = motions(turns)
    assert len(group) == 24
    assert same_motions(group, motions([SymmetryModel.model_validate(entry) for entry in symmetry_entries(group)]))


def test_a_turn_about_an_axis_beside_the_origin_leaves_its_points():
    group = motions([SymmetryModel.model_validate({"axis": [0, 0, 1], "fold": 2, "at": [1, 2, 0]})])
    np.testing.assert_allclose(group[1] @ [1, 2, 7, 1], [1, 2, 7, 1], atol=1e-12)
    np.testing.assert_allclose(group[1] @ [0, 0, 0, 1], [2, 4, 0, 1], atol=1e-12)
    assert same_motions(group, motions([SymmetryModel.model_validate(entry) for entry in symmetry_entries(group)]))


def test_a_continuous_symmetry_is_sampled():
    group = motions([SymmetryModel.model_validate({"axis": [0, 0, 1], "continuous": True})])
    assert len(group) == 72
    assert symmetry_entries(group) == [{"axis": [0.0, 0.0, 1.0], "fold": 72}]


def same_motions(first, second):
    distance = np.abs(first[:, None] - second[None]).max(axis=(2, 3))
    return len(first) == len(second) and bool(
        (distance.min(axis=0) < 1e-9).all() and (distance.min(axis=1) < 1e-9).all()
    )
