"""What a detector is asked for: the appearance types that some feature may look like, and all words."""

from __future__ import annotations

from functools import cache

import networkx as nx
import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from random_cloud import random_cloud, random_words

from kb.clouds.cloud import KnowledgeBase, ObjectType, Rates
from kb.files.folder import shipped
from kb.files.read import learned_features, learned_lobes, read_kb


@cache
def towers():
    return read_kb(shipped("towers"))


def with_types(appearance_types, types, words=None):
    return KnowledgeBase("some", types, appearance_types, Rates({}, {}, {}), 600.0, "", "", words=words)


@settings(max_examples=30, deadline=None, derandomize=True)
@given(st.permutations([*towers().appearance_types, "apriltag/1", "blob/red"]), st.sets(st.sampled_from(["t1", "t2"])))
def test_only_what_some_feature_may_look_like_is_sought_in_the_vocabularys_order(order, names):
    types = tuple(towers().type(name) for name in sorted(names))
    used = {a.type for kind in types for f in kind.features for a in f.appearances}
    assert with_types(tuple(order), types).sought == tuple(name for name in order if name in used)


def test_all_words_are_sought_also_those_that_no_feature_has():
    words = random_words(count=7)
    cloud = random_cloud(lobe_word=np.full(11, 3))
    features = learned_features(cloud, words)
    arrays = {"symmetries": np.eye(4)[None], "learned": cloud, "learned_lobes": learned_lobes(cloud, words)}
    kind = ObjectType("thing", nx.DiGraph(), features, features, None, opaque=True, **arrays)
    kb = with_types(("patch", *words.names, "corner"), (kind,), words)
    assert kb.sought == tuple(words.names)
    assert with_types(("patch", "corner"), ()).sought == ()


def test_the_towers_are_asked_for_all_their_own():
    kb = towers()
    assert set(kb.sought) == {name for kind in kb.types for name in kind.lobes.types} <= set(kb.appearance_types)
