"""Clauses to d-DNNF: modules by themselves; the rest by ProbLog's dsharp, several components to a run.

By PySDD where dsharp fails.
"""

from __future__ import annotations

import math
import os
from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING, Any

import problog

from plogic.base.children import Child
from plogic.base.errors import LimitError
from plogic.logic.dnnf.cnf import add_modules
from plogic.logic.dnnf.nnf import FALSE, TRUE, Nnf

if TYPE_CHECKING:
    from plogic.logic.dnnf.cnf import Clause, Residue

RUNS = 2
"""Compilers that run at the same time."""
PROGRAM, RESULT = "program.cnf", "program.nnf"
"""Their files."""


def compiled(residue: Residue) -> Nnf:
    """The residue as one smooth d-DNNF: the conjunction of its components, and of the variables that are in none of them.

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
    found: list[str | None] = []
    for start in range(0, len(bundles), RUNS):
        with ExitStack() as stack:
            runs = [stack.enter_context(_started(bundle)) for bundle in bundles[start : start + RUNS]]
            found += [_finished(run) for run in runs]
    return found


def _started(bundle: list[tuple[Clause, ...]]) -> Child:
    command = [_binary(), "-Fnnf", RESULT, "-smoothNNF", "-disableAllLits", PROGRAM]
    return Child(command, told=b"", files={PROGRAM: _dimacs(bundle).encode("ascii")}, foreign=True)


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
    """The root of what dsharp wrote: lines ``L literal``, ``A n children``, ``O variable n children``, the root last."""
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
