r"""The second layer of safety, ProbLog's engine behind the allow-list, and the errors of a run as errors of ours.

Every built-in that is not on the allow-list is overridden, and the database opens no file. This holds even where the
first layer is left out: whatever way a call is made (call/N, =.., a directive, a query, evidence, a clause that
assertz/1 adds), it ends here. A refusal cannot be caught: what a program swallows (try_call/N does) is raised when its
call returns.

An error states the mistake, its file, line and column, and all of its kind at once. A cycle that makes a program's
negation depend on itself is spelled out: ``a :- \+ b (u.pl:3), b :- a (u.pl:4)``. It is found among the clauses as they
are written: an edge leads from a clause's head to each goal of its body, and the shortest way back from a negated goal
to its head is the cycle.
"""

import os
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from functools import partial
from typing import Any, NoReturn

import problog
from problog.clausedb import ClauseDB
from problog.engine import DefaultEngine, NonGroundProbabilisticClause, UnknownClause
from problog.engine_builtin import CallModeError, IndirectCallCycleError, _builtin_subquery, _builtin_subquery_in_scope
from problog.engine_stack import BooleanBuiltIn, SimpleBuiltIn
from problog.errors import GroundingError, InconsistentEvidenceError, NonGroundQuery, ProbLogError
from problog.eval_nodes import NegativeCycle
from problog.logic import And, AnnotatedDisjunction, Clause, Constant, Not, Or, Term, Var

from plogic.base.errors import (
    BeliefError,
    InconsistentError,
    NegativeCycleError,
    NonGroundError,
    ProgramError,
    UnknownPredicateError,
    UnsafeProgramError,
)
from plogic.logic.safety.allowlist import (
    EVALUATORS,
    GOALS,
    LIBRARY_FILES,
    LIBRARY_META,
    LISTS,
    LOADERS,
    LOUD,
    META,
    SPECIAL_HEADS,
)
from plogic.logic.safety.check import Source, heads, is_directive, parse, together, with_place
from plogic.logic.safety.closest import closest
from plogic.logic.safety.collecting import guard
from plogic.logic.safety.open_negations import computed_early
from plogic.logic.safety.slips import DECLARED

FOLDER = problog.root_path("problog", "library")
"""ProbLog's own library; nothing outside it is ever opened."""
OPENED = frozenset(os.path.join(FOLDER, name) for name in LIBRARY_FILES)  # noqa: PTH118 - ProbLog compares these paths as text


class RefusedError(GroundingError):  # type: ignore[misc]
    """A built-in was called that is not on the allow-list, or a file was asked for."""


@dataclass
class _Refusals:
    """What was refused in the call that runs now, and how many calls deep that is."""

    found: list[RefusedError] = field(default_factory=list)
    depth: int = 0

    def tell(self) -> None:
        """Raise the first; once the outermost call has ended nothing is kept."""
        if not self.found:
            return
        first = self.found[0]
        if not self.depth:
            self.found.clear()
        raise first


class SafeDB(ClauseDB):  # type: ignore[misc]
    """A clause database that knows ProbLog's pure libraries and no other file."""

    def __init__(self, builtins: Any = None, parent: Any = None) -> None:  # noqa: ANN401 - as ClauseDB's
        self.refusals: _Refusals = _Refusals() if parent is None else parent.refusals
        super().__init__(builtins=builtins, parent=parent)

    def extend(self) -> "SafeDB":
        """As ClauseDB's (findall/3 works on such an extension), but safe like its parent."""
        return SafeDB(parent=self, builtins=self._ClauseDB__builtins)

    def refuse(self, reason: str, location: Any) -> NoReturn:  # noqa: ANN401 - a place of ProbLog's
        """Raise, and remember, in case the program swallows it."""
        error = RefusedError(reason, self.lineno(location) if location is not None else None)
        self.refusals.found.append(error)
        raise error

    def resolve_filename(self, filename: Any) -> str:  # noqa: ANN401 - a term of ProbLog's
        """The path of a pure library; raises RefusedError for anything else."""
        path = super().resolve_filename(filename)
        if path not in OPENED:
            self.refuse(f"loading {filename} is not allowed", getattr(filename, "location", None))
        return str(path)

    def load_external_module(self, filename: str) -> Any:  # noqa: ANN401 - as ClauseDB's
        """Python that ProbLog ships for its pure libraries, and no other."""
        if filename not in OPENED:
            self.refuse(f"loading {filename} is not allowed", None)
        return super().load_external_module(filename)


