"""Why, and why not: minimal sets of choices that entail a goal, as trees down to the data (§8, *explanation*; contract ``plogic explain``).

Vocabulary:

* ``Reason``, a node of a tree, ``Reason("in_view(h1, 'roof/apex')", "rule", (...))``; its kind is rule, fact, choice, check, absent (a
  negation that holds), or fails
* ``Explanation``, ``Explanation("present(h1)", 0.31, 0.33, ("pick(h1, 'roof/apex')",), tree)``
* ``Account``, all that there is to say of one goal
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from plogic.engine import Limits, Text, ask, request_of, run
from plogic.query import subject_text

if TYPE_CHECKING:
    from collections.abc import Sequence

    from plogic.names import Names
    from plogic.query import Subject


@dataclass(frozen=True)
class Reason:
    """One node; the children of a rule are its conditions."""

    goal: str
    kind: str
    children: tuple[Reason, ...] = ()


@dataclass(frozen=True)
class Explanation:
    """A minimal set of ``choices`` that entails ``goal``.

    ``probability`` is the product of its choices (ICL). ``given_evidence`` is P(choices | evidence), None where a
    choice cannot be asked for by itself (it belongs to a rule with conditions).
    """

    goal: str
    probability: float
    given_evidence: float | None
    choices: tuple[str, ...]
    tree: Reason


@dataclass(frozen=True)
class Account:
    """P(goal | evidence) and what there is to say of it.

    ``why``: explanations; ``why_not``: explanations of the negated goal; ``failure``: of a goal that no choices entail, the condition that
    fails.
    """

    goal: str
    probability: float
    why: tuple[Explanation, ...]
    why_not: tuple[Explanation, ...]
    failure: Reason | None


def explain(subject: Subject, goal: str, *, given: Sequence[str] = (), most: int = 5, limits: Limits | None = None) -> Account:
    """The ``most`` probable explanations of a goal and of its negation; raises as ``plogic.query.answers`` does.

    Of a goal with variables the probability is that of its most probable answer.
    """
    text, names = subject_text(subject)
    found = run([text], [goal], given, names=names, limits=limits)[0]
    reply = ask({**request_of([text], [goal], given, names), "task": "prove", "most": most}, limits or Limits())
    entries = [*reply["for"], *reply["against"]]
    chances = iter(_chances(text, names, [e for e in entries if e["askable"]], given, limits))
    made = [_explanation(e, next(chances) if e["askable"] else None) for e in entries]
    for_it, against = _ranked(made[: len(reply["for"])]), _ranked(made[len(reply["for"]) :])
    failure = None if reply["failure"] is None else _reason(reply["failure"])
    return Account(goal, found[0].probability if found else 0.0, for_it, against, failure)


def _chances(text: Text, names: Names | None, entries: list[dict[str, Any]], given: Sequence[str], limits: Limits | None) -> list[float]:
    goals = [", ".join(entry["choices"]) for entry in entries]
    return [answers[0].probability for answers in run([text], goals, given, names=names, limits=limits)] if goals else []


def _ranked(explanations: list[Explanation]) -> tuple[Explanation, ...]:
    def order(e: Explanation) -> tuple[float, tuple[str, ...]]:
        return -(e.probability if e.given_evidence is None else e.given_evidence), e.choices

    return tuple(sorted(explanations, key=order))


def _explanation(entry: dict[str, Any], chance: float | None) -> Explanation:
    certain = 1.0 if not entry["choices"] else chance
    return Explanation(entry["goal"], entry["probability"], certain, tuple(entry["choices"]), _reason(entry["tree"]))


def _reason(tree: dict[str, Any]) -> Reason:
    return Reason(tree["goal"], tree["kind"], tuple(_reason(child) for child in tree["children"]))
