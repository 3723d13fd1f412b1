"""The second layer: ProbLog's engine with every built-in overridden that is not on the allow-list, and a database that opens no file.

It holds even where the first layer is left out: whatever way a call is made (call/N, =.., a directive, a query,
evidence, a clause that assertz/1 adds), it ends here. A refusal cannot be caught: what a program swallows (try_call/N
does) is raised when its call returns.
"""

from __future__ import annotations

import os
from dataclasses import dataclass, field
from typing import Any, NoReturn

import problog
from problog.clausedb import ClauseDB
from problog.engine import DefaultEngine
from problog.engine_builtin import _builtin_subquery, _builtin_subquery_in_scope
from problog.engine_stack import BooleanBuiltIn, SimpleBuiltIn
from problog.errors import GroundingError

from plogic.logic.safety.allowlist import EVALUATORS, GOALS, LIBRARY_FILES, LOADERS, LOUD

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

    def extend(self) -> SafeDB:
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
                self._override(signature, _Refusal(signature))
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
    """An engine and an empty database for it: safe ones, or with trust ProbLog's own, files then being looked for from ``folder``."""
    if not trust:
        engine = SafeEngine()
        return engine, SafeDB(builtins=engine.get_builtins())
    engine = DefaultEngine()
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


class _Refusal:
    """Stands in for a built-in."""

    def __init__(self, signature: str) -> None:
        self.signature = signature

    def __call__(self, *_: Any, database: SafeDB, location: Any = None, **__: Any) -> NoReturn:  # noqa: ANN401 - ProbLog's calls
        reason = f"{self.signature} is not allowed: it is not on the list of predicates that cannot reach files or code"
        database.refuse(reason, location)
