"""The first layer: ProbLog's own parser and signatures hold the syntax tree to the allow-list (``allowlist``).

It sees what is written out, wherever a goal may stand: bodies, directives, queries, evidence, arguments of call/N,
findall/3 and the like. It says all that is wrong at once. What a program builds at run time (``X =.. [consult, f],
call(X)``) is for the second layer (``engine``).
"""

import re
import warnings
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from functools import lru_cache
from typing import Any

from problog.engine import DefaultEngine
from problog.errors import ProbLogError
from problog.logic import And, AnnotatedDisjunction, Clause, Constant, Not, Or, Term, Var
from problog.program import PrologString

from geometry.digits import TOO_LONG, start_of_too_long
from plogic.base.errors import ProgramError, UnknownPredicateError, UnsafeProgramError
from plogic.logic.safety import labels
from plogic.logic.safety.allowlist import (
    GOALS,
    LIBRARIES,
    LIBRARY_FILES,
    LIBRARY_META,
    LISTS,
    LOADERS,
    META,
    SPECIAL_HEADS,
)
from plogic.logic.safety.closest import closest
from plogic.logic.safety.rows import LONG, MOST, QUICK, SHORT_TEXT, rows_in
from plogic.logic.safety.slips import slip

LONGEST_TEXT = 20_000_000
"""Characters that a program may have."""
_NO_NUMBERS = r"%[^\n]*+|'(?:[^'\\]|\\.|'')*+(?:'|\Z)|\"(?:[^\"\\]|\\.)*+(?:\"|\Z)"
"""Comments and quoted texts of a program. What is not closed reaches to the end, so that nothing is looked at twice."""
TOO_LONG_ROWS = "too many operators in a row (a, b, c, ...): break the row up into clauses"
TOO_DEEP = "nested too deeply"


@dataclass(frozen=True, eq=False)
class Source:
    """A parsed text with what is needed to say where something stands."""

    text: str
    file: str
    statements: tuple[Any, ...]
    program: Any = field(repr=False)

    def place(self, term: Any) -> dict[str, Any]:  # noqa: ANN401 - a term of ProbLog's
        """file, line and column of a term, as far as ProbLog remembers them.

        Else of its first part that has a place.
        """
        for part in _inside(term):
            location = getattr(part, "location", None)
            if location is not None and location[1] is not None:
                _, line, column = self.program.lineno(location[1])
                return {"file": self.file, "line": line, "column": column}
        return {"file": self.file}


def parse(text: str, file: str = "program", identifier: int = 0, most: int = MOST) -> Source:
    """Parse program text; raises ProgramError with the place of a syntax error.

    ``identifier`` marks the places for a ClauseDB of many files. ``most``: what its long rows may cost (``Rows.work``).
    """
    if len(text) > LONGEST_TEXT:
        raise ProgramError(f"longer than {LONGEST_TEXT} characters", file=file)
    if len(text) > LONG:
        rows = (_rows_before if len(text) <= SHORT_TEXT else rows_in)(text)
        if rows.deep is not None:
            raise ProgramError(TOO_DEEP, file=file, **_line_column(text, rows.deep))
        if rows.work > most:
            raise ProgramError(TOO_LONG_ROWS, file=file, **_line_column(text, rows.place))
    return (_remembered if len(text) <= SHORT_TEXT else _parsed)(text, file, identifier)


def parse_quickly(text: str, file: str, identifier: int = 0) -> Source:
    """As ``parse``, of what is read in a process without a limit too; raises ProgramError where it takes long."""
    if len(text) > SHORT_TEXT:
        raise ProgramError(f"longer than {SHORT_TEXT} characters", file=file)
    return parse(text, file, identifier, QUICK)


def glanced(text: str, file: str) -> Source | None:
    """The parsed text where that takes no time worth speaking of and there is no mistake in it, else None."""
    try:
        return parse_quickly(text, file)
    except ProgramError:
        return None