class SafeEngine(DefaultEngine):  # type: ignore[misc]
    """ProbLog's engine, its built-ins on an allow-list."""

    def load_builtins(self) -> None:
        """Load all, then override each that is not allowed."""
        super().load_builtins()
        for signature in list(self.get_builtins()):
            if signature in LOUD:
                self._override(signature, BooleanBuiltIn(_silent))
            elif signature not in GOALS | LOADERS:
                self._override(signature, partial(_refused, signature))
        guard(self)
        self._override("subquery/5", SimpleBuiltIn(_subquery))
        self._override("subquery_in_scope/6", SimpleBuiltIn(_subquery_in_scope))

    def _override(self, signature: str, function: Any) -> None:  # noqa: ANN401 - as ProbLog's
        name, _, arity = signature.rpartition("/")
        self.add_builtin(name, int(arity), function)

    def prepare(self, db: Any) -> Any:  # noqa: ANN401 - programs of ProbLog's
        """As ProbLog's, with a SafeDB."""
        result = SafeDB.createFrom(db, builtins=self.get_builtins())
        result.engine = self
        self._process_directives(result)
        return result

    def execute(self, node_id: int, database: Any = None, **options: Any) -> Any:  # noqa: ANN401 - as ProbLog's
        """As ProbLog's; raises what was refused on the way, also where the program swallowed it."""
        refusals = database.refusals
        refusals.depth += 1
        try:
            return super().execute(node_id, database=database, **options)
        finally:
            refusals.depth -= 1
            refusals.tell()


def engine_for(*, trust: bool = False, folder: str = ".") -> tuple[Any, Any]:
    """An engine and an empty database for it.

    Safe ones, or with trust ProbLog's own, files then being looked for from ``folder``.
    """
    if not trust:
        engine = SafeEngine()
        return engine, SafeDB(builtins=engine.get_builtins())
    engine = DefaultEngine()
    guard(engine)
    db = ClauseDB(builtins=engine.get_builtins())
    db.source_root = folder
    return engine, db


def _silent(*_: Any, **__: Any) -> bool:  # noqa: ANN401 - ProbLog's calls
    return True


def _subquery(term: Any, prob: Any, evidence: Any, semiring: Any, evaluator: Any, **options: Any) -> Any:  # noqa: ANN401
    _counts(evaluator, **options)
    return _builtin_subquery(term, prob, evidence, semiring, evaluator, **options)


def _subquery_in_scope(scope: Any, *terms: Any, **options: Any) -> Any:  # noqa: ANN401 - ProbLog's calls
    _counts(terms[-1], **options)
    return _builtin_subquery_in_scope(scope, *terms, **options)


def _counts(evaluator: Any, *, database: Any, location: Any = None, **_: Any) -> None:  # noqa: ANN401 - ProbLog's calls
    if str(evaluator) not in EVALUATORS:
        database.refuse(f"counting by {evaluator} is not allowed", location)


def _refused(signature: str, *_: Any, database: SafeDB, location: Any = None, **__: Any) -> NoReturn:  # noqa: ANN401 - ProbLog's calls
    """Stands in for a built-in."""
    reason = f"{signature} is not allowed: it is not on the list of predicates that cannot reach files or code"
    database.refuse(reason, location)


NEGATED = frozenset({"\\+/1", "not/1", "forall/2"})
COLLECTED = frozenset({"findall/3", "all/3", "all_or_none/3", "aggregate/5"})


@dataclass(frozen=True)
class Edge:
    """``head :- literal (file:line)``: signatures of both, what the goal stands under, and how it is written."""

    head: str
    goal: str
    under: frozenset[str]
    text: str
    line: tuple[str, int | None]


def spelt_cycle(sources: Iterable[Source], place: dict[str, Any], through: frozenset[str]) -> str:
    """The shortest cycle with an edge under one of ``through``, at best one at ``place``.

    Empty where the text shows none.
    """
    edges = list(_edges(sources))
    wanted = (place.get("file"), place.get("line"))
    marked = sorted((edge for edge in edges if edge.under & through), key=lambda edge: edge.line != wanted)
    ways: list[list[Edge]] = [[edge, *way] for edge in marked if (way := _way(edges, edge.goal, edge.head)) is not None]
    if not ways:
        return ""
    here = [way for way in ways if way[0].line == wanted]
    return ", ".join(edge.text for edge in min(here or ways, key=len))


