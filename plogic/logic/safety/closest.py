"""Did you mean: the closest names to one that nobody defines."""

from collections.abc import Iterable
from difflib import get_close_matches


def closest(signature: str, defined: Iterable[str]) -> str:
    """``; present/1 is known``, or the closest names among signatures; empty where none is close."""
    known = sorted(_split(one) for one in defined)
    wanted, _ = _split(signature)
    arities = [arity for name, arity in known if name == wanted]
    if arities:
        return f"; {', '.join(f'{wanted}/{arity}' for arity in arities)} is known"
    public = sorted({name for name, _ in known if not name.startswith(("_", "plogic "))})
    names = get_close_matches(wanted, public, n=3, cutoff=0.6)
    found = [f"{name}/{arity}" for close in names for name, arity in known if name == close]
    return f"; the closest that is known: {', '.join(found)}" if found else ""


def _split(signature: str) -> tuple[str, int]:
    name, _, arity = signature.rpartition("/")
    return name.strip("'"), int(arity)
