"""Layer 3 of the program in the score reading: the choices that make P(present(H) | its occluders) = P(ev) (§8)."""

from __future__ import annotations

from typing import TYPE_CHECKING

from plogic.base.bounds import alternative
from plogic.scene.readings.score_reading import lifted_smoothing
from plogic.scene.text.contexts import accepted_given, context_clauses, contexts, listed
from plogic.scene.text.layout import disjunction, number

if TYPE_CHECKING:
    from collections.abc import Iterator

    from plogic.facts.hypothesis import Hypothesis
    from plogic.scene.text.layout import Writer

FALLBACKS = """alone(_) :- fail. ok(_, _) :- fail. pick(_, _) :- fail. luck(_, _) :- fail.
member_of(_, _) :- fail. joint(_, _, _) :- fail. includes(_, _) :- fail."""


def choices(w: Writer) -> Iterator[str]:
    """One alternative per hypothesis, or per cyclic component."""
    yield FALLBACKS
    for number_of_block, block in enumerate((b for b in w.graph.blocks if len(b) > 1), start=1):
        yield from _joint(w, f"block({number_of_block})", block)
    cyclic = {name for block in w.graph.blocks if len(block) > 1 for name in block}
    for h in w.scene.situation.hypotheses:
        if h.id not in cyclic:
            yield from _alone(w, h)


def _alone(w: Writer, h: Hypothesis) -> Iterator[str]:
    yield ""
    yield w.fact("alone", h.id)
    yield from _dropping(w, h) if w.scene.situation.reconsider == "drop" else _picking(w, h)


def _picking(w: Writer, h: Hypothesis) -> Iterator[str]:
    """``dv_F/Σdv::pick(H, F)`` over the features in the image."""
    seen = [f for f in h.features if f.in_image]
    shares = alternative([f.dv for f in seen])
    if not shares:
        yield f"% {w.names.atom(h.id)}: no feature in the image, or every dv is 0: ev is undefined, never present."
        return
    heads = [(p, f"pick({w.feature(h, f)})") for p, f in zip(shares, seen, strict=True) if p > 0]
    yield disjunction(heads)
    epsilon = lifted_smoothing(w.scene)
    if epsilon > 0:
        atom = w.names.atom(h.id)
        yield disjunction(
            [(epsilon, f"luck({atom}, yes)"), (epsilon, f"luck({atom}, no)"), (1 - 2 * epsilon, f"luck({atom}, as_is)")]
        )


def _dropping(w: Writer, h: Hypothesis) -> Iterator[str]:
    """``P(ev)::ok(H, Context)`` for each set of accepted occluders."""
    for context in contexts(listed(w, h)):
        yield f"{number(accepted_given(w, h, context))}::ok({w.names.atom(h.id)}, {w.list(context)})."


def _joint(w: Writer, key: str, block: tuple[str, ...]) -> Iterator[str]:
    """One alternative over the joint states S, weight Π_{h∈S} p_h(S) · Π_{h∉S} (1 − p_h(S)), for each context of outside occluders."""
    yield ""
    yield f"% {w.atoms(*block)} occlude each other in a cycle: decided jointly."
    outside = w.graph.outside(block)
    yield from (f"member_of({w.names.atom(name)}, {key})." for name in block)
    yield from (f"includes({w.list(state)}, {w.names.atom(name)})." for state in contexts(block) for name in state)
    yield from context_clauses(w, key, outside)
    for context in contexts(outside):
        yield disjunction(_states(w, key, block, context))


def _states(w: Writer, key: str, block: tuple[str, ...], context: tuple[str, ...]) -> list[tuple[float, str]]:
    states = contexts(block)
    weights = [_weight(w, block, state, context) for state in states]
    shares = alternative(weights) or [1.0] + [0.0] * (len(states) - 1)  # no stable state: none of them is accepted
    return [(p, f"joint({key}, {w.list(context)}, {w.list(s)})") for p, s in zip(shares, states, strict=True) if p > 0]


def _weight(w: Writer, block: tuple[str, ...], state: tuple[str, ...], context: tuple[str, ...]) -> float:
    weight = 1.0
    for name in block:
        p = accepted_given(w, w.scene.by_id[name], (*state, *context))
        weight *= p if name in state else 1.0 - p
    return weight
