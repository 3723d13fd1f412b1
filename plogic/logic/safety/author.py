"""The knowledge base author's own rules: checked, mapped on their syntax tree, and written out again (§8, layer 4).

``bindings`` gives the values of a goal's variables in one of its answers: ``bindings("object(H, T)", "object(h1, 'big
box')")`` → ``{"H": "h1", "T": "big box"}``.
"""

import warnings
from typing import Any

from plogic.base.errors import ProgramError
from plogic.logic.safety.atoms import Names

FILE = "rules.pl"


def author_rules(text: str, names: Names, program: frozenset[str], file: str = FILE) -> list[str]:
    """The clauses, one text each, and what makes constraints of them; raises ProgramError at the place of a mistake.

    ``program``: the signatures that the generated program defines, such as ``present/1``.

    They may call the vocabulary, define predicates and choices of their own, observe, and constrain
    (``plogic.logic.safety.added``). They may not add to what the program defines, nor ask.
    """
    if not text.strip():
        return []
    load_problog()
    from plogic.logic.safety.added import check_added, lawful
    from plogic.logic.safety.check import is_directive, parse
    from plogic.logic.safety.mapping import mapped
    from plogic.logic.safety.rows import QUICK

    source = parse(text, file, most=QUICK)
    spelled = parse("\n".join(f"{mapped(s, names)}." for s in source.statements if not is_directive(s)), file)
    check_added(source, program)
    written = [s if is_directive(s) else mapped(s, names) for s in source.statements]
    if [str(s) for s in written if not is_directive(s)] != [str(s) for s in spelled.statements]:
        raise ProgramError("a clause cannot be written back as it was read", file=file)
    law = lawful(source, program).removeprefix(text).strip()
    return [f"{s}." for s in written] + ([law] if law else [])


def observes(text: str, file: str = FILE) -> bool:
    """Whether a text has evidence or constraints; raises ProgramError where it cannot be read."""
    lines = [line for line in text.splitlines() if not line.lstrip().startswith("%")]
    if not any("evidence" in line or "constraint" in line for line in lines):
        return False  # without ProbLog
    load_problog()
    from plogic.logic.safety.added import observations
    from plogic.logic.safety.check import parse

    return bool(observations(parse(text, file)))


def load_problog() -> None:
    """Import ProbLog; the copy of pyparsing that it ships warns of its age, which is no user's business."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)
        import problog.program  # noqa: F401


Value = str | int | float
"""A constant: a name without its quotes, or a number; any other term is given as its text."""


def bindings(goal: str, answer: str) -> dict[str, Value]:
    """Return the value of each named variable of ``goal``, in the order in which they appear.

    None where ``answer`` is no instance of it.
    """
    load_problog()
    from plogic.logic.safety.check import parse

    try:
        (asked,), (found,) = (parse(f"{text.strip().removesuffix('.')}.").statements for text in (goal, answer))
    except (ProgramError, ValueError):
        return {}
    return _matched(asked, found)


def _matched(asked: Any, found: Any) -> dict[str, Value]:  # noqa: ANN401 - terms of ProbLog's
    """Match two terms from the outside in; the first place of a variable decides."""
    from problog.logic import Constant, Term, Var

    if isinstance(asked, Var):
        return {} if asked.name.startswith("_") or isinstance(found, Var) else {asked.name: _value(found)}
    if (
        not isinstance(asked, Term)
        or isinstance(asked, Constant)
        or not isinstance(found, Term)
        or asked.arity != found.arity
    ):
        return {}
    result: dict[str, Value] = {}
    for one, other in zip(asked.args, found.args, strict=True):
        for name, value in _matched(one, other).items():
            result.setdefault(name, value)
    return result


def _value(term: Any) -> Value:  # noqa: ANN401 - a term of ProbLog's
    from problog.logic import Constant

    from plogic.logic.safety.mapping import label_of

    label = label_of(term)
    if label is not None:
        return label
    if isinstance(term, Constant) and isinstance(term.functor, (int, float)):
        return term.functor
    return str(term)
