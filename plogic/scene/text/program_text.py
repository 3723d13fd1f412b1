"""The program text of a situation: four layers, then the evidence (§8).

Making it and running it are two functions; this one makes it.

The text *is* the definition of the semantics: ``plogic.scene.worlds.ranked_worlds`` is tested equal to it. It is
deterministic. Layer 3, the choices, depends on the reading. Score: the choices that make P(present(H) | its occluders)
= P(ev). Posterior: which instance is which hypothesis, what hits, what causes what.
"""

import math
from collections.abc import Iterator
from dataclasses import replace
from itertools import combinations

from plogic.base.bounds import alternative, bounded
from plogic.facts.dependence import Scene, dependence
from plogic.facts.hypothesis import Hypothesis
from plogic.facts.sanity import check
from plogic.facts.situation import Situation, names_of
from plogic.logic.safety.author import FILE, author_rules
from plogic.logic.served.engine import Text
from plogic.scene.readings.unfinished import notice
from plogic.scene.readings.world_weights import group_shares, lifted_smoothing, unmatched
from plogic.scene.text import fact_layers as facts
from plogic.scene.text.evidence_layer import evidence_choices, evidence_facts
from plogic.scene.text.layout import (
    Writer,
    accepted_given,
    block_clauses,
    contexts,
    disjunction,
    ev_facts,
    listed,
    number,
    possible_causes,
    title,
)
from plogic.scene.text.rules import defined, fallbacks, rules, vocabulary_rules


def posterior_choices(w: Writer) -> Iterator[str]:
    """One alternative per instance and per claimed appearance, one hit per candidate feature."""
    yield "hit(_, _) :- fail. chosen(_, _) :- fail. present(_) :- fail."
    yield "% Rivals for one instance are one alternative; the rest of the prior says that there is none."
    for shares in group_shares(w.scene).values():
        yield disjunction([(p, f"present({w.names.atom(name)})") for name, p in shares])
    yield "% Each expected feature is detected with its hit rate."
    for h in w.scene.situation.hypotheses:
        for f in (f for f in h.features if h.expects(f)):
            yield f"{number(bounded(f.hit_rate))}::hit({w.feature(h, f)})."
    yield "% Each claimed appearance has one cause: densities over their sum (bounded, so that ProbLog can read them)."
    for appearance in w.scene.claimants:
        heads = possible_causes(w, appearance)
        nothing = f"% {w.names.atom(appearance)}: every density is 0: nothing can cause it."
        yield disjunction(heads) if heads else nothing


def posterior_evidence(w: Writer) -> Iterator[str]:
    """Γ, and what is not in Γ."""
    yield from (f"evidence(explained({w.names.atom(appearance)}))." for appearance in w.scene.claimants)
    for h in w.scene.situation.hypotheses:
        yield from (f"evidence(\\+ missed({w.feature(h, f)}))." for f in unmatched(h))


SCORE_FALLBACKS = """alone(_) :- fail. ok(_, _) :- fail. pick(_, _) :- fail. luck(_, _) :- fail.
member_of(_, _) :- fail. joint(_, _, _) :- fail. includes(_, _) :- fail."""


def score_choices(w: Writer) -> Iterator[str]:
    """One alternative per hypothesis, or per cyclic component."""
    yield SCORE_FALLBACKS
    for number_of_block, block in enumerate((b for b in w.graph.blocks if len(b) > 1), start=1):
        yield from _joint(w, f"block({number_of_block})", block)
    cyclic = {name for block in w.graph.blocks if len(block) > 1 for name in block}
    for h in w.scene.situation.hypotheses:
        if h.id not in cyclic:
            yield from _alone(w, h)


def _alone(w: Writer, h: Hypothesis) -> Iterator[str]:
    yield ""
    yield w.fact("alone", h.id)
    dropping = (  # P(ev) for each set of accepted occluders
        f"{number(accepted_given(w, h, context))}::ok({w.names.atom(h.id)}, {w.list(context)})."
        for context in contexts(listed(w, h))
    )
    yield from dropping if w.scene.situation.reconsider == "drop" else _picking(w, h)


def _picking(w: Writer, h: Hypothesis) -> Iterator[str]:
    """``dv_F/Σdv::pick(H, F)`` over the features in the image."""
    seen = [f for f in h.features if f.in_image]
    shares = alternative([f.dv for f in seen])
    if not shares:
        yield f"% {w.names.atom(h.id)}: no feature in the image, or every dv is 0: ev is undefined, never present."
        return
    yield disjunction([(p, f"pick({w.feature(h, f)})") for p, f in zip(shares, seen, strict=True) if p > 0])
    epsilon = lifted_smoothing(w.scene)
    if epsilon > 0:
        atom = w.names.atom(h.id)
        yield disjunction(
            [(epsilon, f"luck({atom}, yes)"), (epsilon, f"luck({atom}, no)"), (1 - 2 * epsilon, f"luck({atom}, as_is)")]
        )


