"""Learned features and the parts of their type.

Given by the nearest surface, kept in the file, read with checks, told in the program.
"""

from __future__ import annotations

import io
import zipfile
from dataclasses import replace

import numpy as np
import pytest
from painted_cube import write_cube
from random_cloud import random_cloud
from test_learned_cloud import packed, with_member
from twin_cubes import APART, SIDE, write_twins

from kb.clouds.learned import cloud_bytes, read_cloud
from kb.clouds.words import worded, words_bytes
from kb.errors import CloudError, KBErrors
from kb.files.read import read_kb
from kb.learning.compounds import with_parts
from kb.shown.show import check_report, part_of_features, part_rows, tree_document, tree_text
from plogic.facts.hypothesis import part_facts

PARTS = "parts:\n  - {part: lower, at: [0, 0, 0]}\n  - {part: upper, at: [0, 0, 0.12]}\n"
OBJECT = "object: twins\nmesh: {file: %s, units: m}\n%scloud: {file: cloud.npz}\n"


def spread_cloud(seed=0, features=40):
    """Features about the lower and the upper cube, in turns."""
    at = np.random.default_rng(seed).uniform(-SIDE / 2, SIDE / 2, (features, 3)) + [
        [0, 0, APART * (i % 2)] for i in range(features)
    ]
    return random_cloud(seed, features, 2 * features, at=at)


def write(folder, cloud, parts=PARTS, mesh_of=write_twins):
    """A knowledge base with one learned type; its mesh's file is returned in its object.yaml."""
    words, named = worded({"twins": cloud})
    (folder / "kb.yaml").write_text("name: one\nappearance_types: []\nwords: {file: words.npz}\n")
    (folder / "words.npz").write_bytes(words_bytes(words))
    place = folder / "objects" / "twins"
    place.mkdir(parents=True)
    mesh = mesh_of(place)
    (place / "object.yaml").write_text(OBJECT % (mesh.name, parts))
    (place / "cloud.npz").write_bytes(cloud_bytes(named["twins"]))
    return folder


def kind_of(folder):
    (kind,) = read_kb(folder).types
    return kind


@pytest.fixture
def kind(tmp_path):
    """The twins, whose features know their parts."""
    for name in ("bare", "kb"):
        (tmp_path / name).mkdir()
    bare = kind_of(write(tmp_path / "bare", spread_cloud()))
    return kind_of(write(tmp_path / "kb", with_parts(bare, bare.learned)))


def test_each_feature_belongs_to_the_part_that_is_nearest(kind):
    assert [f.name for f in kind.features[:3]] == ["lower/f0001", "upper/f0002", "lower/f0003"]
    assert kind.learned.part.tolist() == [1, 2] * 20
    rows = part_rows(kind)
    assert [(row["name"], row["under"], sum(row["counts"].values())) for row in rows] == [
        ("twins", None, 0),
        ("lower", 0, 20),
        ("upper", 0, 20),
    ]
    assert part_of_features(kind) == [1, 2] * 20


def test_the_parts_are_a_tree_and_facts_of_the_program(kind):
    assert kind.tree.nodes["lower"].above == kind.tree.nodes["upper"].above == ""
    assert [(fact.id, fact.parent, fact.kind) for fact in part_facts(kind)] == [
        ("lower", "", "object"),
        ("upper", "", "object"),
    ]


def test_they_are_shown(kind, tmp_path):
    kb = read_kb(tmp_path / "kb")
    text = tree_text(kb)
    assert (
        "  object lower at [0, 0, 0], 20 learned features\n  object upper at [0, 0, 0.12], 20 learned features\n"
        in text
    )
    (document,) = tree_document(kb)["types"]
    assert [(node["id"], node["learned_features"]) for node in document["nodes"]] == [
        ("", 0),
        ("lower", 20),
        ("upper", 20),
    ]
    assert not any("none of its parts" in line for line in check_report(kb))


@pytest.mark.parametrize(
    ("parts", "expected"),
    [
        ("parts:\n  - {part: upper, at: [0, 0, 0.12]}\n  - {part: lower, at: [0, 0, 0]}\n", ["lower", "upper"]),
        ("parts:\n  - {part: a, at: [0, 0, 0.01]}\n  - {part: b, at: [0, 0, 0.1]}\n", ["a", "b"]),
        (
            "parts: [{part: c, at: [0, 0, 0.1], parts: [{part: a, at: [0, 0, -0.1]}, {part: b, at: [0, 0, 0.02]}]}]\n",
            ["c/a", "c/b"],
        ),
        ("parts: [{part: a, at: [0, 0, 0]}]\n", ["a", "a"]),
        ("parts: [{part: a, at: [0, 0, 0]}, {part: b, at: [0, 0, 0.12]}, {part: far, at: [9, 9, 9]}]\n", ["a", "b"]),
        ("", ["", ""]),
    ],
    ids=["reordered", "moved a little", "nested", "one taken out", "one more", "none"],
)
def test_parts_are_known_by_their_places_whatever_the_author_makes_of_them(tmp_path, parts, expected):
    bare = kind_of(write(tmp_path, spread_cloud(), parts))
    (tmp_path / "objects/twins/cloud.npz").write_bytes(cloud_bytes(with_parts(bare, bare.learned)))
    assert [f.name.rpartition("/")[0] for f in kind_of(tmp_path).features[:2]] == expected


def test_a_mesh_in_one_piece_leaves_the_places_to_tell_parts_apart(tmp_path):
    bare = kind_of(write(tmp_path, spread_cloud(), mesh_of=write_cube))
    assert with_parts(bare, bare.learned).part[:2].tolist() == [1, 2]


def test_a_file_of_a_type_without_parts_has_no_array_of_them():
    cloud = random_cloud()
    assert "part.npy" not in zipfile.ZipFile(io.BytesIO(cloud_bytes(cloud))).namelist()
    assert read_cloud(cloud_bytes(cloud)).part.tolist() == [0] * 6
    other = replace(cloud, part=np.array([0, 1, 2, 0, 1, 2]))
    assert read_cloud(cloud_bytes(other)).part.tolist() == [0, 1, 2, 0, 1, 2]


@pytest.mark.parametrize("wrong", [np.arange(5), np.zeros((6, 1), int), np.zeros(6), np.full(6, -1)])
def test_parts_that_cannot_be(wrong):
    with pytest.raises(CloudError, match="part: "):
        read_cloud(with_member("part", packed(wrong)))


def test_a_cloud_with_parts_that_the_type_does_not_have_is_a_mistake(tmp_path):
    folder = write(tmp_path, replace(spread_cloud(), part=np.arange(40) % 4))
    with pytest.raises(
        KBErrors, match=r"object\.yaml:6:1: cloud: knows 3 parts, where there are 2: learn the type again"
    ):
        read_kb(folder)


def test_an_old_cloud_of_a_type_with_parts_is_read_and_noted(tmp_path):
    folder = write(tmp_path, spread_cloud())
    assert kind_of(folder).features[0].name == "f0001"
    assert "note: twins: its learned features belong to none of its parts: learn it again" in check_report(
        read_kb(folder)
    )


def test_parts_with_features_of_their_own_and_a_cloud_are_a_mistake(tmp_path):
    by_hand = "parts:\n  - {part: a, features: [{feature: f, type: t, at: [0, 0, 0]}]}\n"
    with pytest.raises(KBErrors, match="learned or written by hand: with cloud there are no features"):
        read_kb(write(tmp_path, spread_cloud(), by_hand))
