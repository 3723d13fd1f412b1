"""The first layer: the syntax tree is held to the allow-list (``allowlist``), by ProbLog's own parser and its own signatures.

A goal must be written out: a variable is no goal, neither in a body nor as an argument of call/N, findall/3 and the like. So a name that is
built at run time is never called, and every call is seen here.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from problog.engine import DefaultEngine
from problog.errors import ProbLogError
from problog.logic import And, AnnotatedDisjunction, Clause, Constant, Not, Or, Term, Var
from problog.program import PrologString

from plogic.errors import ProgramError, UnknownPredicateError, UnsafeProgramError
from plogic.safety.allowlist import AGGREGATES, ARITHMETIC, GOALS, LIBRARIES, META, SPECIAL_HEADS

if TYPE_CHECKING:
    from collections.abc import Iterator

LONGEST_TEXT = 20_000_000
"""Characters that a program may have."""


@dataclass(frozen=True)
class Source:
    """A parsed text with what is needed to say where something stands."""

    text: str
    file: str
    statements: tuple[Any, ...]
    program: Any = field(repr=False)

    def place(self, term: Any) -> dict[str, Any]:  # noqa: ANN401 - a term of ProbLog's
        """file, line and column of a term, as far as ProbLog remembers them; else of its first part that has a place."""
        for part in _inside(term):
            location = getattr(part, "location", None)
            if location is not None and location[1] is not None:
                _, line, column = self.program.lineno(location[1])
                return {"file": self.file, "line": line, "column": column}
        return {"file": self.file}


def parse(text: str, file: str = "program", identifier: int = 0) -> Source:
    """Parse program text; raises ProgramError with the place of a syntax error.

    ``identifier`` marks the places for a ClauseDB of many files.
    """
    if len(text) > LONGEST_TEXT:
        raise ProgramError(f"longer than {LONGEST_TEXT} characters", file=file)
    try:
        program = PrologString(text, identifier=identifier)
        return Source(text, file, tuple(program), program)
    except ProbLogError as error:
        raise ProgramError(error.base_message, file=file, **_line_column(text, error.location)) from None
    except RecursionError:
        raise ProgramError("nested too deeply", file=file) from None
    except Exception as error:  # noqa: BLE001 - the parser raises what its actions raise (a cut, a bad number)
        raise ProgramError(f"cannot be read as ProbLog ({error})", file=file) from None


def check_source(source: Source, known: frozenset[str] = frozenset(), protected: frozenset[str] = frozenset()) -> frozenset[str]:
    """Hold every statement to the allow-list; the signatures that the text defines.

    ``known`` may be called beside what the text defines; ``protected`` may not be defined by it.
    """
    try:
        defined = frozenset(head.signature for statement in source.statements for head in heads(statement))
        checker = _Checker(source, defined | known | SPECIAL_HEADS, protected, _builtins())
        for statement in source.statements:
            checker.statement(statement)
    except RecursionError:
        raise ProgramError("nested too deeply", file=source.file) from None
    return defined


def heads(statement: Any) -> list[Any]:  # noqa: ANN401 - a term of ProbLog's
    """The heads of a clause, a fact or an annotated disjunction; none of a directive."""
    if isinstance(statement, AnnotatedDisjunction):
        return list(statement.heads)
    if isinstance(statement, Or):
        return list(statement.to_list())
    if isinstance(statement, Clause):
        return [] if is_directive(statement) else [statement.head]
    return [statement] if isinstance(statement, Term) else []


def check_goal(source: Source, known: frozenset[str]) -> Any:  # noqa: ANN401 - a term of ProbLog's
    """The one goal that a text consists of, held to the allow-list."""
    if len(source.statements) != 1 or isinstance(source.statements[0], (Clause, AnnotatedDisjunction)):
        raise ProgramError("a goal is one term, like present(h1)", file=source.file)
    goal = source.statements[0]
    if getattr(goal, "probability", None) is not None:
        raise ProgramError("a goal has no probability of its own", **source.place(goal))
    try:
        _Checker(source, known, frozenset(), _builtins()).goal(goal, 0)
    except RecursionError:
        raise ProgramError("nested too deeply", file=source.file) from None
    return goal


def is_directive(statement: Any) -> bool:  # noqa: ANN401 - a term of ProbLog's
    """Whether the statement is ``:- goal``."""
    return isinstance(statement, Clause) and statement.head.signature == "_directive/0" and statement.head.location[1] is None


@dataclass(frozen=True)
class _Checker:
    source: Source
    callable: frozenset[str]
    protected: frozenset[str]
    builtins: frozenset[str]

    def refuse(self, term: Any, reason: str) -> None:  # noqa: ANN401 - a term of ProbLog's
        raise UnsafeProgramError(reason, **self.source.place(term))

    def statement(self, statement: Any) -> None:  # noqa: ANN401 - a term of ProbLog's
        if is_directive(statement):
            self.directive(statement.body)
            return
        found = heads(statement)
        if not found or any(isinstance(head, (Var, Constant)) for head in found):
            raise ProgramError("a clause must start with a predicate", **self.source.place(statement))
        for head in found:
            self.head(head)
        if isinstance(statement, (Clause, AnnotatedDisjunction)):
            self.goal(statement.body, 0)

    def directive(self, goal: Any) -> None:  # noqa: ANN401 - a term of ProbLog's
        library: Any = goal.args[0] if isinstance(goal, Term) and goal.signature in ("use_module/1", "use_module/2") else None
        if not _is_pure_library(library):
            self.refuse(goal, f"directive {_shown(goal)}: only use_module(library(L)) is allowed, L one of {', '.join(sorted(LIBRARIES))}")

    def head(self, head: Any) -> None:  # noqa: ANN401 - a term of ProbLog's
        name = str(head.functor).strip("'")
        if head.signature in self.protected:
            raise ProgramError(f"{head.signature} is defined by the program and cannot be added to", **self.source.place(head))
        if (
            head.signature in self.builtins
            or head.signature in META
            or name.startswith(("_", "plogic "))
            or name in ("choice", "body", ":")
        ):
            self.refuse(head, f"{head.signature} belongs to ProbLog and cannot be defined")
        if head.probability is not None:
            self.label(head.probability)
        if head.signature in SPECIAL_HEADS:
            self.goal(head.args[0], 0)

    def label(self, label: Any) -> None:  # noqa: ANN401 - a term of ProbLog's
        if isinstance(label, (Constant, Var)):
            return
        if label is None or str(label.functor).strip("'") not in ARITHMETIC:
            self.refuse(label, f"probability {_shown(label)}: only numbers, variables and arithmetic are allowed")
        for argument in label.args:
            self.label(argument)

    def goal(self, goal: Any, added: int) -> None:  # noqa: ANN401 - a term of ProbLog's
        """A goal with ``added`` more arguments than are written.

        Its other arguments are data: they may hold anything, and nothing calls them.
        """
        if isinstance(goal, (Var, Constant)) or not isinstance(goal, Term):
            self.refuse(goal, f"goal {_shown(goal)}: a goal must be written out, not be a variable or a value")
        signature = f"{goal.signature.rsplit('/', 1)[0]}/{goal.arity + added}"
        self.called(goal, signature)
        goals = dict(META.get(signature, ())) if not added else {}
        if added and signature in META:
            self.refuse(goal, f"{signature} cannot be called through another predicate")
        for position, more in goals.items():
            self.goal(goal.args[position], more)
        if signature == "aggregate/5" and str(goal.args[0].functor) not in AGGREGATES:
            self.refuse(goal, f"aggregate {_shown(goal.args[0])}: only {', '.join(sorted(AGGREGATES))} are allowed")

    def called(self, goal: Any, signature: str) -> None:  # noqa: ANN401 - a term of ProbLog's
        if signature in GOALS:
            return
        if signature in self.builtins or signature.startswith(("_", "./")):
            self.refuse(goal, f"{signature} is not allowed: it is not on the list of predicates that cannot reach files or code")
        if signature not in self.callable:
            self.unknown(goal, signature)

    def unknown(self, goal: Any, signature: str) -> None:  # noqa: ANN401 - a term of ProbLog's
        if signature.rsplit("/", 1)[0] in _DANGEROUS:
            self.refuse(goal, f"{signature} is not allowed: it is not on the list of predicates that cannot reach files or code")
        raise UnknownPredicateError(f"no clauses for {signature}", **self.source.place(goal))


_DANGEROUS = frozenset({
    "use_module", "consult", "load_external", "csv_load", "sqlite_load", "subquery", "assertz", "asserta", "assert", "retract",
    "retractall",
    "open", "see", "tell", "shell", "halt", "initialization", "module", "db", "call_external", "include", "ensure_loaded",
    "read", "get_char",
})  # fmt: skip


def _is_pure_library(term: Any) -> bool:  # noqa: ANN401 - a term of ProbLog's
    return isinstance(term, Term) and term.functor == "library" and term.arity == 1 and str(term.args[0]) in LIBRARIES


def _builtins() -> frozenset[str]:
    return frozenset(DefaultEngine().get_builtins())


def _inside(term: Any) -> Iterator[Any]:  # noqa: ANN401 - a term of ProbLog's
    yield term
    for argument in getattr(term, "args", ()) or ():
        if isinstance(argument, (Term, And, Or, Not)):
            yield from _inside(argument)


def _shown(term: Any) -> str:  # noqa: ANN401 - a term of ProbLog's
    text = str(term)
    return text if len(text) <= 60 else text[:57] + "..."


def _line_column(text: str, location: object) -> dict[str, Any]:
    """ProbLog gives a parse error's place as (file, line, column), or as a position."""
    if isinstance(location, tuple) and len(location) == 3:
        return {"line": location[1], "column": location[2]}
    if isinstance(location, int):
        before = text[:location]
        return {"line": before.count("\n") + 1, "column": location - before.rfind("\n")}
    return {}
