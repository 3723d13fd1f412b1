"""A formula in negation normal form, deterministic and decomposable (d-DNNF), as lists.

Made smooth, so that every branch weighs every variable.

Nodes are numbered from 0, children before parents. Node 0 is true, node 1 is false; a literal's node is made on demand.

Clauses are compiled by ProbLog's dsharp, several components to a run, and by PySDD where dsharp fails; modules need no
compiler.
"""

import math
import os
from collections.abc import Iterable
from contextlib import ExitStack
from dataclasses import dataclass, field
from functools import reduce
from operator import or_
from pathlib import Path
from typing import Any

import problog

from plogic.base.children import Child
from plogic.base.errors import LimitError
from plogic.base.walk import reached
from plogic.inference.order import members
from plogic.logic.dnnf.cnf import Clause, Residue, add_modules

LITERAL, AND, OR = 0, 1, 2
TRUE, FALSE = 0, 1


@dataclass
class Nnf:
    """``kinds[i]`` and ``children[i]`` of each node.

    ``mentions[i]``: the variables below it, as bits; ``leaf``: literal → its node, ``literals``: the other way round.
    """

    kinds: list[int] = field(default_factory=lambda: [AND, OR])
    children: list[tuple[int, ...]] = field(default_factory=lambda: [(), ()])
    mentions: list[int] = field(default_factory=lambda: [0, 0])
    leaf: dict[int, int] = field(default_factory=dict)
    literals: dict[int, int] = field(default_factory=dict)
    root: int = TRUE
    _free: dict[int, int] = field(default_factory=dict)
    _stands: dict[int, int] = field(default_factory=dict)

    def literal(self, literal: int) -> int:
        """The leaf of a literal, or the node that stands for it."""
        if literal in self._stands:
            return self._stands[literal]
        if literal not in self.leaf:
            node = self.leaf[literal] = self._add(LITERAL, (), 1 << abs(literal))
            self.literals[node] = literal
        return self.leaf[literal]

    def conjunction(self, children: Iterable[int]) -> int:
        """And: its children share no variable."""
        kept = tuple(child for child in children if child != TRUE)
        if FALSE in kept:
            return FALSE
        if len(kept) < 2:
            return kept[0] if kept else TRUE
        return self._add(AND, kept, reduce(or_, (self.mentions[child] for child in kept)))

    def disjunction(self, children: Iterable[int]) -> int:
        """Or: no two of its children are true at once.

        A child that does not mention a variable of another's gets it, either way.
        """
        kept = tuple(child for child in children if child != FALSE)
        if len(kept) < 2:
            return kept[0] if kept else FALSE
        all_mentioned = reduce(or_, (self.mentions[child] for child in kept))
        smooth = (
            self.conjunction((child, *self.frees(missing)))
            if (missing := all_mentioned & ~self.mentions[child])
            else child
            for child in kept
        )
        return self._add(OR, tuple(smooth), all_mentioned)

    def stand_for(self, literal: int, yes: int, no: int, *, whole: bool) -> None:
        """Let ``yes`` stand for a literal and ``no`` for its negation.

        Both mention the same, of which nothing occurs elsewhere if ``whole``.
        """
        self._stands |= {literal: yes, -literal: no}
        if whole:
            free = self.disjunction((yes, no))
            self._free |= dict.fromkeys(members(self.mentions[free]), free)

    def frees(self, variables: int) -> list[int]:
        """Nodes that leave the variables, given as bits, open.

        Together with all that a node which stands for a literal mentions.
        """
        found = []
        while variables:
            found.append(self.free((variables & -variables).bit_length() - 1))
            variables &= ~self.mentions[found[-1]]
        return found

    def free(self, variable: int) -> int:
        """``variable ∨ ¬variable``."""
        if variable not in self._free:
            self._free[variable] = self._add(OR, (self.literal(variable), self.literal(-variable)), 1 << variable)
        return self._free[variable]

    def _add(self, kind: int, children: tuple[int, ...], mentions: int) -> int:
        self.kinds.append(kind)
        self.children.append(children)
        self.mentions.append(mentions)
        return len(self.kinds) - 1


def nodes_under(nnf: Nnf, root: int) -> set[int]:
    """A node and all nodes below it."""
    return set(reached([root], nnf.children.__getitem__))


RUNS = 2
"""Compilers that run at the same time."""
PROGRAM, RESULT = "program.cnf", "program.nnf"
"""Their files."""


def compiled(residue: Residue) -> Nnf:
    """The residue as one smooth d-DNNF.

    The conjunction of its components, and of the variables that are in none of them.

    Raises LimitError where no compiler manages.
    """
    nnf = Nnf()
    held = add_modules(nnf, residue.modules)
    bundles = [bundle for bundle in _bundles(residue.components) if bundle]
    roots = [root for bundle, text in zip(bundles, _dsharp(bundles), strict=True) for root in _roots(nnf, bundle, text)]
    open_ = sum(1 << v for v in range(1, residue.size + 1) if v not in residue.fixed)
    for root in (*held, *roots):
        open_ &= ~nnf.mentions[root]
    nnf.root = nnf.conjunction([*roots, *held, *nnf.frees(open_)])
    return nnf


