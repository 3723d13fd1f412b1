"""From what users write to what programs say, and back, on the syntax tree (contract, "Names").

``'roof/apex'`` → ``f1``; ``'h1/roof/apex'`` and ``h1/'roof/apex'`` → ``h1/f1``; ``atom(X)`` → ``atom_node(X)``;
``case(H, F, 'A')`` → ``case(H, F, a)``.
"""

from typing import Any

from problog.logic import AggTerm, And, AnnotatedDisjunction, Clause, Constant, Not, Or, Term, Var

from plogic.logic.safety.atoms import SPELLINGS, Names, own_atom

CASE_ATOMS = {"A": "a", "B": "b", "C": "c", "D": "d"}


def mapped(term: Any, names: Names) -> Any:  # noqa: ANN401 - terms of ProbLog's
    """The term, clause or goal with every label replaced by its atom; places are kept."""
    if isinstance(term, AnnotatedDisjunction):
        return AnnotatedDisjunction(
            [mapped(h, names) for h in term.heads], mapped(term.body, names), location=term.location
        )
    if isinstance(term, (Clause, And, Or)):
        return type(term)(*(mapped(a, names) for a in term.args), location=term.location)
    if isinstance(term, Not):
        return Not(term.functor, mapped(term.args[0], names), location=term.location)
    if not isinstance(term, Term) or isinstance(term, (Var, AggTerm)):
        return term
    return _node(term, names) or _leaf(term, names) or _compound(term, names)


def _compound(term: Any, names: Names) -> Any:  # noqa: ANN401
    arguments = [mapped(argument, names) for argument in term.args]
    if term.signature == "case/3":
        arguments[2] = _case(arguments[2])
    result = term.with_args(*arguments)
    spelling = SPELLINGS.get((_plain(term), term.arity))
    return result if spelling is None else Term(spelling, *arguments, p=term.probability, location=term.location)


def _case(term: Any) -> Any:  # noqa: ANN401
    letter = label_of(term)
    return Term(CASE_ATOMS[letter], location=term.location) if letter in CASE_ATOMS else term


def _leaf(term: Any, names: Names) -> Any | None:  # noqa: ANN401
    """A quoted name, a string, or an atom that stands for a label; None where the term is none of these."""
    label = label_of(term)
    if label is None:
        return None
    if label in names.atoms:
        return Term(names.atoms[label], p=term.probability, location=term.location)
    return _path(label, names) if "/" in label else None


def _node(term: Any, names: Names) -> Any | None:  # noqa: ANN401
    """``h1/roof/apex``, written without quotes or with some."""
    if term.signature != "//2":
        return None
    left, right = _flat(term.args[0]), _flat(term.args[1])
    return None if left is None or right is None else _path(f"{left}/{right}", names)


def _path(label: str, names: Names) -> Any | None:  # noqa: ANN401
    for i, letter in enumerate(label):
        if letter == "/" and label[:i] in names.atoms and label[i + 1 :] in names.atoms:
            return Term(
                "'/'", Term(names.atoms[label[:i]]), Term(names.atoms[label[i + 1 :]]), priority=400, opspec="yfx"
            )
    return None


def _flat(term: Any) -> str | None:  # noqa: ANN401
    if isinstance(term, Term) and term.signature == "//2":
        left, right = _flat(term.args[0]), _flat(term.args[1])
        return None if left is None or right is None else f"{left}/{right}"
    return label_of(term)


def _plain(term: Any) -> str:  # noqa: ANN401
    return str(term.functor).strip("'")


def label_of(term: Any) -> str | None:  # noqa: ANN401
    """The name that a constant writes: ``'roof/apex'``, ``"roof/apex"`` and ``roof`` alike.

    None of a number or a compound.
    """
    if isinstance(term, Constant):
        return str(term.functor)[1:-1] if term.is_string() else None
    if not isinstance(term, Term) or isinstance(term, (Var, And, Or, Not)) or term.arity:
        return None
    text = str(term.functor)
    return (
        text[1:-1].replace("\\'", "'").replace("\\\\", "\\") if len(text) > 1 and text[0] == text[-1] == "'" else text
    )


def shown(term: Any, names: Names | None) -> str:  # noqa: ANN401
    """The term as users write it, labels for atoms; unbound variables as ``_``. Without names, as ProbLog writes it."""
    if isinstance(term, Var) or (names is None and isinstance(term, Term)):
        return str(term)
    if term is None or isinstance(term, int):
        return "_"
    if isinstance(term, Not):
        return f"\\+ {shown(term.args[0], names)}"
    if isinstance(term, (And, Or)):
        mark = ", " if isinstance(term, And) else " ; "
        return mark.join(shown(argument, names) for argument in term.args)
    if not isinstance(term, Term) or isinstance(term, Constant) or _plain(term) in (".", "[]"):
        return _shown_rest(term, names)
    arguments = [shown(argument, names) for argument in term.args]
    return _shown_compound(term, arguments) if arguments else _shown_atom(str(term.functor), names)


def _shown_rest(term: Any, names: Names | None) -> str:  # noqa: ANN401
    if isinstance(term, Constant) or not isinstance(term, Term) or _plain(term) == "[]":
        return str(term)
    items = []
    while isinstance(term, Term) and term.signature == "./2":
        items.append(shown(term.args[0], names))
        term = term.args[1]
    tail = "" if isinstance(term, Term) and term.functor == "[]" else f" | {shown(term, names)}"
    return f"[{', '.join(items)}{tail}]"


def _shown_compound(term: Any, arguments: list[str]) -> str:  # noqa: ANN401
    name = _plain(term)
    if term.arity == 2 and not own_atom(name):
        space = "" if name == "/" else " "
        return f"{arguments[0]}{space}{name}{space}{arguments[1]}"
    back = {atom: label for (label, arity), atom in SPELLINGS.items() if arity == term.arity}
    return f"{back.get(name, str(term.functor))}({', '.join(arguments)})"


def _shown_atom(functor: str, names: Names | None) -> str:
    label = names.labels.get(functor) if names is not None else None
    if label is None or label == functor:
        return functor
    return "'" + label.replace("\\", "\\\\").replace("'", "\\'") + "'"
