"""The second layer: ProbLog's engine with every built-in overridden that is not on the allow-list, and a database that opens no file.

It holds even where the first layer is left out: whatever way a call is made (call/N, =.., a directive, a query, evidence), it ends here.
"""

from __future__ import annotations

import os
from typing import Any, NoReturn

import problog
from problog.clausedb import ClauseDB
from problog.engine import DefaultEngine
from problog.engine_builtin import _builtin_use_module, _builtin_use_module2, _builtin_use_module2_scope, _use_module
from problog.engine_stack import BooleanBuiltIn
from problog.errors import GroundingError
from problog.logic import Term

from plogic.safety.allowlist import GOALS, LIBRARIES

FOLDER = problog.library_paths[0]
"""ProbLog's own library; nothing outside it is ever opened."""
OPENED = {name: f"{name}.pl" for name in (*LIBRARIES, "builtin")} | {"lists.py": "lists.py"}
"""Library → its file: pure ones, and what they load themselves."""
LOADERS: dict[tuple[str, int], Any] = {
    ("use_module", 1): _builtin_use_module,
    ("use_module", 2): _builtin_use_module2,
    ("_use_module", 2): _use_module,
    ("_use_module", 3): _builtin_use_module2_scope,
}
"""Directives come here; the database decides what they open."""


class RefusedError(GroundingError):  # type: ignore[misc]
    """A built-in was called that is not on the allow-list, or a file was asked for."""


class SafeDB(ClauseDB):  # type: ignore[misc]
    """A clause database that knows ProbLog's pure libraries and no other file."""

    def extend(self) -> SafeDB:
        """As ClauseDB's (findall/3 works on such an extension), but safe like its parent."""
        return SafeDB(parent=self, builtins=self._ClauseDB__builtins)

    def resolve_filename(self, filename: Any) -> str:  # noqa: ANN401 - a term of ProbLog's
        """The path of a pure library; raises RefusedError for anything else."""
        if isinstance(filename, Term) and filename.functor == "library" and filename.arity == 1:
            name = OPENED.get(str(filename.args[0]).strip("'"))
            if name is not None:
                return os.path.join(FOLDER, name)  # noqa: PTH118 - ProbLog compares these paths as text
        if str(filename) in {os.path.join(FOLDER, name) for name in OPENED.values()}:  # noqa: PTH118
            return str(filename)
        raise RefusedError(f"loading {filename} is not allowed", self.lineno(getattr(filename, "location", None) or (0, None)))


class SafeEngine(DefaultEngine):  # type: ignore[misc]
    """ProbLog's engine, its built-ins on an allow-list."""

    def load_builtins(self) -> None:
        """Load all, then override each that is not allowed."""
        super().load_builtins()
        for signature in list(self.get_builtins()):
            name, _, arity = signature.rpartition("/")
            if (name, int(arity)) in LOADERS:
                self.add_builtin(name, int(arity), BooleanBuiltIn(LOADERS[name, int(arity)]))
            elif signature not in GOALS:
                self.add_builtin(name, int(arity), _Refusal(signature))

    def prepare(self, db: Any) -> Any:  # noqa: ANN401 - programs of ProbLog's
        """As ProbLog's, with a SafeDB."""
        result = SafeDB.createFrom(db, builtins=self.get_builtins())
        result.engine = self
        self._process_directives(result)
        return result


class _Refusal:
    """Stands in for a built-in."""

    def __init__(self, signature: str) -> None:
        self.signature = signature

    def __call__(self, *_: Any, database: Any = None, location: Any = None, **__: Any) -> NoReturn:  # noqa: ANN401 - ProbLog's calls
        place = database.lineno(location) if database is not None and location is not None else None
        raise RefusedError(f"{self.signature} is not allowed", place)
