"""Did you mean: the closest names to one that nobody defines."""

import re
from collections.abc import Iterable, Mapping, Sequence
from difflib import get_close_matches

_COUNTS = re.compile("count|many|number|total|aggregate")
COUNTING = {"number_of_objects/1", "number_of/2"}
"""What the programs of scenes count by."""
COUNTED = "the number of objects is number_of_objects(N), that of a type number_of(Type, N)"


def closest(signature: str, defined: Iterable[str]) -> str:
    """``; present/1 is known``, or the closest names among signatures; empty where none is close."""
    defined = frozenset(defined)
    known = sorted(_split(one) for one in defined)
    wanted, _ = _split(signature)
    arities = [arity for name, arity in known if name == wanted]
    if arities:
        return f"; {', '.join(f'{wanted}/{arity}' for arity in arities)} is known"
    if _COUNTS.search(wanted) and defined >= COUNTING:
        return f"; {COUNTED}"
    public = sorted({name for name, _ in known if not name.startswith(("_", "plogic "))})
    names = get_close_matches(wanted, public, n=3, cutoff=0.6)
    found = [f"{name}/{arity}" for close in names for name, arity in known if name == close]
    return f"; the closest that is known: {', '.join(found)}" if found else ""


ALIKE = 0.75
"""Likeness (``difflib``) of a misspelt name: ``evidnce`` has 0.93, ``qery`` 0.89, ``quary`` 0.8; ``quest`` 0.6."""


def meant(name: str) -> str:
    """``query`` or ``evidence`` where a name is like it; empty where it is neither, or just that."""
    close = get_close_matches(name, ("query", "evidence"), n=1, cutoff=ALIKE)
    return close[0] if close and close[0] != name else ""


def counting(texts: Sequence[Mapping[str, str]], goals: Sequence[str]) -> str:
    """What counts the objects of a scene, where somebody asks by lists of answers, which are as many as worlds."""
    own = "\n".join([*(item["text"] for item in texts[1:]), *goals])
    return COUNTED if "findall(" in own and "number_of_objects(N) :-" in texts[0]["text"] else ""


def _split(signature: str) -> tuple[str, int]:
    name, _, arity = signature.rpartition("/")
    return name.strip("'"), int(arity)
