"""What is said of a program before it runs: where it is surely not what somebody means who writes so.

Each kind of note has a look at the text, which needs no ProbLog, and then one at its clauses.
"""

import re
from collections.abc import Mapping, Sequence

from plogic.logic.safety.author import load_problog
from plogic.logic.safety.closest import meant
from plogic.logic.safety.rows import is_quick

_CONSTRAINTS = re.compile(r"(?m)^[ \t]*+:-|constraint")
_GROWS = re.compile(r":-[^.]*?(?:\bis\b|\(\s*+\w++\()")
_NEGATED_VARIABLE = re.compile(r"(?:\\\+|\\=|\bnot\b|\bforall\b)[^.]*?\b[A-Z_]")
_OBSERVED = re.compile(r"\bevidence\([^.]*?,")
_NAME = re.compile(r"\b[a-z]\w*+(?=\()")

MOST = 20
"""Notes on one text that are told one by one."""


def notes(text: str, file: str, goals: Sequence[str] = (), *, added: bool = False) -> list[str]:
    """A line on each such place of a text; of one that takes long to read nothing is said.

    ``goals``: what is asked of it, and observed. ``added``: it is rules beside a program, whose constraints hold.
    """
    wanted = _wanted(text, added=added) if is_quick(text) else frozenset()
    if not wanted:
        return []
    load_problog()
    try:
        found = _found(wanted, text, file, goals)
    except RecursionError:  # nested so deeply that no run will follow it: told there
        return []
    more = [f"{file}: and {len(found) - MOST} more of such notes"] if len(found) > MOST else []
    return found[:MOST] + more


def notes_on_goals(goals: Mapping[str, str]) -> list[str]:
    """A line on each negation of goals and evidence that is asked too early: what each is called → its text."""
    some = {name: text for name, text in goals.items() if _NEGATED_VARIABLE.search(text)}
    if not some:
        return []
    load_problog()
    from plogic.logic.safety.open_negations import goals_too_early

    return goals_too_early(some)


def _found(wanted: frozenset[str], text: str, file: str, goals: Sequence[str]) -> list[str]:
    """The notes of the kinds that are ``wanted``."""
    from plogic.logic.safety.added import idle
    from plogic.logic.safety.open_negations import asked_too_early
    from plogic.logic.safety.recursion import surely_endless
    from plogic.logic.safety.unasked import unasked

    found = idle(text, file) if "idle" in wanted else []
    found += surely_endless(text, file) if "endless" in wanted else []
    found += asked_too_early(text, file, goals) if "early" in wanted else []
    return found + (unasked(text, file) if "unasked" in wanted else [])


def _wanted(text: str, *, added: bool) -> frozenset[str]:
    """The kinds of notes that there may be on a text."""
    may = {
        "idle": not added and _CONSTRAINTS.search(text),
        "endless": _GROWS.search(text),
        "early": _NEGATED_VARIABLE.search(text),
        "unasked": _OBSERVED.search(text) or any(map(meant, set(_NAME.findall(text)))),
    }
    return frozenset(kind for kind, found in may.items() if found)
