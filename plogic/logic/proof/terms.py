"""Small terms for proofs: made from ProbLog's, unified, given back, and written as users write them.

A term is a number, a ``Ref`` (a variable), or a tuple ``(functor, *arguments)``: ``("present", ("h1",))`` is
present(h1).
"""

from collections.abc import Iterator, Mapping
from typing import Any

from problog.logic import And, Constant, Not, Or, Term, Var

from plogic.logic.safety.atoms import Names
from plogic.logic.safety.mapping import shown

Small = Any
"""float | int | Ref | tuple[str | Small, ...]"""
Bindings = dict["Ref", Small]


class Ref:
    """A variable; two are the same only if they are one object."""

    __slots__ = ()


def small(term: Any, variables: dict[str, Ref]) -> Small:  # noqa: ANN401 - a term of ProbLog's
    """From ProbLog's term; ``variables`` holds the variables by name.

    An underscore, or what the engine left unbound, is always a new one.
    """
    if term is None or isinstance(term, int):
        return Ref()
    if isinstance(term, Var):
        return Ref() if term.name == "_" else variables.setdefault(term.name, Ref())
    if isinstance(term, Constant):
        return (str(term.functor),) if term.is_string() else term.functor
    if isinstance(term, (And, Or, Not)):
        return (term.functor, *(small(argument, variables) for argument in term.args))
    return (str(term.functor), *(small(argument, variables) for argument in term.args))


def problog_term(term: Small, names: Mapping[Ref, str] | None = None) -> Any:  # noqa: ANN401 - a term of ProbLog's
    """Back to ProbLog's term; a variable without a name is an underscore."""
    if isinstance(term, Ref):
        return Var((names or {}).get(term, "_"))
    if not isinstance(term, tuple) or term[0][:1] == '"':
        return Constant(term[0] if isinstance(term, tuple) else term)
    arguments = [problog_term(argument, names) for argument in term[1:]]
    if term[0] in (",", ";") and len(arguments) == 2:
        return (And if term[0] == "," else Or)(*arguments)
    if term[0] == "\\+":
        return Not("\\+", arguments[0])
    return Term(term[0], *arguments)


def walk(term: Small, bindings: Bindings) -> Small:
    """What a variable is bound to, itself if it is free."""
    while isinstance(term, Ref) and term in bindings:
        term = bindings[term]
    return term


def resolved(term: Small, bindings: Bindings) -> Small:
    """The term with every bound variable replaced."""
    term = walk(term, bindings)
    return (term[0], *(resolved(argument, bindings) for argument in term[1:])) if isinstance(term, tuple) else term


def unify(x: Small, y: Small, bindings: Bindings) -> bool:
    """Whether the two become the same; extends ``bindings`` (which are garbage if they do not)."""
    x, y = walk(x, bindings), walk(y, bindings)
    if x is y:
        return True
    if isinstance(x, Ref) or isinstance(y, Ref):
        bindings[x if isinstance(x, Ref) else y] = y if isinstance(x, Ref) else x
        return True
    if isinstance(x, tuple) and isinstance(y, tuple):
        same = x[0] == y[0] or str(x[0]).strip("'") == str(y[0]).strip("'")
        return same and len(x) == len(y) and all(unify(a, b, bindings) for a, b in zip(x[1:], y[1:], strict=True))
    return bool(x == y) and isinstance(x, tuple) == isinstance(y, tuple)


def is_ground(term: Small) -> bool:
    """Whether no variable is left."""
    return not isinstance(term, Ref) and (
        not isinstance(term, tuple) or all(is_ground(argument) for argument in term[1:])
    )


def is_atom(term: Small) -> bool:
    """Whether the term is an atom or a number: what clauses are indexed by."""
    return not isinstance(term, Ref) and (not isinstance(term, tuple) or len(term) == 1)


def refs(term: Small) -> Iterator[Ref]:
    """The variables of a term, from left to right, as often as they occur."""
    if isinstance(term, Ref):
        yield term
    elif isinstance(term, tuple):
        for argument in term:
            yield from refs(argument)


def signature(term: Small) -> tuple[str, int]:
    """Functor without its quotes, and arity."""
    return (str(term[0]).strip("'"), len(term) - 1) if isinstance(term, tuple) else ("", 0)


