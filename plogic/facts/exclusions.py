"""Which hypotheses A4 keeps out of each other's worlds, in numbers and words: the volume that they share, and how deep."""

from __future__ import annotations

from typing import TYPE_CHECKING, cast

from plogic.facts.spatial import SharedFact, shared_of, words_of_shared

if TYPE_CHECKING:
    from collections.abc import Mapping

    from plogic.facts.document import Interpretation
    from plogic.facts.fact_rows import ExclusionRow
    from plogic.facts.spatial import Space

LISTED = 5
"""Pairs that are told in words, the deepest first; the others are counted."""


def exclusions(document: Interpretation) -> list[ExclusionRow]:
    """The overlap facts of an interpretation: ``{"args": ["h1", "h3"], "volume": 2.1e-05, "depth": 0.012}``, as far as they are known."""
    return [
        cast("ExclusionRow", {key: value for key, value in fact.items() if key != "fact"})
        for fact in document["facts"]
        if fact["fact"] == "overlap"
    ]


def exclusion_lines(document: Interpretation) -> list[str]:
    """``h1 and h3 are never together (A4): they share 2.1e-05 m3, 12 mm deep``, by depth."""
    shared = sorted(shared_of(document["facts"]), key=lambda s: (-s.depth[1], s.x, s.y))
    names = {h["id"]: f"{h.get('label') or h['type']} {h['id']}" for h in document["hypotheses"]}
    more = (
        [f"{len(shared) - LISTED} more pairs are never together (A4); --json has them all"]
        if len(shared) > LISTED
        else []
    )
    return [_line(fact, names) for fact in shared[:LISTED]] + more


def apart_of(space: Space, types: Mapping[str, str]) -> dict[str, list[str]]:
    """Of each hypothesis (``types``: its type by id) a sentence for each that A4 keeps out of its worlds, the deepest first, a few."""
    told: dict[str, list[str]] = {}
    for fact in sorted(space.shared, key=lambda s: (-s.depth[1], s.x, s.y)):
        for me, other in ((fact.x, fact.y), (fact.y, fact.x)):
            told.setdefault(me, []).append(
                f"Never together with {types[other]} {other} (A4): they share {words_of_shared(fact)}."
            )
    return {name: lines[:LISTED] for name, lines in told.items()}


def _line(fact: SharedFact, names: Mapping[str, str]) -> str:
    return f"{names.get(fact.x, fact.x)} and {names.get(fact.y, fact.y)} are never together (A4): they share {words_of_shared(fact)}"
