"""Small terms as users write them."""

from __future__ import annotations

from typing import TYPE_CHECKING

from plogic.logic.proof.terms import Ref, Small, problog_term, refs, resolved, signature
from plogic.logic.safety.mapping import shown

if TYPE_CHECKING:
    from plogic.logic.safety.atoms import Names

INFIX = frozenset(
    {
        "=",
        "\\=",
        "==",
        "\\==",
        "is",
        "<",
        ">",
        "=<",
        ">=",
        "=:=",
        "=\\=",
        "=..",
        "+",
        "-",
        "*",
        "/",
        "//",
        "**",
        "^",
        "mod",
    }
)
TIGHT = frozenset({"+", "-", "*", "/", "//", "**", "^"})


BETWEEN = {(":-", 2): " :- ", (",", 2): ", ", (";", 2): " ; "}
LETTERS = "XYZUVW"


def text(goal: Small, names: Names | None) -> str:
    r"""``\+ hidden(h2, 'roof/apex')``; labels for atoms, operators between their arguments; unbound variables as letters, ``_`` if alone."""
    found = list(refs(goal))
    shared = [v for v in dict.fromkeys(found) if found.count(v) > 1]
    letters = {v: (LETTERS[i] if i < len(LETTERS) else f"X{i}",) for i, v in enumerate(shared)}
    return _text(resolved(goal, letters), names)


def _text(goal: Small, names: Names | None) -> str:
    name, arity = signature(goal)
    if isinstance(goal, Ref):
        return "_"
    if (name, arity) in BETWEEN:
        return BETWEEN[name, arity].join(_text(side, names) for side in goal[1:])
    if (name, arity) == ("\\+", 1):
        inner = _text(goal[1], names)
        return f"\\+ ({inner})" if signature(goal[1]) in BETWEEN else f"\\+ {inner}"
    if (name, arity) in ((".", 2), ("[]", 0)):
        return _list(goal, names)
    return _compound(goal, names) if arity else shown(problog_term(goal), names)


def _compound(goal: Small, names: Names | None) -> str:
    name, arity = signature(goal)
    if arity == 2 and name in INFIX and not (name == "/" and names is not None):
        sides = [f"({_text(s, names)})" if _binds_looser(s, name) else _text(s, names) for s in goal[1:]]
        return name.join(sides) if name in TIGHT else f" {name} ".join(sides)
    if name in INFIX:
        return shown(problog_term(goal), names)
    return f"{goal[0]}({_arguments(goal, names)})" if names is None else _named(goal, names)


def _named(goal: Small, names: Names) -> str:
    head = shown(problog_term((goal[0], *([("x",)] * (len(goal) - 1)))), names).split("(", 1)[0]
    return f"{head}({_arguments(goal, names)})"


def _arguments(goal: Small, names: Names | None) -> str:
    return ", ".join(f"({_text(a, names)})" if signature(a) in BETWEEN else _text(a, names) for a in goal[1:])


def _binds_looser(term: Small, operator: str) -> bool:
    name, arity = signature(term)
    return (
        arity == 2 and name in INFIX and operator in TIGHT and (name not in TIGHT or (name in "+-" and operator != "+"))
    )


def _list(goal: Small, names: Names | None) -> str:
    members = []
    while signature(goal) == (".", 2):
        members.append(_text(goal[1], names))
        goal = goal[2]
    tail = "" if signature(goal) == ("[]", 0) else f"|{_text(goal, names)}"
    return f"[{', '.join(members)}{tail}]"