def _way(edges: list[Edge], start: str, end: str) -> list[Edge] | None:
    """The shortest way from one predicate to another; the empty one from a predicate to itself."""
    ways: dict[str, list[Edge]] = {start: []}
    queue = [start]
    for here in queue:
        if here == end:
            return ways[here]
        for edge in edges:
            if edge.head == here and edge.goal not in ways:
                ways[edge.goal] = [*ways[here], edge]
                queue.append(edge.goal)
    return None


def _edges(sources: Iterable[Source]) -> Iterator[Edge]:
    for source in sources:
        for statement in source.statements:
            if isinstance(statement, (Clause, AnnotatedDisjunction)) and not is_directive(statement):
                for goal, under, written in goals_under(statement.body, frozenset(), None):
                    line = (source.file, source.place(goal).get("line"))
                    at = source.file if line[1] is None else f"{source.file}:{line[1]}"
                    for head in heads(statement):
                        yield Edge(
                            head.signature,
                            goal.signature,
                            under,
                            f"{head.with_probability()} :- {_written(written)} ({at})",
                            line,
                        )


def goals_under(goal: Any, under: frozenset[str], outer: Any) -> Iterator[tuple[Any, frozenset[str], Any]]:  # noqa: ANN401 - terms of ProbLog's
    """Each goal of a body, what it stands under, and the literal that shows it (with its negation)."""
    if isinstance(goal, (Var, Constant)) or not isinstance(goal, Term):
        return
    positions = META.get(goal.signature, LIBRARY_META.get(goal.signature, ()))
    if isinstance(goal, (And, Or, Not)) or any(added == 0 for _, added in positions):
        inner = under if isinstance(goal, (And, Or)) else under | {"\\+/1" if isinstance(goal, Not) else goal.signature}
        shown = outer if isinstance(goal, (And, Or)) else outer or goal
        for position, _ in positions or [(i, 0) for i in range(len(goal.args))]:
            yield from goals_under(goal.args[position], inner, shown)
    else:
        yield goal, under, outer if under & (NEGATED | COLLECTED) and outer is not None else goal


def _written(literal: Any) -> str:  # noqa: ANN401 - a term of ProbLog's
    inner = literal.args[0] if isinstance(literal, Not) else None
    shown = f"({inner})" if isinstance(inner, (And, Or)) else inner
    return str(literal) if inner is None else f"{literal.functor} {shown}"


ERROR_KINDS: tuple[tuple[type[ProbLogError], type[ProgramError]], ...] = (
    (RefusedError, UnsafeProgramError),
    (UnknownClause, UnknownPredicateError),
    (NegativeCycle, NegativeCycleError),
    (NonGroundProbabilisticClause, NonGroundError),
    (NonGroundQuery, NonGroundError),
)
OFFERED = {
    **dict.fromkeys(LISTS, "lists"), **dict.fromkeys(LIBRARY_META, "apply"), "aggregate/5": "aggregate", ":/2": "scope",
    **dict.fromkeys(("cut/1", "cut/2"), "cut"), "on_fail/2": "control", **dict.fromkeys(("assertz/1", "retract/1", "retractall/1"), "assert"),
    **dict.fromkeys(("recorda/2", "recordz/2", "recorded/2", "recorda/3", "recordz/3", "recorded/3", "erase/1", "instance/2"), "record"),
    **dict.fromkeys(("concat/2", "join/3", "str2lst/2", "lst2str/2", "str2int/2", "sub_string/5"), "string"), "=>/2": "collect",
}  # fmt: skip
"""Signature → the library that defines it."""
NONE_SUCH = {
    "!/0": "ProbLog has no cut: let each clause say when it holds, or see library(cut)",
    **dict.fromkeys(("~/2", "normal/2"), "choices of plogic are discrete: give values with a probability each"),
    **dict.fromkeys((f"{name}/1" for name in DECLARED), "ProbLog needs no such line: leave it out"),
    "->/2": "ProbLog has no if-then-else: write (Condition, Then ; \\+ Condition, Else)",
}


