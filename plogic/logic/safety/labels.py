"""Labels that are no probabilities, as they are written: numbers, alone or together, and what other tools ask for."""

import re
from collections.abc import Iterator
from typing import Any

from problog.errors import ProbLogError
from problog.logic import Constant, Term, Var

from plogic.base.bounds import SLACK

NOT_HERE = {
    "t": "it is to be learned, and plogic asks programs whose probabilities are known; problog lfi learns them",
    "?": "it is a decision, and plogic makes none; ProbLog's mode dt does",
} | dict.fromkeys(
    ("normal", "uniform", "beta", "gamma", "exponential", "poisson"),
    "it is a distribution, and choices of plogic are discrete: give values with a probability each",
)
"""What labels that are no numbers are for, by their functors."""


DRAWN = (
    "choices of plogic are discrete, and nothing is drawn from a distribution: give values with a probability each, "
    "as in 0.3::low; 0.7::high."
)
"""What is said of ``X ~ normal(0,1)``, which ProbLog reads as ``X::normal(0,1)``."""
NEAR = 80
"""Blanks after a tilde that are looked through, at most: a line of them."""


_NUMBER = re.compile(r"[0-9.]*[1-9][0-9.]*(?:[eE][-+]?[0-9]+)?")
"""One that is written with more than zeros."""


def mistaken(found: list[Any], text: str) -> Iterator[tuple[Any, str]]:
    """What is wrong with the labels of one statement's heads, with the term; what only a run can tell is left out.

    ``text``: that of the program.
    """
    drawn = [head for head in found if _is_drawn(head, text)]
    if drawn:
        yield from ((head, f"{head.probability} ~ {head.with_probability(None)}: {DRAWN}") for head in drawn)
        return
    labels = [(head, head.probability) for head in found if isinstance(head, Term) and head.probability is not None]
    numbers = [(head, label, number_of(label)) for head, label in labels]
    wrong = [
        (label if getattr(label, "location", None) else head, why)
        for head, label, value in numbers
        if (why := _wrong(label, value))
    ]
    yield from wrong
    for _, label, value in numbers:
        place = getattr(label, "location", None)
        if value == 0.0 and place is not None and (written := _NUMBER.match(text, place[1])):
            yield label, f"{written[0]} is 0 to ProbLog, which keeps 15 decimals: leave it out, or write 1e-15 or more"
    total = sum(value for _, _, value in numbers if value is not None)
    if not wrong and total > 1.0 + SLACK:
        yield found[0], adding_up(total)


def _is_drawn(head: Any, text: str) -> bool:  # noqa: ANN401 - a term of ProbLog's
    """Whether a tilde stands between a label and its head."""
    if getattr(head, "probability", None) is None or head.location is None or head.location[1] is None:
        return False
    end = head.location[1]
    return text[max(0, end - NEAR) : end].rstrip().endswith("~")


def adding_up(total: float) -> str:
    """What to say of an annotated disjunction over 1."""
    right = "; choices that are independent of each other end with a full stop each"
    return f"the probabilities of an annotated disjunction add up to {total:.12g}: they must not exceed 1{right}"


GROWS = frozenset({"**", "^", "<<"})
"""Functions whose values may be longer than any memory: they are computed where time and memory are limited."""
LONGEST = 10_000
"""Bits of a whole number that a label may be computed by."""


def holds_too_large(label: Any) -> bool:  # noqa: ANN401 - a term of ProbLog's
    """Whether a label has a power in it of more than ``LONGEST`` bits, which is not worked out."""
    parts, stack = [], [label]
    while stack:
        parts.append(stack.pop())
        stack += getattr(parts[-1], "args", ())
    if not any(_functor(part) in GROWS for part in parts):
        return False
    values: dict[int, Any] = {}
    for part in reversed(parts):  # arguments before what they are of
        its: list[Any] = [values.get(id(argument)) for argument in getattr(part, "args", ())]
        if _functor(part) in GROWS and len(its) == 2 and all(isinstance(value, int) for value in its):
            base, exponent = its
            if exponent * (1 if _functor(part) == "<<" else abs(base).bit_length() - 1) > LONGEST:
                return True
        try:
            values[id(part)] = Term(part.functor, *map(Constant, its)).compute_value() if its else part.value
        except (AttributeError, ProbLogError, ArithmeticError, TypeError, ValueError):
            values[id(part)] = None
    return False


def _functor(part: Any) -> str:  # noqa: ANN401 - a term of ProbLog's
    return str(getattr(part, "functor", "")).strip("'")


def number_of(label: Any) -> float | None:  # noqa: ANN401 - a term of ProbLog's
    """A label's number; None where it is none yet."""
    stack = [label]
    while stack:
        part = stack.pop()
        if _functor(part) in GROWS:
            return None
        stack += getattr(part, "args", ())
    try:
        return float(label)
    except (ProbLogError, ArithmeticError, TypeError, ValueError):
        return None


def _wrong(label: Any, value: float | None) -> str:  # noqa: ANN401 - a term of ProbLog's
    if value is None:
        why = "" if isinstance(label, Var) else NOT_HERE.get(str(getattr(label, "functor", "")), "")
        if not why and holds_too_large(label):
            why = f"it holds a number of more than {LONGEST} bits"
        return why and f"{label} is not a probability: {why}"
    return "" if -1e-9 <= value <= 1.0 + 1e-9 else f"{label} is not a probability: it must be from 0 to 1"
