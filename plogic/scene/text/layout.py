"""How program text is written: atoms by the table of names, numbers so that ProbLog reads them back exactly, contexts.

A *context* is a set of present occluders that change a hypothesis' cells; P(ev) is told in each (§5.5, §8).
"""

import json
from collections.abc import Iterable, Iterator
from dataclasses import dataclass

import numpy as np

from geometry.arrays import Mask
from plogic.facts.dependence import MOST_OCCLUDERS, Dependence, Scene
from plogic.facts.hypothesis import FeatureFact, Hypothesis
from plogic.logic.safety.atoms import Names
from plogic.scene.readings.world_weights import acceptance, causes_of, p_ev


@dataclass(frozen=True)
class Writer:
    """A scene, its graph of dependence and its names: what each layer of the text is written from."""

    scene: Scene
    graph: Dependence
    names: Names

    def atoms(self, *labels: str) -> str:
        """``h1, f3``: the labels' atoms as arguments."""
        return ", ".join(self.names.atom(label) for label in labels)

    def fact(self, predicate: str, *labels: str) -> str:
        """A fact about labels: ``in_image(h1, f3).``."""
        return f"{predicate}({self.atoms(*labels)})."

    def node(self, h: Hypothesis, inner: str) -> str:
        """``h1/f3``: a part or a feature of a hypothesis."""
        return f"{self.names.atom(h.id)}/{self.names.atom(inner)}"

    def feature(self, h: Hypothesis, f: FeatureFact) -> str:
        """``h1, f3``."""
        return self.atoms(h.id, f.id)

    def list(self, labels: Iterable[str]) -> str:
        """``[h1, h2]``."""
        return f"[{self.atoms(*labels)}]"


def number(value: float) -> str:
    """The shortest text that reads back as the same float."""
    return repr(float(value))


def coordinate(value: float) -> str:
    """Metres, to a tenth of a millimetre, without a negative zero."""
    text = f"{value:.4f}"
    return text[1:] if text.startswith("-") and float(text) == 0 else text


def quoted(label: str) -> str:
    """A user's label for a comment, on one line whatever it holds."""
    return json.dumps(label)


def disjunction(heads: list[tuple[float, str]], per_line: int = 3) -> str:
    """An annotated disjunction: ``0.5::a; 0.5::b.``, a few heads a line."""
    written = [f"{number(p)}::{head}" for p, head in heads]
    return ";\n  ".join(["; ".join(written[i : i + per_line]) for i in range(0, len(written), per_line)]) + "."


def title(number_of_layer: int, meaning: str) -> str:
    """The heading of a layer."""
    return f"% ==== ({number_of_layer}) {meaning}"


def contexts(names: tuple[str, ...]) -> list[tuple[str, ...]]:
    """Every subset, smallest first."""
    return sorted((tuple(n for bit, n in enumerate(names) if i >> bit & 1) for i in range(2 ** len(names))), key=len)


def listed(w: Writer, h: Hypothesis) -> tuple[str, ...]:
    """The occluders that the contexts of ``h`` are made of: at most six, those that change most cells."""
    return w.graph.of[h.id][:MOST_OCCLUDERS]


def context_clauses(w: Writer, key: str, names: tuple[str, ...]) -> Iterator[str]:
    """One clause per context, which says when it holds: ``context(h1, [h2]) :- present(h2), not present(h3)``."""
    for context in contexts(names):
        literals = [("" if n in context else "\\+ ") + f"present({w.names.atom(n)})" for n in names]
        body = f" :- {', '.join(literals)}" if literals else ""
        yield f"context({key}, {w.list(context)}){body}."


def block_clauses(w: Writer, key: str, block: tuple[str, ...]) -> Iterator[str]:
    """What a cyclic block is made of: its members, who is in each of its joint states, and its contexts."""
    yield from (f"member_of({w.names.atom(name)}, {key})." for name in block)
    yield from (f"includes({w.list(state)}, {w.names.atom(name)})." for state in contexts(block) for name in state)
    yield from context_clauses(w, key, w.graph.outside(block))


def possible_causes(w: Writer, appearance: str) -> list[tuple[float, str]]:
    """What can cause an appearance, each with its share: ``(0.7, "chosen(a1, h1/f3)")``, noise last."""
    causes, claimants = causes_of(w.scene, appearance), w.scene.claimants.get(appearance, [])
    named = [(p, w.node(h, f.id)) for p, (h, f) in zip(causes.claimants, claimants, strict=True)]
    heads = [(p, f"chosen({w.names.atom(appearance)}, {cause})") for p, cause in [*named, (causes.noise, "noise")]]
    return [(p, head) for p, head in heads if p > 0]


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