def told(error: Exception, texts: list[dict[str, str]], db: Any = None) -> NoReturn:  # noqa: ANN401 - a ClauseDB
    """An error of ProbLog's as ours.

    ``texts``: ``{"text", "file"}`` of each piece; ``db``: the database that ran them, if there is one.
    """
    if isinstance(error, (BeliefError, MemoryError, RecursionError)):
        raise error
    if isinstance(error, InconsistentEvidenceError):
        raise InconsistentError("no world satisfies the evidence: its probability is 0") from None
    if not isinstance(error, ProbLogError):
        raise ProgramError(
            f"ProbLog cannot run this program ({_one_line(f'{type(error).__name__}: {error}')})", file=texts[0]["file"]
        ) from None
    place: dict[str, Any] = {"file": texts[0]["file"]}
    location = error.location
    if db is not None and isinstance(location, tuple) and len(location) == 2 and location[1] is not None:
        location = db.lineno(location, force_filename=True)
    if isinstance(location, tuple) and len(location) == 3:
        file, line, column = location
        place = {"file": file or texts[0]["file"], "line": line, "column": column}
    kind = next((ours for problem, ours in ERROR_KINDS if isinstance(error, problem)), ProgramError)
    raise kind(_reason(error, place, texts, db), **place) from None


def _reason(error: ProbLogError, place: dict[str, Any], texts: list[dict[str, str]], db: Any) -> str:  # noqa: ANN401
    if isinstance(error, UnknownClause):
        defined = _defined(texts)
        first = unknown(error.signature, defined)
        more = (
            []
            if db is None
            else [line for line in _unknown_calls(db, texts, defined) if line != with_place(first, place)]
        )
        return together(first, more)
    if isinstance(error, NegativeCycle):
        cycle = spelt_cycle(_sources(texts), place, NEGATED)
        return "a negation depends on itself (negative cycle)" + (cycle and f": {cycle}")
    if isinstance(error, IndirectCallCycleError):
        cycle = spelt_cycle(_sources(texts), place, COLLECTED)
        return "a goal that collects answers (findall/3, all/3) depends on itself" + (cycle and f": {cycle}")
    if isinstance(error, NonGroundProbabilisticClause):
        return _kept_open(_sources(texts), place)
    if isinstance(error, NonGroundQuery):
        return "the goal keeps a variable that nothing binds"
    early = computed_early(_sources(texts), place) if isinstance(error, CallModeError) else ""
    return early or _one_line(error.base_message)


def _defined(texts: list[dict[str, str]]) -> frozenset[str]:
    """The signatures of all heads of the texts."""
    found = [head for source in _sources(texts) for statement in source.statements for head in heads(statement)]
    return frozenset(head.signature for head in found) - SPECIAL_HEADS


def unknown(signature: str, defined: frozenset[str]) -> str:
    """What to say of a call to a predicate without clauses, beside those that are ``defined``."""
    plain = signature.replace("'", "")
    library = OFFERED.get(plain)
    hint = NONE_SUCH.get(plain) or (library and f":- use_module(library({library})) would define it")
    return f"no clauses for {plain}" + (f" ({hint})" if hint else closest(plain, defined))


def _unknown_calls(db: Any, texts: list[dict[str, str]], defined: frozenset[str]) -> list[str]:  # noqa: ANN401 - a ClauseDB
    """Every call in the texts to a predicate without clauses, with its place, in the order of the texts."""
    files = [item["file"] for item in texts]
    calls = [
        node
        for _, node in db.enum_nodes()
        if type(node).__name__ == "call" and node.location and node.defnode >= 0 and not db.get_node(node.defnode)
    ]
    spots = ((node, db.lineno(node.location, force_filename=True)) for node in calls)
    found = (
        (files.index(spot[0]), spot[1], spot[2], unknown(f"{node.functor}/{len(node.args)}", defined))
        for node, spot in spots
        if spot is not None and spot[0] in files
    )
    return [
        with_place(reason, {"file": files[i], "line": line, "column": column})
        for i, line, column, reason in sorted(found)
    ]


def _sources(texts: list[dict[str, str]]) -> list[Source]:
    return [parse(item["text"], item["file"]) for item in texts]


def _kept_open(sources: Iterable[Source], place: dict[str, Any]) -> str:
    """Which variables of the probabilistic clause at a place its body does not bind."""
    for source in sources:
        for statement in source.statements:
            here = [head for head in heads(statement) if source.place(head) == place]
            if here:
                body = _names(getattr(statement, "body", None))
                kept = [
                    name
                    for head in here
                    for name in dict.fromkeys(_names(head) + _names(head.probability))
                    if name not in body
                ]
                return f"{here[0]} is a choice that keeps {' and '.join(kept) or 'a variable'} open: its body must bind it, or the call must"
    return "a probabilistic clause keeps a variable that its body does not bind"


def _names(term: Any) -> list[str]:  # noqa: ANN401 - a term of ProbLog's
    return [] if term is None else sorted(str(variable) for variable in term.variables())


def _one_line(text: str) -> str:
    return " ".join(text.split())[:300]
