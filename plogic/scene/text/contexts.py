"""Sets of present occluders that change a hypothesis' cells, and what P(ev) is in each (§5.5, §8)."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from plogic.facts.dependence import MOST_OCCLUDERS
from plogic.scene.readings.score_reading import acceptance, p_ev
from plogic.scene.text.layout import Writer, number

if TYPE_CHECKING:
    from collections.abc import Iterator

    from geometry.arrays import Mask
    from plogic.facts.hypothesis import Hypothesis


def contexts(names: tuple[str, ...]) -> list[tuple[str, ...]]:
    """Every subset, smallest first."""
    rows = [tuple(n for bit, n in enumerate(names) if i >> bit & 1) for i in range(2 ** len(names))]
    return sorted(rows, key=len)


def listed(w: Writer, h: Hypothesis) -> tuple[str, ...]:
    """The occluders that the contexts of ``h`` are made of: at most six, those that change most cells."""
    return w.graph.of[h.id][:MOST_OCCLUDERS]


def context_clauses(w: Writer, key: str, names: tuple[str, ...]) -> Iterator[str]:
    """One clause per context, which says when it holds: ``context(h1, [h2]) :- present(h2), not present(h3)``."""
    for context in contexts(names):
        literals = [("" if n in context else "\\+ ") + f"present({w.names.atom(n)})" for n in names]
        body = f" :- {', '.join(literals)}" if literals else ""
        yield f"context({key}, {w.list(context)}){body}."


def p_given(w: Writer, h: Hypothesis, context: tuple[str, ...]) -> float | None:
    """P(ev) of ``h`` with exactly the context present; None where it is 0/0."""
    p = float(p_ev(w.scene, h, _columns(w, (*context, h.id)))[0])
    return None if np.isnan(p) else p


def accepted_given(w: Writer, h: Hypothesis, context: tuple[str, ...]) -> float:
    """The label of ok(h, context): smoothed, and 0 where ev is undefined or nothing of ``h`` is detected."""
    return float(acceptance(w.scene, h, _columns(w, context), w.graph.of[h.id])[0])


def _columns(w: Writer, present: tuple[str, ...]) -> dict[str, Mask]:
    return {h.id: np.array([h.id in present]) for h in w.scene.situation.hypotheses}


def ev_facts(w: Writer) -> Iterator[str]:
    """``ev_given(h1, [h2], 0.94).``, with the clauses that say when a context holds; nothing where ev is undefined."""
    for h in w.scene.situation.hypotheses:
        names = listed(w, h)
        rest = [g for g in (*w.graph.of[h.id], *w.graph.left_out.get(h.id, ())) if g not in names]
        if rest:
            yield f"% {w.names.atom(h.id)}: not in these contexts: {', '.join(w.names.atom(g) for g in rest)}"
        yield from context_clauses(w, w.names.atom(h.id), names)
        for context in contexts(names):
            p = p_given(w, h, context)
            if p is not None:
                yield f"ev_given({w.names.atom(h.id)}, {w.list(context)}, {number(round(2 * p - 1, 9))})."