def _parsed(text: str, file: str, identifier: int) -> Source:
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # its parser's, of == and \==, which name its own file
            program = PrologString(text, identifier=identifier)
            source = Source(text, file, tuple(program), program)
    except ProbLogError as error:
        place = _line_column(text, error.location)
        found = slip(text, _position(text, place))
        reason, place = (error.base_message, place) if found is None else (found.said, _line_column(text, found.place))
        raise ProgramError(reason, file=file, **place) from None
    except RecursionError:
        raise ProgramError(TOO_DEEP, file=file) from None
    except Exception as error:  # noqa: BLE001 - the parser raises what its actions raise (a cut, a bad number)
        start = start_of_too_long(text, _NO_NUMBERS)
        if start is not None:
            raise ProgramError(TOO_LONG, file=file, **_line_column(text, start)) from None
        raise ProgramError(f"cannot be read as ProbLog ({error})", file=file) from None
    empty = _empty(source.statements) if _BRACKETS.search(text) else None
    if empty is not None:  # which ProbLog reads, and fails over later
        raise ProgramError(
            f"{empty.functor}() has brackets with nothing in them: leave them out", **source.place(empty)
        )
    return source


_BRACKETS = re.compile(r"\(\s*\)")


def _empty(statements: Sequence[Any]) -> Any:  # noqa: ANN401 - a term of ProbLog's
    """A term with brackets and nothing in them, the first; None where there is none."""
    waiting = [*reversed(statements)]
    while waiting:
        term = waiting.pop()
        arguments = getattr(term, "args", ())
        if any(argument is None for argument in arguments):
            return term
        waiting += reversed(arguments)
        if getattr(term, "probability", None) is not None:
            waiting.append(term.probability)
    return None


_remembered = lru_cache(maxsize=16)(_parsed)
"""A session asks one program many questions, and each request carries its text: a source is frozen, and is read
once. A long one is not kept, for its terms take some hundred times as many bytes."""
_rows_before = lru_cache(maxsize=16)(rows_in)


Mistake = tuple[type[ProgramError], str, Any]
"""What kind of error it is, what is wrong, and with which term."""
Look = Callable[[Source, frozenset[str]], Iterable[Mistake]]
"""Finds mistakes in a source beside what is ``known``."""


def check_source(
    source: Source,
    known: frozenset[str] = frozenset(),
    protected: frozenset[str] = frozenset(),
    also: Look | None = None,
) -> frozenset[str]:
    """Hold every statement to the allow-list; the signatures that the text defines.

    All that is wrong is told in one error.

    ``known`` may be called beside what the text defines; ``protected`` may not be defined by it. A text with something
    protected is a piece added to a program: it may call only what is known. A whole program may also name what has no
    clauses, as long as it is not called: that is told when it is. ``ANYTHING`` is among the signatures where the text
    alone does not tell what it defines. ``also`` finds further mistakes.
    """
    return (_held_before if len(source.text) <= SHORT_TEXT else _held)(source, known, protected, also)


def _held(source: Source, known: frozenset[str], protected: frozenset[str], also: Look | None) -> frozenset[str]:
    try:
        defined = frozenset(head.signature for statement in source.statements for head in heads(statement))
        defined |= frozenset({ANYTHING} if any(_is_open(statement) for statement in source.statements) else ())
        checker = _Checker(source, _closed(defined | known) if protected else None, protected, _builtins())
        for statement in source.statements:
            checker.statement(statement)
        checker.mistakes.extend(also(source, known) if also is not None else ())
    except RecursionError:
        raise ProgramError(TOO_DEEP, file=source.file) from None
    checker.tell()
    return defined


_held_before = lru_cache(maxsize=16)(_held)
"""What was found to be allowed is not looked through again with the next question."""


def heads(statement: Any) -> list[Any]:  # noqa: ANN401 - a term of ProbLog's
    """The heads of a clause, a fact or an annotated disjunction; none of a directive."""
    if isinstance(statement, AnnotatedDisjunction):
        return list(statement.heads)
    if isinstance(statement, Or):
        return list(statement.to_list())
    if isinstance(statement, Clause):
        return [] if is_directive(statement) else [statement.head]
    return [statement] if isinstance(statement, Term) else []


