"""Learned compounds: kept in the file, read with checks, Feature nodes with Feature parts (A1), and listed."""

from __future__ import annotations

from collections import Counter
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from painted_cube import write_knowledge
from random_cloud import random_cloud, random_words
from test_learned_cloud import packed, with_member
from test_learned_parts import kind_of, spread_cloud, write

from kb.clouds.learned import FORMAT, cloud_bytes, numbered, read_cloud
from kb.clouds.words import worded
from kb.errors import CloudError
from kb.files.read import learned_features, read_kb, with_compounds
from kb.learning.compounds import with_parts
from kb.shown.cautions import learned_summary
from kb.shown.show import check_report, part_rows, tree_document, tree_text
from plogic.measures.distinctiveness import instance_counts

GROUPS = [0, 1, 1, 0, 2, 2, 1, 0]


def grouped_cloud(seed=0, groups=GROUPS, **changed):
    """A random cloud with these compounds."""
    return random_cloud(seed, len(groups), 2 * len(groups), compound=np.array(groups), **changed)


@settings(max_examples=20, deadline=None, derandomize=True)
@given(st.integers(0, 9), st.lists(st.integers(0, 4), min_size=1, max_size=20))
def test_compounds_come_back_from_the_file(seed, groups):
    cloud = grouped_cloud(seed, numbered(np.array(groups)).tolist())
    back = read_cloud(cloud_bytes(cloud))
    assert np.array_equal(back.compound, cloud.compound)
    assert cloud_bytes(back) == cloud_bytes(cloud)
    assert not back.compound.flags.writeable


def test_a_file_without_compounds_is_as_it_was_and_still_read():
    flat = grouped_cloud(1, [0] * 8)
    assert cloud_bytes(flat) == cloud_bytes(random_cloud(1, 8, 16))
    assert read_cloud(cloud_bytes(flat)).compounds == 0
    old = with_member("compound", None, cloud=flat)
    assert read_cloud(old).compound.tolist() == [0] * 8


@pytest.mark.parametrize(
    ("stated", "message"),
    [
        (np.int32(FORMAT + 1), "of a newer plogic"),
        (np.int32(0), "format: "),
        (np.float32(1.5), "format: "),
        (np.ones(2, np.int32), "format: "),
    ],
)
def test_a_file_of_a_newer_or_of_no_format_is_refused(stated, message):
    with pytest.raises(CloudError, match=message):
        read_cloud(with_member("format", packed(stated), cloud=grouped_cloud()))


@pytest.mark.parametrize(
    "wrong",
    [[0, 1, 0, 0, 0, 0, 0, 0], [2, 2, 1, 1, 0, 0, 0, 0], [1, 1, 3, 3, 0, 0, 0, 0], [0, -1, -1, 0, 0, 0, 0, 0], [1, 1]],
)
def test_compounds_that_cannot_be_are_refused(wrong):
    with pytest.raises(CloudError, match="compound: "):
        read_cloud(with_member("compound", packed(np.array(wrong, np.int32)), cloud=grouped_cloud()))


def test_a_compound_in_two_parts_is_refused():
    cloud = grouped_cloud(part=np.array([0, 1, 1, 0, 2, 1, 1, 0]))
    with pytest.raises(CloudError, match="compound: must be of one part"):
        read_cloud(cloud_bytes(cloud))


def test_numbers_count_groups_by_their_first_members_and_leave_out_the_lone():
    assert numbered(np.array([7, 0, 3, 7, 9, 0, 3])).tolist() == [1, 0, 2, 1, 0, 0, 2]
    assert numbered(np.zeros(0, np.int64)).tolist() == []