def _joint(w: Writer, key: str, block: tuple[str, ...]) -> Iterator[str]:
    """One alternative a context of occluders over the joint states S that Σc allows.

    Their weights are Π_{h∈S} p_h(S) · Π_{h∉S} (1 − p_h(S)).
    """
    yield ""
    yield f"% {w.atoms(*block)} occlude each other in a cycle: decided jointly."
    yield from block_clauses(w, key, block)
    for context in contexts(w.graph.outside(block)):
        yield disjunction(_states(w, key, block, context))


def _states(w: Writer, key: str, block: tuple[str, ...], context: tuple[str, ...]) -> list[tuple[float, str]]:
    states = contexts(block)
    weights = [_weight(w, block, state, context) for state in states]
    lawful = [p * w.scene.apart.isdisjoint(combinations(s, 2)) for p, s in zip(weights, states, strict=True)]
    weights = lawful if any(lawful) else weights  # where only such are stable as Σc forbids, its evidence cuts them
    shares = alternative(weights) or [1.0] + [0.0] * (len(states) - 1)  # no stable state: none of them is accepted
    return [(p, f"joint({key}, {w.list(context)}, {w.list(s)})") for p, s in zip(shares, states, strict=True) if p > 0]


def _weight(w: Writer, block: tuple[str, ...], state: tuple[str, ...], context: tuple[str, ...]) -> float:
    accepted = {name: accepted_given(w, w.scene.by_id[name], (*state, *context)) for name in block}
    return math.prod(p if name in state else 1.0 - p for name, p in accepted.items())


def program_text(situation: Situation) -> str:
    """The ProbLog program of the situation, without queries; runs in a stock ``problog``.

    Raises SituationError for a situation that contradicts itself, ProgramError for author's rules that cannot be used.
    """
    check(situation)
    scene = Scene(situation)
    return "\n".join(_lines(Writer(scene, dependence(scene), names_of(situation)))).rstrip() + "\n"


def program_of(situation: Situation) -> Text:
    """The same program in pieces, so that mistakes are told where the author wrote them.

    Its own clauses, the author's rules, and those of who asks.
    """
    return Text(program_text(replace(situation, rules="")), own=added_to(situation))


def added_to(situation: Situation) -> Text | None:
    """The author's rules and those of who asks; None where there are none."""
    return Text(situation.rules, FILE, situation.own) if situation.rules.strip() else situation.own


def query_lines(situation: Situation) -> str:
    """``query(present(h1)).`` for every hypothesis: appended for the stock command line."""
    names = names_of(situation)
    return "".join(f"query(present({names.atom(h.id)})).\n" for h in situation.hypotheses)


def left_out(situation: Situation) -> dict[str, tuple[str, ...]]:
    """Hypothesis → the occluders that the choices do not look at, since at most six are (§8, mode `drop`)."""
    return dependence(Scene(situation)).left_out if situation.reading == "score" else {}


def _lines(w: Writer) -> Iterator[str]:
    situation = w.scene.situation
    is_score = situation.reading == "score"
    mode = f", reconsideration: {situation.reconsider}" if is_score else ""
    yield f"% The possible worlds of one image. Reading: {situation.reading}{mode}. A world is an assignment of present/1."
    if situation.stopped:
        yield f"% {notice(situation.stopped)}."
    yield from facts.label_comments(w)
    yield from ("", title(1, "Σo: the feature-cloud trees of the hypotheses and their part-whole hierarchy"))
    yield from facts.trees(w)
    yield from (
        "",
        title(2, "What geometry computed: poses, visibility, matches, overlaps, outlines; then the measures"),
    )
    yield from facts.geometry(w)
    yield from ev_facts(w)
    yield from evidence_facts(w)
    yield from ("", title(3, "The choices"))
    yield from score_choices(w) if is_score else posterior_choices(w)
    yield from facts.excuses(w)
    yield from evidence_choices(w)
    yield from ("", title(4, "Σc: constraints and definitions D1-D8, free of any object type"))
    yield from ("% Predicates that may have no facts in this image.", fallbacks(), "")
    for block in rules(situation, smoothed=lifted_smoothing(w.scene) > 0):
        yield from (block, "")
    yield from ("% ---- The vocabulary of queries", *vocabulary_rules(situation.reading))
    clauses = author_rules(situation.rules, w.names, defined())
    if clauses:
        yield from ("", "% ---- The rules of the knowledge base's author", *clauses)
    yield from (
        "",
        title(5, "Evidence: no violated constraint" + ("" if is_score else ", Γ, and what is missing in Γ")),
    )
    yield from facts.constraints(w)
    if not is_score:
        yield from posterior_evidence(w)