def _is_no_predicate(head: Any) -> bool:  # noqa: ANN401 - a term of ProbLog's
    """Whether a head is a variable, a number, several goals, or a number with one colon before a goal."""
    if isinstance(head, (Var, Constant, And)):
        return True
    return head.signature == ":/2" and isinstance(head.args[0], Constant) and isinstance(head.args[0].functor, float)


def check_goal(source: Source, known: frozenset[str]) -> Any:  # noqa: ANN401 - a term of ProbLog's
    """The one goal that a text consists of, held to the allow-list; it may call what is ``known``."""
    if len(source.statements) != 1 or isinstance(source.statements[0], (Clause, AnnotatedDisjunction, Var, Constant)):
        raise ProgramError("a goal is one term, like present(h1)", file=source.file)
    goal = source.statements[0]
    if getattr(goal, "probability", None) is not None:
        raise ProgramError("a goal has no probability of its own", **source.place(goal))
    checker = _Checker(source, _closed(known), frozenset(), _builtins())
    try:
        checker.goal(goal, 0)
    except RecursionError:
        raise ProgramError(TOO_DEEP, file=source.file) from None
    checker.tell()
    return goal


def is_directive(statement: Any) -> bool:  # noqa: ANN401 - a term of ProbLog's
    """Whether the statement is ``:- goal``."""
    return (
        isinstance(statement, Clause)
        and statement.head.signature == "_directive/0"
        and statement.head.location[1] is None
    )


def _closed(known: frozenset[str]) -> frozenset[str] | None:
    """What may be called; None where anything may turn out to be defined."""
    return None if ANYTHING in known else known | SPECIAL_HEADS


def _is_open(statement: Any) -> bool:  # noqa: ANN401 - a term of ProbLog's
    """Whether it may define what it does not name.

    It loads a library that is not all known here, or lets unknown predicates fail.
    """
    return any(
        part.signature in LOADERS | {"unknown/1", "module/2"}
        and not any(str(name) in LISTED_LIBRARIES for name in part.args)
        for part in _inside(statement)
        if isinstance(part, Term)
    )


