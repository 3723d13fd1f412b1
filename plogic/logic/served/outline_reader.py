"""Reads a program's outline, in the session's process: held to the allow-list, never run."""

from collections.abc import Iterator
from typing import Any

from problog.logic import And, AnnotatedDisjunction, Clause, Constant, Not, Or, Term, Var
from problog.parser import PrologParser
from problog.program import ExtendedPrologFactory

from plogic.logic.safety.atoms import Names
from plogic.logic.safety.check import Source, check_source, heads, parse
from plogic.logic.safety.mapping import mapped


def outline(request: dict[str, Any]) -> dict[str, Any]:
    """``{"predicates": [[name, arity, [clause, ...]], ...], "constants": [...]}``.

    Raises ProgramError with the place of a mistake.
    """
    predicates: dict[tuple[str, int], list[str]] = {}
    constants: dict[str, None] = {}
    known: frozenset[str] = frozenset()
    for item in request["texts"]:
        source = parse(item["text"], item["file"])
        known |= frozenset() if request.get("trust") else check_source(source, known=known)
        written = (
            _written(source)
            if request["labels"] is None
            else [f"{mapped(s, Names(request['labels'], {}))}." for s in source.statements]
        )
        for statement, text in zip(source.statements, written, strict=True):
            for name, arity in dict.fromkeys((str(head.functor), head.arity) for head in heads(statement)):
                predicates.setdefault((name, arity), []).append(text)
            constants |= dict.fromkeys(_constants(statement))
    return {
        "predicates": [[name, arity, found] for (name, arity), found in predicates.items()],
        "constants": list(constants),
    }


def _written(source: Source) -> list[str]:
    """Each statement as its author wrote it, from its first token to its full stop, by ProbLog's own tokens."""
    parser = PrologParser(ExtendedPrologFactory())
    found = parser._extract_statements(source.text, parser._tokenize(source.text))  # noqa: SLF001 - where statements end is said nowhere else
    return [source.text[tokens[0].location : tokens[-1].location + len(tokens[-1].string)] + "." for tokens in found]


def _constants(term: Any, depth: int = 0) -> Iterator[str]:  # noqa: ANN401 - a term of ProbLog's
    """The atoms in argument places, below the predicates of heads and bodies."""
    if isinstance(term, (Var, Constant)) or not isinstance(term, Term):
        return
    inner = [*term.heads, term.body] if isinstance(term, AnnotatedDisjunction) else term.args
    connective = isinstance(term, (And, Or, Not, Clause, AnnotatedDisjunction))
    if depth and not connective and not term.arity and str(term.functor) not in ("[]", "true"):
        yield str(term.functor)
    for argument in inner:
        yield from _constants(argument, depth if connective else depth + 1)