def _bundles(components: tuple[tuple[Clause, ...], ...]) -> list[list[tuple[Clause, ...]]]:
    """The components in a few bundles of about the same number of clauses: one run of the compiler each."""
    bundles: list[list[tuple[Clause, ...]]] = [[] for _ in range(RUNS)]
    sizes = [0] * RUNS
    for component in components:
        smallest = sizes.index(min(sizes))
        bundles[smallest].append(component)
        sizes[smallest] += len(component)
    return bundles


def _roots(nnf: Nnf, bundle: list[tuple[Clause, ...]], text: str | None) -> list[int]:
    """The bundle's nodes; where its run failed, each component's by itself."""
    numbers = _numbers(bundle)
    if text is not None:
        return [_read(nnf, text, numbers)]
    if len(bundle) == 1:
        return [_by_sdd(nnf, bundle[0])]
    alone = [[component] for component in bundle]
    return [root for each, found in zip(alone, _dsharp(alone), strict=True) for root in _roots(nnf, each, found)]


def _numbers(bundle: list[tuple[Clause, ...]]) -> list[int]:
    """The variables of a bundle; their places, from 1, are the compiler's numbers."""
    return [0, *sorted({abs(literal) for component in bundle for clause in component for literal in clause})]


def _dimacs(bundle: list[tuple[Clause, ...]]) -> str:
    place = {v: i for i, v in enumerate(_numbers(bundle))}
    place |= {-v: -i for v, i in place.items()}
    lines = [
        " ".join([*(str(place[literal]) for literal in clause), "0"]) for component in bundle for clause in component
    ]
    return "\n".join([f"p cnf {len(place) // 2} {len(lines)}", *lines, ""])


def _dsharp(bundles: list[list[tuple[Clause, ...]]]) -> list[str | None]:
    """What dsharp makes of each bundle, some at the same time; None where it fails."""
    command = [_binary(), "-Fnnf", RESULT, "-smoothNNF", "-disableAllLits", PROGRAM]
    texts = [_dimacs(bundle).encode("ascii") for bundle in bundles]
    found: list[str | None] = []
    for start in range(0, len(texts), RUNS):
        with ExitStack() as stack:
            runs = [
                stack.enter_context(Child(command, told=b"", files={PROGRAM: text}))
                for text in texts[start : start + RUNS]
            ]
            found += [_finished(run) for run in runs]
    return found


def _binary() -> str:
    """The dsharp that ProbLog brings for this system, or the one on the path."""
    name = "darwin" if os.uname().sysname == "Darwin" else "linux"
    brought = Path(problog.__file__).parent / "bin" / name / "dsharp"
    return str(brought) if brought.exists() else "dsharp"


def _finished(run: Child) -> str | None:
    run.rest(math.inf)
    path = run.folder / RESULT
    text = path.read_text(encoding="ascii") if run.wait() == 0 and path.exists() else ""
    return text if text.startswith("nnf") and not text.startswith("nnf 0") else None


def _read(nnf: Nnf, text: str, numbers: list[int]) -> int:
    """The root of what dsharp wrote.

    Lines ``L literal``, ``A n children``, ``O variable n children``, the root last.
    """
    nodes: list[int] = []
    for line in text.splitlines()[1:]:
        kind, *rest = line.split()
        if kind == "L":
            value = int(rest[0])
            nodes.append(nnf.literal(numbers[value] if value > 0 else -numbers[-value]))
        elif kind == "A":
            nodes.append(nnf.conjunction([nodes[int(i)] for i in rest[1:]]))
        else:
            nodes.append(nnf.disjunction([nodes[int(i)] for i in rest[2:]]))
    return nodes[-1]


def _by_sdd(nnf: Nnf, component: tuple[Clause, ...]) -> int:
    """The root of the component's sentential decision diagram."""
    try:
        from pysdd.sdd import SddManager
    except ImportError:
        raise LimitError("the compiler dsharp failed, and PySDD, which would be asked next, is not installed") from None
    numbers = _numbers([component])
    manager, root = SddManager.from_cnf_string(_dimacs([component]))
    made: dict[int, int] = {}

    def node_of(sdd: Any) -> int:  # noqa: ANN401 - PySDD has no types
        if sdd.is_true() or sdd.is_false():
            return TRUE if sdd.is_true() else FALSE
        if sdd.is_literal():
            return nnf.literal(numbers[sdd.literal] if sdd.literal > 0 else -numbers[-sdd.literal])
        if sdd.id not in made:
            made[sdd.id] = nnf.disjunction(
                [nnf.conjunction((node_of(prime), node_of(sub))) for prime, sub in sdd.elements()]
            )
        return made[sdd.id]

    found = node_of(root)
    del root, manager
    return found