def fresh(term: Small, new: dict[Ref, Ref] | None = None) -> Small:
    """The term with new variables."""
    names = {} if new is None else new
    if isinstance(term, Ref):
        return names.setdefault(term, Ref())
    return (term[0], *(fresh(argument, names) for argument in term[1:])) if isinstance(term, tuple) else term


def canonical(term: Small, seen: dict[Ref, Small] | None = None) -> Small:
    """The term with its variables replaced by numbered atoms.

    Equal for terms that differ in the names of variables only.
    """
    atoms = {} if seen is None else seen
    if isinstance(term, Ref):
        return atoms.setdefault(term, (f"_{len(atoms)}",))
    return (term[0], *(canonical(argument, atoms) for argument in term[1:])) if isinstance(term, tuple) else term


PRIORITY = {
    **dict.fromkeys(("=", "\\=", "==", "\\==", "is", "<", ">", "=<", ">=", "=:=", "=\\=", "=.."), 700),
    **dict.fromkeys(("+", "-"), 500),
    **dict.fromkeys(("*", "/", "//", "mod", "^"), 400),
    "**": 200,
}
"""Of the operators between two terms, as ProbLog reads them: the least binds first."""
ROWS = frozenset({"+", "-", "*", "/", "//", "mod"})
"""Those of which ``a - b - c`` is ``(a - b) - c``."""
TIGHT = frozenset(PRIORITY) - {"mod"} - {name for name, priority in PRIORITY.items() if priority == 700}
"""Those that are written without blanks."""


BETWEEN = {(":-", 2): " :- ", (",", 2): ", ", (";", 2): " ; "}
LETTERS = "XYZUVW"


def text(goal: Small, names: Names | None) -> str:
    r"""``\+ hidden(h2, 'roof/apex')``; labels for atoms, operators between their arguments.

    Unbound variables as letters, ``_`` if alone.
    """
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
    if arity == 2 and name in PRIORITY and not (names is not None and _is_node(goal)):
        own, chained = PRIORITY[name], {name, signature(goal[1])[0]} <= ROWS
        left, right = _side(goal[1], own + chained, names), _side(goal[2], own, names)
        right = f"({right})" if name in TIGHT and right[0] in "+-" else right
        return f"{left}{name}{right}" if name in TIGHT else f"{left} {name} {right}"
    if arity == 1 and name in ("-", "+"):
        inner = _text(goal[1], names)
        return f"{name}({inner})" if _priority(goal[1]) or inner[0] in "+-" else f"{name}{inner}"
    if name in PRIORITY:
        return shown(problog_term(goal), names)
    return f"{goal[0]}({_arguments(goal, names)})" if names is None else _named(goal, names)


def _named(goal: Small, names: Names) -> str:
    head = shown(problog_term((goal[0], *([("x",)] * (len(goal) - 1)))), names).split("(", 1)[0]
    return f"{head}({_arguments(goal, names)})"


def _arguments(goal: Small, names: Names | None) -> str:
    return ", ".join(f"({_text(a, names)})" if signature(a) in BETWEEN else _text(a, names) for a in goal[1:])


def _priority(term: Small) -> int:
    """Of the operator that it is written with, 0 without one."""
    name, arity = signature(term)
    return PRIORITY.get(name, 0) if arity == 2 else 200 if arity == 1 and name in ("-", "+") else 0


def _side(term: Small, limit: int, names: Names | None) -> str:
    """A side of an operator, in parentheses where its own priority reaches the limit."""
    return f"({_text(term, names)})" if _priority(term) >= limit else _text(term, names)


def _is_node(term: Small) -> bool:
    """``h1/roof``, a hypothesis and a part of it, and no division."""
    return signature(term) == ("/", 2) and all(isinstance(side, tuple) and is_atom(side) for side in term[1:])


def _list(goal: Small, names: Names | None) -> str:
    members = []
    while signature(goal) == (".", 2):
        members.append(_text(goal[1], names))
        goal = goal[2]
    tail = "" if signature(goal) == ("[]", 0) else f"|{_text(goal, names)}"
    return f"[{', '.join(members)}{tail}]"
