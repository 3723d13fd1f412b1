"""The tables of ROC-20 as text.

Short signs, converses, coarsenings, conceptual neighbours, and the composition table (§3.7).

A sign is who is in front on the common interior (``>`` x, ``<`` y, ``*`` each somewhere; nothing where there is none)
and the RCC-8 term of the
images in small letters: ``>tpp`` is partially_occludes_tpp, ``<tpp`` totally_occluded_by_tpp, ``dc`` non_occludes_dc.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from geometry.visibility.roc import ROC20, coarse, converse, los14, parts_of

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping

    from geometry.visibility.composition import Triple
    from geometry.visibility.roc import Roc

    Composition = Mapping[tuple[Roc, Roc], frozenset[Roc]]

_MARK = {"nobody": "", "x": ">", "y": "<", "both": "*"}


def sign(relation: Roc) -> str:
    """The short sign of a relation."""
    rcc, front = parts_of(relation)
    return f"{_MARK[front]}{rcc.lower()}"


def composition(triples: Iterable[Triple]) -> Composition:
    """(R, S) → the relations of (x, z) that go with R of (x, y) and S of (y, z)."""
    found: dict[tuple[Roc, Roc], set[Roc]] = {(r, s): set() for r in ROC20 for s in ROC20}
    for r, s, t in triples:
        found[r, s].add(t)
    return {pair: frozenset(some) for pair, some in found.items()}


def composition_lines(lower: Composition, upper: Composition) -> list[str]:
    """One line an entry: ``>po ; >tpp = >po >tpp``.

    Where the bounds differ, what is not known to be reached stands after ``?``.
    """
    return [_line(r, s, lower[r, s], upper[r, s]) for r in ROC20 for s in ROC20]


def _line(r: Roc, s: Roc, lower: frozenset[Roc], upper: frozenset[Roc]) -> str:
    open_still = _signs(upper - lower)
    return f"{sign(r)} ; {sign(s)} = {_signs(lower)}" + (f" ? {open_still}" if open_still else "")


def _signs(some: Iterable[Roc]) -> str:
    return " ".join(sign(t) for t in sorted(some, key=ROC20.index))


def counts_table(lower: Composition, upper: Composition) -> list[str]:
    """As Markdown: how many relations each entry has; with a `+` where it is a lower bound."""
    head = ["| R \\ S | " + " | ".join(f"`{sign(s)}`" for s in ROC20) + " |", "|---" * (len(ROC20) + 1) + "|"]
    return head + [
        f"| `{sign(r)}` | " + " | ".join(_count(lower[r, s], upper[r, s]) for s in ROC20) + " |" for r in ROC20
    ]


def _count(lower: frozenset[Roc], upper: frozenset[Roc]) -> str:
    return f"{len(lower)}" + ("" if lower == upper else "+")


def relations_table(neighbours: Iterable[tuple[Roc, Roc]]) -> list[str]:
    """As Markdown: each relation with its sign, its coarse form, its converse, its LOS-14 name, and its neighbours."""
    beside = {r: [t for t in ROC20 if (r, t) in set(neighbours)] for r in ROC20}
    rows = ["| relation of x to y | sign | coarse | converse | LOS-14 | neighbours |", "|---|---|---|---|---|---|"]
    for r in ROC20:
        near = " ".join(f"`{sign(t)}`" for t in beside[r])
        rows.append(f"| `{r}` | `{sign(r)}` | `{coarse(r)}` | `{sign(converse(r))}` | {los14(r) or 'none'} | {near} |")
    return rows
