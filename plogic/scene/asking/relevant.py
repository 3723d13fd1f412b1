"""The part of a situation that a goal is about: the hypotheses that it names, and all that hang together with them.

Hypotheses hang together if one can hide a feature of the other or some of its pixels, if they share an appearance, are
rivals, exclude each other, compete for one instance, carry something together, or stand on what the image has one
choice of. Worlds are products over such parts, so that probabilities and explanations of a goal about one part are
those of the part alone.
"""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Any

from plogic.facts.situation import Situation
from plogic.facts.spatial import linked
from plogic.facts.stances import Support
from plogic.facts.vocabulary import VOCABULARY
from plogic.logic.safety.author import load_problog, observes
from plogic.scene.text.program_text import added_to

WHOSE = {
    "cause/3": (1,),
    "feature/3": (0,),
    "expected/2": (0,),
    "detected/2": (0,),
    "case/3": (0,),
    "ev/2": (0,),
    "part/2": (1,),
    "stands_on/2": (0,),
    "stance/3": (0,),
    "rests_on/2": (0,),
}
"""Predicates that speak of the hypothesis at this place, whatever stands at their other places."""


def relevant(situation: Situation, goals: Sequence[str]) -> Situation:
    """The part that the goals are about.

    All of it where a goal is about all, or calls a rule of the author's, or cannot be read, and where the author
    observes or constrains.
    """
    added = added_to(situation)
    if added is not None and any(observes(piece.text, piece.file) for piece in added.pieces()):
        return situation
    found = [_named(goal, situation) for goal in goals]
    if None in found:
        return situation
    named: set[str] = set().union(*filter(None, found))
    kept = _together(situation, named)
    return situation if len(kept) == len(situation.hypotheses) else _part(situation, kept, named)


def _named(goal: str, situation: Situation) -> set[str] | None:
    """The hypotheses and appearances that a goal names; None if it may be about others too."""
    load_problog()
    from plogic.logic.safety.check import glanced

    source = glanced(goal.rstrip().removesuffix(".") + "\n.", "goal")
    if source is None:
        return None
    ids = {h.id for h in situation.hypotheses} | {a.id for a in situation.appearances}
    found = [_of_atom(atom, ids) for statement in source.statements for atom in _atoms(statement)]
    return None if None in found else set().union(*filter(None, found))


def _atoms(goal: Any) -> Iterator[Any]:  # noqa: ANN401 - a term of ProbLog's
    if getattr(goal, "signature", None) in (",/2", ";/2", "\\+/1", "not/1"):
        for argument in goal.args:
            yield from _atoms(argument)
    else:
        yield goal


def _of_atom(atom: Any, ids: set[str]) -> set[str] | None:  # noqa: ANN401 - a term of ProbLog's
    from plogic.logic.safety.mapping import label_of

    signature = getattr(atom, "signature", "")
    if signature not in {f"{entry.name}/{entry.arity}" for entry in VOCABULARY}:
        return None
    places = [atom.args[i] for i in WHOSE.get(signature, ())] or ([atom] if atom.is_ground() else [])
    if not places or not all(place.is_ground() for place in places):
        return None
    labels = [label_of(part) for place in places for part in _inside(place)]
    return ({label.split("/")[0] for label in labels if label is not None} & ids) or None


def _inside(term: Any) -> Iterator[Any]:  # noqa: ANN401 - a term of ProbLog's
    yield term
    for argument in getattr(term, "args", ()):
        yield from _inside(argument)


def _together(situation: Situation, named: set[str]) -> set[str]:
    """The ids of all hypotheses that hang together with what is named."""
    ids = {h.id for h in situation.hypotheses}
    import networkx as nx  # not at the start of every command

    links = nx.Graph([*situation.overlaps, *situation.rivals, *situation.exclusive])
    links.add_edges_from((x, other) for x, *others in situation.space.on_both for other in others)  # y may hang on z
    links.add_edges_from(() if situation.gravity is None else linked(situation.gravity))
    links.add_edges_from(pair for fact in situation.evidence for pair in fact.pairs)
    links.add_edges_from(() if situation.support is None else _standing(situation.support))
    for h in situation.hypotheses:
        links.add_edge(h.id, f"group {h.group}")
        if situation.support is not None and situation.reading == "posterior":
            links.add_edge(h.id, "support")  # one choice of a plane, which all speak of
        links.add_edges_from((h.id, other) for f in h.features for other in f.hidden_by)
        if h.pixel_table is not None and situation.reading == "posterior":
            links.add_edges_from((h.id, other) for other in h.pixel_table.occluders)
        links.add_edges_from((h.id, f"datum {f.match}") for f in h.features if f.match is not None)
    start = {name if name in ids else f"datum {name}" for name in named}
    return set().union(*[part for part in nx.connected_components(links) if not start.isdisjoint(part)]) & ids


def _standing(support: Support) -> Iterator[tuple[str, str]]:
    """Who may stand on whom."""
    planes = {plane.name for plane in support.planes}
    return ((s.hypothesis, s.on) for s in support.stances if s.on not in planes)


def _part(situation: Situation, kept: set[str], named: set[str]) -> Situation:
    part = restricted(situation, kept)
    data = {f.match for h in part.hypotheses for f in h.features} | named
    return replace(part, appearances=tuple(a for a in situation.appearances if a.id in data), rules="", own=None)


def restricted(situation: Situation, kept: set[str]) -> Situation:
    """The situation with some of its hypotheses: all pairs, relations, space and gravity are among those."""

    def inside(pairs: frozenset[tuple[str, str]]) -> frozenset[tuple[str, str]]:
        return frozenset(pair for pair in pairs if kept.issuperset(pair))

    return replace(
        situation,
        hypotheses=tuple(
            h if h.pixel_table is None else h.told(pixel_table=h.pixel_table.among(kept))
            for h in situation.hypotheses
            if h.id in kept
        ),
        overlaps=inside(situation.overlaps),
        rivals=inside(situation.rivals),
        exclusive=inside(situation.exclusive),
        relations=tuple(r for r in situation.relations if kept.issuperset((r.x, r.y))),
        space=situation.space.among(kept),
        gravity=None if situation.gravity is None else situation.gravity.among(kept),
        support=None if situation.support is None else situation.support.among(kept),
        part_relations=tuple(r for r in situation.part_relations if kept.issuperset((r.x, r.y))),
        evidence=tuple(fact.among(frozenset(kept)) for fact in situation.evidence),
    )
