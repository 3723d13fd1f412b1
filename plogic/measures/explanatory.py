"""Explanatory value ev, P(ev) and reconsideration (§5.4, §5.5); Shanahan's, for comparison (§5.7).

Vocabulary:

* ``Cells``, how many features of one type fall in each case, ``Cells(A=4, C=2, B=2, D=0)``:

  |            | Detected                | ¬Detected                        |
  |------------|-------------------------|----------------------------------|
  | Expected   | A: strong support       | C: wants an explanation          |
  | ¬Expected  | D: novel                | B: weak support                  |

* ``Support``, the cells of each feature type, ``{"apex": Cells(1, 0, 0, 0), "corner": Cells(4, 2, 2, 0)}``.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import exp, log
from typing import Literal

import numpy as np
from numpy.typing import NDArray

Case = Literal["A", "B", "C", "D"]


def case_of(*, expected: bool, detected: bool) -> Case:
    """The four cases of §4: A is E∧D, C is E∧¬D, B is ¬E∧¬D, D is ¬E∧D."""
    return ("A" if detected else "C") if expected else ("D" if detected else "B")


@dataclass(frozen=True)
class Cells:
    """Counts in the paper's column order E∧D, E∧¬D, ¬E∧¬D, ¬E∧D, that is A, C, B, D."""

    A: int = 0
    C: int = 0
    B: int = 0
    D: int = 0


Support = dict[str, Cells]


def tally(
    names: Sequence[str], kind: NDArray[np.intp], expected: NDArray[np.bool_], detected: NDArray[np.bool_]
) -> Support:
    """Count the cases of F features into the cells of their types: ``kind`` (F,) are indices into ``names``, which are in alphabetical order."""
    column = np.where(expected, np.where(detected, 0, 1), np.where(detected, 3, 2))
    counts = np.bincount(kind * 4 + column, minlength=4 * len(names)).reshape(-1, 4)
    some = np.flatnonzero(counts.any(axis=1))
    return {names[i]: Cells(*cells) for i, cells in zip(some.tolist(), counts[some].tolist(), strict=True)}


def explanatory_value(support: Mapping[str, Cells], dv: Mapping[str, float]) -> float | None:
    """Ev = ((A+B) − (C+D)) / (A+B+C+D), each letter the dv-weighted sum of its case (§5.4; repaired brackets).

    0/0 (no feature in the image, or every dv 0) is None: undefined, and such a hypothesis is not accepted.
    """
    concordant = sum(dv[name] * (cells.A + cells.B) for name, cells in support.items())
    discordant = sum(dv[name] * (cells.C + cells.D) for name, cells in support.items())
    return None if concordant + discordant <= 0.0 else (concordant - discordant) / (concordant + discordant)


def probability_of_ev(ev: float) -> float:
    """P(ev) = (ev + 1) / 2 = (A+B) / (A+B+C+D) (§5.4)."""
    return (ev + 1.0) / 2.0


Mode = Literal["to_B", "drop", "reassign"]


def reconsidered(
    support: Mapping[str, Cells],
    explained: Mapping[str, int],
    mode: Mode = "to_B",
    displaced: Mapping[str, int] | None = None,
) -> Support:
    """Take the cells anew once occluders are accepted (§5.5).

    ``explained`` counts, per feature type, the C cells that an accepted occluder hides; ``displaced`` the D cells whose
    appearance another accepted object claims (used by ``reassign`` only). ``drop`` takes the explained C cells out of
    the sum (the paper's), ``to_B`` makes them ¬E∧¬D (strict D7), ``reassign`` does that and moves the displaced D items
    away too, which leaves ¬E∧¬D.

    Raises ValueError where more cells are explained or displaced than there are.
    """
    away = (displaced or {}) if mode == "reassign" else {}
    result: Support = {}
    for name, cells in support.items():
        hidden, moved = explained.get(name, 0), away.get(name, 0)
        if hidden > cells.C or moved > cells.D:
            raise ValueError(
                f"{name}: {hidden} of {cells.C} C cells explained and {moved} of {cells.D} D cells displaced"
            )
        gained = 0 if mode == "drop" else hidden
        result[name] = Cells(A=cells.A, C=cells.C - hidden, B=cells.B + gained + moved, D=cells.D - moved)
    return result


def shanahan_values(rivals: Mapping[str, Sequence[float]]) -> dict[str, float]:
    """P(Qk) / Σj P(Qj) of each rival explanation Δk of the same Γ, Qk = Δk and no other.

    ``rivals`` gives each explanation the priors of its abducibles, all in (0, 1]; P(Qk) is their product. The values
    sum to 1 over the
    rivals (ev does not), adding a rival lowers the others, and listing every abducible k times multiplies log-odds by
    k. No rivals, no
    values. Products are taken in logarithms: thousands of abducibles do not underflow. Raises ValueError for a prior
        outside (0, 1].
    """
    if any(not 0.0 < prior <= 1.0 for priors in rivals.values() for prior in priors):
        raise ValueError("a prior lies outside (0, 1]")
    logs = {name: sum(log(prior) for prior in priors) for name, priors in rivals.items()}
    top = max(logs.values(), default=0.0)
    weights = {name: exp(value - top) for name, value in logs.items()}
    total = sum(weights.values())
    return {name: weight / total for name, weight in weights.items()}
