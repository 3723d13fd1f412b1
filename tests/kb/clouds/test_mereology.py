"""Laws of part and whole over random trees (A3)."""

from itertools import product

import pytest
from hypothesis import given, settings
from kb_trees import feature, part, trees

from kb.clouds.mereology import dr, o, p, pp
from kb.clouds.tree import build_tree
from kb.errors import TreeError


def things(tree):
    return [node for node, kind in tree.nodes(data="kind") if kind != "appearance"][:9]


@given(trees(depth=3))
@settings(max_examples=40, deadline=None)
def test_laws(root):
    tree = build_tree(root)
    assert things(tree)
    for x, y in product(things(tree), repeat=2):
        assert p(tree, x, y) == (pp(tree, x, y) or x == y)
        assert not (pp(tree, x, y) and pp(tree, y, x))
        assert o(tree, x, y) == o(tree, y, x)
        assert dr(tree, x, y) != o(tree, x, y)
        assert o(tree, x, y) or not p(tree, x, y)


@given(trees(depth=3))
@settings(max_examples=40, deadline=None)
def test_proper_parthood_is_transitive_and_irreflexive(root):
    tree = build_tree(root)
    assert things(tree)
    for x, y, z in product(things(tree)[:7], repeat=3):
        assert not pp(tree, x, x)
        assert pp(tree, x, z) or not (pp(tree, x, y) and pp(tree, y, z))


def test_by_example():
    tree = build_tree(part("t", part("roof", feature("apex")), part("body", feature("foot"))))
    assert pp(tree, "roof/apex", "")
    assert pp(tree, "roof/apex", "roof")
    assert not pp(tree, "roof/apex", "body")
    assert dr(tree, "roof", "body")
    assert o(tree, "roof", "")


@pytest.mark.parametrize("relation", [p, pp, o, dr])
@pytest.mark.parametrize("node", ["roof/apex#0", "attic"])
def test_appearances_are_no_parts(relation, node):
    tree = build_tree(part("t", part("roof", feature("apex"))))
    for pair in ((node, "roof"), ("roof", node), (node, node)):
        with pytest.raises(TreeError, match="A3"):
            relation(tree, *pair)
