"""Programs drawn by hypothesis, and their answers by going through every total choice."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from itertools import product

from hypothesis import strategies as st

LABELS = ("0.1", "0.25", "0.5", "0.9", "0.0", "1.0", "1/3")


@dataclass(frozen=True)
class Drawn:
    """``choices``: ((label, atom), ...) per alternative.

    ``rules``: (head, ((negated, atom), ...)), heads in layers, so that none is cyclic.
    """

    choices: tuple[tuple[tuple[str, str], ...], ...]
    rules: tuple[tuple[str, tuple[tuple[bool, str], ...]], ...]
    queries: tuple[str, ...]
    evidence: tuple[tuple[bool, str], ...]

    @property
    def text(self):
        """The ProbLog text."""
        lines = ["; ".join(f"{p}::{atom}" for p, atom in alternative) + "." for alternative in self.choices]
        lines += [f"{head} :- {', '.join(self._literal(*literal) for literal in body)}." for head, body in self.rules]
        lines += [f"evidence({self._literal(*literal)})." for literal in self.evidence]
        return "\n".join(lines + [f"query({atom})." for atom in self.queries]) + "\n"

    @staticmethod
    def _literal(negated, atom):
        return f"\\+ {atom}" if negated else atom

    def worlds(self):
        """(probability, the atoms that are true) of every total choice that has one, given nothing."""
        outcomes = [[*alternative, (_rest(alternative), None)] for alternative in self.choices]
        for chosen in product(*outcomes):
            p = 1.0
            for label, _ in chosen:
                p *= max(_value(label), 0.0)
            true = {atom for _, atom in chosen}
            for head, body in self.rules:
                if all((atom in true) != negated for negated, atom in body):
                    true.add(head)
            if p > 1e-12:
                yield p, true

    @cache  # noqa: B019 - programs of the tests, asked several times each
    def held(self):
        """The worlds in which the evidence holds."""
        return [
            (p, true) for p, true in self.worlds() if all((atom in true) != negated for negated, atom in self.evidence)
        ]


def _rest(alternative):
    """What the outcomes of an alternative leave, as a label."""
    return str(1 - sum(_value(p) for p, _ in alternative))


@cache
def _value(label):
    return eval(label)  # noqa: S307 - labels that this file drew


@st.composite
def programs(draw):
    """Up to six alternatives of up to three choices, rules over them in layers, queries and evidence."""
    choices, atoms = [], []
    for i in range(draw(st.integers(1, 6))):
        count = draw(st.integers(1, 3))
        labels = draw(st.tuples(*[st.sampled_from(LABELS if count == 1 else ("0.1", "0.25", "1/3"))] * count))
        names = [f"c({i},{j})" for j in range(count)]
        choices.append(tuple(zip(labels, names, strict=True)))
        atoms += names
    rules = []
    for layer in range(draw(st.integers(0, 4))):
        for _ in range(draw(st.integers(1, 2))):
            body = draw(st.lists(st.tuples(st.booleans(), st.sampled_from(atoms)), min_size=1, max_size=3))
            rules.append((f"r({layer})", tuple(body)))
        atoms.append(f"r({layer})")
    queries = draw(st.lists(st.sampled_from(atoms), min_size=1, max_size=4, unique=True))
    seen = draw(st.lists(st.tuples(st.booleans(), st.sampled_from(atoms)), max_size=2))
    return Drawn(tuple(choices), tuple(rules), tuple(queries), tuple(seen))
