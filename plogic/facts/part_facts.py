"""The part-whole tree of a type as plain facts (§2.5): appearances are no parts."""

from __future__ import annotations

from typing import TYPE_CHECKING

from plogic.facts.hypothesis import PartFact

if TYPE_CHECKING:
    from kb.clouds.cloud import ObjectType


def part_facts(object_type: ObjectType) -> tuple[PartFact, ...]:
    """A fact for every part and feature below the maximal object, in the tree's order."""
    tree = object_type.tree
    facts = []
    for node, attributes in tree.nodes(data=True):
        if node and attributes["kind"] != "appearance":
            (parent,) = tree.predecessors(node)
            facts.append(PartFact(node, parent, attributes["kind"], attributes["type"]))
    return tuple(facts)
