"""The measures of the program: dv by feature type, and the four cells of each hypothesis in each context (§5.1, §5.4).

A *context* is a set of present occluders that change a hypothesis' cells. A row of cells counts the features of one
type that are in the image, in the order of Table 1: ``row(corner, 4, 2, 2, 0)``. A feature that counts otherwise than
its type does (``FeatureFact.stands_for``) has a row of its own weight: ``row(own(12.3), 0, 0, 1, 0)``.
"""

from collections.abc import Iterator

import numpy as np

from plogic.facts.dependence import MOST_OCCLUDERS
from plogic.facts.hypothesis import FeatureFact, Hypothesis
from plogic.scene.readings.world_weights import four
from plogic.scene.text.layout import Writer, number


def measures(w: Writer) -> Iterator[str]:
    """``dv(corner, 0.857). rank(t2, 0.9).``."""
    situation = w.scene.situation
    yield from (f"dv({w.atoms(name)}, {number(v)})." for name, v in situation.dv.items())
    yield from (f"rank({w.atoms(name)}, {number(v)})." for name, v in situation.rank.items())


def key_of(w: Writer, f: FeatureFact) -> str:
    """What the feature counts as: the atom of its type, or its own dv where that is not its type's."""
    return w.names.atom(f.type) if w.scene.situation.dv.get(f.type) == f.dv else f"own({number(f.dv)})"


def occluders(w: Writer, h: Hypothesis) -> tuple[str, ...]:
    """What the contexts of ``h`` are made of: at most six, those that change most cells; all of them in a cycle."""
    cyclic = any(h.id in block and len(block) > 1 for block in w.graph.blocks)
    return w.graph.of[h.id] if cyclic else w.graph.of[h.id][:MOST_OCCLUDERS]


def contexts(names: tuple[str, ...]) -> list[tuple[str, ...]]:
    """Every subset, smallest first."""
    return sorted((tuple(n for bit, n in enumerate(names) if i >> bit & 1) for i in range(2 ** len(names))), key=len)


def cell_facts(w: Writer) -> Iterator[str]:
    """``occluders(h2, [h1]). cells(h2, [h1], [row(corner, 4, 0, 4, 0), ...]).``, a context a line."""
    yield "% The four cells of each hypothesis in each context, by feature type: E∧D, E∧¬D, ¬E∧¬D, ¬E∧D."
    for h in w.scene.situation.hypotheses:
        me, names = w.names.atom(h.id), occluders(w, h)
        rest = [g for g in (*w.graph.of[h.id], *w.graph.left_out.get(h.id, ())) if g not in names]
        if rest:
            yield f"% {me}: not in these contexts: {w.atoms(*rest)}"
        yield f"occluders({me}, {w.list(names)})."
        some = contexts(names)
        rows = _rows(w, h, some)
        for i, context in enumerate(some):
            told = [f"row({', '.join((key, *map(str, n[i])))})" for key, n in rows.items() if n[i].any()]
            yield f"cells({me}, {w.list(context)}, [{', '.join(told)}])."


def _rows(w: Writer, h: Hypothesis, some: list[tuple[str, ...]]) -> dict[str, np.ndarray]:
    """Key → (M, 4) counts of the cells A, C, B, D in each of M contexts."""
    present = {g.id: np.array([g.id in context or g is h for context in some]) for g in w.scene.situation.hypotheses}
    order = [w.names.atom(name) for name in w.scene.situation.dv]
    rows: dict[str, np.ndarray] = {key: np.zeros((len(some), 4), int) for key in order}
    for f in (f for f in h.features if f.in_image):
        rows.setdefault(key_of(w, f), np.zeros((len(some), 4), int))
        rows[key_of(w, f)] += np.stack(four(w.scene, h, f, present), axis=1)
    return rows
