"""The tree: A1, A2, D1-D3, places, features."""

import networkx as nx
import numpy as np
import pytest
from hypothesis import given, settings
from kb_trees import feature, part, seen, trees, turn

from geometry.frames import compose, is_rigid
from kb.clouds.lobes import (
    Branch,
    build_tree,
    features_of,
    place,
    tree_mistakes,
)
from kb.errors import TreeError


def tower(*more: Branch) -> Branch:
    arms = [(1.0, 0, 0)]
    return part(
        "tower",
        part("body", feature("foot", at=(1, 0, 0))),
        part("roof", feature("apex", "apex", at=(0, 1, 0.5), arms=arms), at=(0, 0, 2), rotation=turn(2, np.pi / 2)),
        *more,
    )


def test_nodes_are_named_by_their_paths():
    tree = build_tree(tower())
    assert (
        list(tree.nodes)
        == list(tree.graph)
        == ["", "body", "body/foot", "body/foot#0", "roof", "roof/apex", "roof/apex#0"]
    )
    assert tree.nodes["roof"].type == tree.graph.nodes["roof"]["type"] == "roof"
    assert list(tree.graph.successors("roof")) == list(tree.nodes["roof"].below) == ["roof/apex"]
    assert tree.nodes["roof/apex#0"].viewpoint.half_angle == 1.0
    assert nx.is_arborescence(tree.graph)


def test_steps_add_with_the_local_rotations():
    tree = build_tree(tower())
    assert place(tree, "roof/apex")[:3, 3] == pytest.approx([-1, 0, 2.5])
    (_, apex), _ = features_of(tree)
    assert apex.name == "roof/apex"
    assert apex.at == pytest.approx([-1, 0, 2.5])
    assert apex.arms == pytest.approx(np.array([[0, 1, 0]]))
    assert apex.rotation @ apex.appearances[0].lobe.axis == pytest.approx([0, 0, 1])


def test_a_compound_counts_once_and_looks_like_its_parts():
    pair = feature("pair", "pair", parts=[feature("a"), feature("b", rotation=turn(0, np.pi / 2))])
    maximal, every = features_of(build_tree(part("thing", pair)))
    assert [f.name for f in maximal] == ["pair"]
    assert [f.name for f in every] == ["pair", "pair/a", "pair/b"]
    assert maximal[0].parts == ("pair/a", "pair/b")
    assert [a.lobe.axis.round(9).tolist() for a in maximal[0].appearances] == [[0, 0, 1], [0, -1, 0]]


MIXED = part("x", part("roof"), feature("apex"))
LOOP: list[Branch] = []
SELF = Branch("object", "x", "x", parts=LOOP)
LOOP.append(SELF)


@pytest.mark.parametrize(
    ("root", "where", "message"),
    [
        (MIXED, (), "A1: the parts of 'x' must be all of one kind"),
        (part("x", part("y", feature("f", parts=[feature("g"), seen()]))), (0, 0), "A1: the parts of 'f'"),
        (part("x", seen()), (), "A1: object 'x' may hold object or feature, not appearance"),
        (part("x", feature("f", parts=[part("o")])), (0,), "A1: feature 'f' may hold"),
        (SELF, (0,), "A2: 'x' is a part of itself"),
        (part("x", feature("f"), feature("f")), (1,), "'f' is the name of another feature of 'x'"),
        (part("x", part("p", feature("f")), part("p", feature("f"))), (1,), "'p' is the name of another part of 'x'"),
        (part("x", feature("f/g")), (0,), "neither empty nor hold"),
        (part("x", feature("f", "")), (0,), "D1: feature 'f' must have a type"),
        (part("x", feature("f", at=(0, np.nan, 0))), (0,), "A2: 'f' must stand at 3 finite"),
        (part("x", feature("f", at=(0, 0))), (0,), "A2: 'f' must stand at 3 finite"),
        (part("x", feature("f", rotation=2 * np.eye(3))), (0,), "A2: 'f' must stand at 3 finite"),
        (feature("f"), (), "D3: the maximal object must be an object"),
    ],
)
def test_each_rule_is_held_and_says_where(root, where, message):
    found = dict(tree_mistakes(root))
    assert message in found[where]
    with pytest.raises(TreeError, match=r"A1|A2|D1|D3|name"):
        build_tree(root)


def test_all_mistakes_are_found_at_once():
    root = part("x", feature("", at=(0, 0)), feature("f"), feature("f"))
    assert [where for where, _ in tree_mistakes(root)] == [(2,), (0,), (0,)]


def test_a_part_at_its_parents_own_place_is_legal():
    assert tree_mistakes(part("x", part("y", at=(0, 0, 0)))) == []


def test_a_place_of_no_node_is_an_error():
    with pytest.raises(TreeError, match="'attic'"):
        place(build_tree(tower()), "attic")


@given(trees())
@settings(max_examples=60, deadline=None)
def test_laws_of_trees(root):
    tree = build_tree(root)
    assert nx.is_arborescence(tree.graph)
    assert is_rigid(place(tree, ""))
    for parent, child, step in tree.graph.edges(data="parent_from_child"):
        assert place(tree, child) == pytest.approx(compose(place(tree, parent), step), abs=1e-9)
    maximal, every = features_of(tree)
    inner = {name for f in every for name in f.parts}
    assert {f.name for f in maximal} | inner == {f.name for f in every}
    assert not {f.name for f in maximal} & inner