@dataclass(frozen=True)
class _Checker:
    source: Source
    callable: frozenset[str] | None
    protected: frozenset[str]
    builtins: frozenset[str]
    mistakes: list[Mistake] = field(default_factory=list)

    def note(self, kind: type[ProgramError], term: Any, reason: str) -> None:  # noqa: ANN401 - a term of ProbLog's
        self.mistakes.append((kind, reason, term))

    def tell(self) -> None:
        """Raise all mistakes as one error: the first refusal leads, the others follow with their places."""
        if self.mistakes:
            first = next((mistake for mistake in self.mistakes if mistake[0] is UnsafeProgramError), self.mistakes[0])
            rest = [mistake for mistake in self.mistakes if mistake is not first]
            more = dict.fromkeys(with_place(reason, self.source.place(term)) for _, reason, term in rest)
            kind, reason, term = first
            raise kind(together(reason, list(more)), **self.source.place(term))

    def statement(self, statement: Any) -> None:  # noqa: ANN401 - a term of ProbLog's
        if is_directive(statement):
            self.directive(statement.body)
            return
        found = heads(statement)
        if not found or any(_is_no_predicate(head) for head in found):
            text = self.source.text
            mistaken = slip(text, _position(text, self.source.place(statement))) or slip(text, None)
            self.note(ProgramError, statement, mistaken.said if mistaken else "a clause must start with a predicate")
            return
        for head in found:
            self.head(head)
        for term, reason in labels.mistaken(found, self.source.text):
            self.note(ProgramError, term, reason)
        if isinstance(statement, (Clause, AnnotatedDisjunction)):
            self.goal(statement.body, 0)

    def directive(self, goal: Any) -> None:  # noqa: ANN401 - a term of ProbLog's
        """A goal that is called when the text is loaded; one that loads a file says what may be loaded."""
        if isinstance(goal, Term) and goal.signature in FILE_LOADERS and not self.loads_a_library(goal):
            self.note(UnsafeProgramError, goal, f"directive {_shown(goal)}: {LOADING}")
            return
        self.goal(goal, 0)

    def head(self, head: Any) -> None:  # noqa: ANN401 - a term of ProbLog's
        if head.signature in self.protected:
            self.note(ProgramError, head, f"{head.signature} is defined by the program and cannot be added to")
        if head.signature in self.builtins or str(head.functor).strip("'").startswith("plogic "):
            self.note(ProgramError, head, f"{head.signature} belongs to ProbLog and cannot be defined")
        if head.signature in SPECIAL_HEADS:
            self.goal(head.args[0], 0)

    def goal(self, goal: Any, added: int) -> None:  # noqa: ANN401 - a term of ProbLog's
        """A goal with ``added`` more arguments than are written.

        A goal that is built at run time is not seen here, but by the engine. Arguments that are no goals are data and
        may hold anything.
        """
        if isinstance(goal, (Var, Constant)) or not isinstance(goal, Term):
            return
        signature = f"{goal.signature.rsplit('/', 1)[0]}/{goal.arity + added}"
        self.called(goal, signature)
        for position, more in META.get(signature, LIBRARY_META.get(signature, ())):
            if position < goal.arity:
                self.goal(goal.args[position], more)

    def called(self, goal: Any, signature: str) -> None:  # noqa: ANN401 - a term of ProbLog's
        if signature in LOADERS and self.loads_a_library(goal):
            return
        if signature in self.builtins and signature not in GOALS:
            self.note(
                UnsafeProgramError,
                goal,
                f"{signature} is not allowed: {LOADING if signature in FILE_LOADERS else REASON}",
            )
        elif self.callable is not None and signature not in GOALS | LISTS | self.callable | frozenset(LIBRARY_META):
            hint = closest(signature, self.callable - SPECIAL_HEADS)
            self.note(UnknownPredicateError, goal, f"no clauses for {signature}{hint}")

    def loads_a_library(self, goal: Any) -> bool:  # noqa: ANN401 - a term of ProbLog's
        """Whether a loader names a pure library, or something that only the run can tell."""
        place = 1 if goal.signature.startswith("_") else 0
        name = goal.args[place] if place < goal.arity else None
        if not isinstance(name, Term) or isinstance(name, Var):
            return True
        if name.functor != "library" or name.arity != 1:
            return False
        library = name.args[0]
        return isinstance(library, Var) or str(library).strip("'") in LIBRARIES | LIBRARY_FILES


REASON = "it is not on the list of predicates that cannot reach files or code"
FILE_LOADERS = LOADERS | {"consult/1", "./2"}
LOADING = f"only use_module(library(L)) is allowed, L one of {', '.join(sorted(LIBRARIES - {'builtin'}))}"
ANYTHING = "*"
LISTED_LIBRARIES = frozenset({"library(lists)", "library(apply)", "library(aggregate)"})
"""Libraries whose predicates are all listed here."""
MOST_TOLD = 20
"""Mistakes that one message names."""


def together(first: str, more: list[str]) -> str:
    """Many mistakes in one line."""
    left = f"; and {len(more) - MOST_TOLD} more" if len(more) > MOST_TOLD else ""
    return "; also ".join([first, *more[:MOST_TOLD]]) + left


def with_place(reason: str, place: dict[str, Any]) -> str:
    """``file:line:column: reason``."""
    return ":".join(str(place[key]) for key in ("file", "line", "column") if key in place) + f": {reason}"


@lru_cache(maxsize=1)
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
    """ProbLog gives a parse error's place as (file, line, column), or as a position.

    Columns in the first line count from 0, in others from 1.
    """
    if isinstance(location, tuple) and len(location) == 3:
        return {"line": location[1], "column": location[2] + (location[1] == 1)}
    if isinstance(location, int):
        before = text[:location]
        return {"line": before.count("\n") + 1, "column": location - before.rfind("\n")}
    return {}


def _position(text: str, place: dict[str, Any]) -> int | None:
    """Where a place is in the text, from 0; None where it is not known."""
    if "line" not in place:
        return None
    begin = -1
    for _ in range(place["line"] - 1):
        begin = text.find("\n", begin + 1)
    return begin + int(place["column"])
