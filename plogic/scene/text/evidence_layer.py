"""Relations by evidence in the program (§8 of the paper, last paragraph): how hypotheses stand as detections tell.

``0.9::stands(e1/1); 0.1::stands(e1/2).`` is one alternative, of what is said of one hypothesis and others jointly;
``said_roc(e1/1, partially_occludes_po, h2, h1).`` says what holds in a state of it.
"""

from collections.abc import Iterator

from geometry.visibility.roc import Roc
from plogic.base.bounds import alternative
from plogic.facts.situation import both_ways, pair_facts
from plogic.scene.text.layout import Writer, disjunction, number

SAID = "totally_occludes", "partially_occludes", "mutually_occludes", "non_occludes"
"""The coarse relations of the vocabulary; the others are their converses."""


def evidence_choices(w: Writer) -> Iterator[str]:
    """One alternative each of how hypotheses stand, by what is detected."""
    for i, fact in enumerate(w.scene.situation.evidence, 1):
        pairs = "; ".join(w.atoms(*pair) for pair in fact.pairs)
        yield f"% How they stand to each other by what is detected, jointly: {pairs or 'no pair'}."
        shares = alternative([share for share, _ in fact.states])
        yield disjunction([(number(p), f"stands(e{i}/{n})") for n, p in enumerate(shares, 1) if p > 0])


def evidence_facts(w: Writer) -> Iterator[str]:
    """What holds in each state, and of which pairs nothing else says it."""
    for i, fact in enumerate(w.scene.situation.evidence, 1):
        for x, y in fact.pairs if fact.withheld else ():
            yield f"{w.fact('unposed', x, y)} {w.fact('unposed', y, x)}"
        for n, (_, relations) in enumerate(fact.states, 1):
            for pair, relation in zip(fact.pairs, relations, strict=True):
                yield from _said(w, f"e{i}/{n}", pair, relation)


def evidence_rules(w: Writer) -> Iterator[str]:
    """Where poses are withheld, relations are those by evidence."""
    if w.scene.situation.withheld:
        yield "% Where nobody knows a pose, relations are those by evidence."
        yield "unposed(_, _) :- fail."
        yield "roc(R, X, Y) :- unposed(X, Y), evidence_roc(R, X, Y)."
        yield from (f"{name}(X, Y) :- unposed(X, Y), evidence_relation({name}, X, Y)." for name in SAID)


def _said(w: Writer, state: str, pair: tuple[str, str], relation: Roc) -> Iterator[str]:
    """``said_relation(e1/1, partially_occludes, h2, h1).``, then the relations of ROC-20 both ways."""
    opaque = w.scene.by_id[pair[0]].opaque, w.scene.by_id[pair[1]].opaque
    for r in pair_facts(relation, *pair, opaque=opaque):
        yield f"said_relation({state}, {w.atoms(r.relation, r.x, r.y)})."
        orders = (r.x, r.y), (r.y, r.x)
        yield from (f"said_roc({state}, {w.atoms(fine, *o)})." for fine, o in zip(both_ways(r), orders, strict=False))