@settings(max_examples=30, deadline=None, derandomize=True)
@given(st.integers(0, 99), st.lists(st.integers(0, 4), min_size=1, max_size=20))
def test_compounds_are_features_with_feature_parts_and_no_other(seed, groups):
    cloud, words = grouped_cloud(seed, numbered(np.array(groups)).tolist()), random_words()
    seen = learned_features(cloud, words)
    maximal, every = with_compounds(seen, cloud, words)
    by_name = {feature.name: feature for feature in every}
    inner = [name for feature in maximal for name in feature.parts]
    assert len(by_name) == len(every)
    assert not {feature.name for feature in maximal} & set(inner)
    assert {feature.name for feature in maximal} | set(inner) == set(by_name)
    assert {feature.name for feature in seen} == {feature.name for feature in every if not feature.parts}
    assert len(inner) == len(set(inner)) == np.count_nonzero(cloud.compound)
    for compound in (feature for feature in every if feature.parts):
        assert len(compound.parts) >= 2
        assert not compound.appearances
        assert all(not by_name[name].parts and name.startswith(f"{compound.name}/") for name in compound.parts)
        assert compound.at == pytest.approx(np.mean([by_name[name].at for name in compound.parts], axis=0))


def test_a_compound_has_the_word_that_dominates_its_parts():
    cloud = random_cloud(
        0, 3, 4, feature=np.array([0, 1, 1, 2]), lobe_word=np.array([3, 5, 3, 5]), hit=np.array([0.5, 0.7, 0.3, 0.9])
    )
    cloud = replace(cloud, compound=np.array([1, 1, 0]))
    maximal, _ = with_compounds(learned_features(cloud, random_words()), cloud, random_words())
    assert [(f.name, f.type) for f in maximal] == [
        ("c0001", random_words().names[3]),
        ("f0003", random_words().names[cloud.word[2]]),
    ]


def test_words_and_keypoints_keep_the_compounds():
    cloud = grouped_cloud()
    _, named = worded({"thing": cloud})
    assert named["thing"].compound.tolist() == GROUPS
    edges = np.isin(cloud.feature, [1, 2, 6, 7])
    assert replace(cloud, size=np.where(edges, 0.0, cloud.size)).keypoints.compound.tolist() == [0, 0, 1, 1]


@pytest.fixture(scope="module")
def kb(tmp_path_factory):
    return read_kb(write_knowledge(tmp_path_factory.mktemp("compounds"), {"one": grouped_cloud(1)}))


def test_the_type_has_maximal_features_and_every_node_counts_in_s(kb):
    kind = kb.type("one")
    assert [f.name for f in kind.features] == ["f0001", "c0001", "f0004", "c0002", "f0008"]
    assert [f.name for f in kind.seen_features][1] == "c0001/f0002"
    assert kind.whole.tolist() == [0, 1, 1, 2, 3, 3, 1, 4]
    assert len(kind.all_features) == 10
    assert instance_counts([kind]) == dict(sorted(Counter(f.type for f in kind.all_features).items()))
    assert sum(instance_counts([kind]).values()) == 10


def test_lists_say_how_many_compounds_there_are(kb):
    summary = learned_summary(kb.type("one"))
    assert (summary.features, summary.compounds, summary.joined, summary.largest) == (8, 2, 5, 3)
    told = "8 features, 5 of them in 2 compounds of 2 to 3, 16 appearances"
    assert any(told in line for line in check_report(kb))
    assert told in tree_text(kb)
    learned = tree_document(kb)["types"][0]["learnt"]
    assert (learned["compounds"], learned["joined"], learned["largest"]) == (2, 5, 3)
    assert sum(sum(row["counts"].values()) for row in part_rows(kb.type("one"))) == 10


def test_what_of_a_compound_is_in_another_part_is_another_compound(tmp_path):
    (tmp_path / "bare").mkdir()
    (tmp_path / "kb").mkdir()
    groups = numbered(np.repeat([1, 2, 0, 3, 0], 8))
    bare = kind_of(write(tmp_path / "bare", replace(spread_cloud(), compound=groups)))
    kind = kind_of(write(tmp_path / "kb", with_parts(bare, bare.learned)))
    assert kind.learned.compound[:4].tolist() == [1, 2, 1, 2]
    assert kind.learned.compounds == 6
    assert [f.name for f in kind.features[:2]] == ["lower/c0001", "upper/c0002"]
    assert kind.seen_features[0].name == "lower/c0001/f0001"
    assert [sum(row["counts"].values()) for row in part_rows(kind)] == [0, 23, 23]
