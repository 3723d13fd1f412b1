"""One request: texts, goals and evidence in; answers out.

Parsed, held to the allow-list, grounded by the safe engine, counted by ProbLog.
"""

from __future__ import annotations

from typing import Any

from problog.ddnnf_formula import DDNNF
from problog.errors import CompilationError, ProbLogError
from problog.logic import And, Clause, Constant, Not, Or, Term, Var
from problog.sdd_formula import SDD

from plogic.names import Names
from plogic.program.mapping import mapped, shown
from plogic.safety.check import check_goal, check_source, parse
from plogic.safety.engine import SafeDB, SafeEngine
from plogic.safety.mistakes import told


def serve(request: dict[str, Any]) -> dict[str, Any]:
    """``{"texts": [{"text", "file"}], "goals": [...], "given": [...], "names": {label: atom} | null}`` → ``{"answers": [[goal, p], ...]}``.

    One list of answers per goal; without goals, one list for the program's own query/1.
    """
    names = _names(request["names"])
    if request.get("task") == "prove":
        from plogic.safety.prove import prove

        return prove(request, names)
    engine = SafeEngine()
    db = SafeDB(builtins=engine.get_builtins())
    try:
        known = _load(db, request["texts"], names)
        goals = [
            _goal(db, text, f"goal {i}" if len(request["goals"]) > 1 else "goal", names, known, i)
            for i, text in enumerate(request["goals"])
        ]
        for i, text in enumerate(request["given"]):
            _observe(db, text, names, known, i)
        results = _evaluate(engine, db, [head for head, _ in goals] or None)
    except ProbLogError as error:
        told(error, [item["file"] for item in request["texts"]])
    if not goals:
        return {"answers": [[[shown(term, names), p] for term, p in results.items()]]}
    return {"answers": [_answers(results, head, goal, names) for head, goal in goals]}


def _names(atoms: dict[str, str] | None) -> Names | None:
    return None if atoms is None else Names(atoms, {atom: label for label, atom in atoms.items()})


def _load(db: SafeDB, texts: list[dict[str, str]], names: Names | None) -> frozenset[str]:
    """Put every text into the database; the signatures that may be called.

    Texts after the first may not add to the first one's predicates.
    """
    known: frozenset[str] = frozenset()
    for i, item in enumerate(texts):
        identifier = i and len(db.source_files)
        source = parse(item["text"], item["file"], identifier)
        known |= check_source(source, known=known, protected=known)
        _remember(db, identifier, source.program.line_info[0], item["file"])
        for statement in source.statements:
            db.add_statement(mapped(statement, names) if names is not None and i else statement)
    return known


def _remember(db: SafeDB, identifier: int, lines: list[int], file: str) -> None:
    """Where each line of a text begins, so that ProbLog can say where something stands."""
    if identifier:
        db.source_files.append(file)
        db.source_parent.append(None)
        db.line_info.append(lines)
    else:
        db.source_files[0], db.line_info[0] = file, lines


def _goal(db: SafeDB, text: str, file: str, names: Names | None, known: frozenset[str], number: int) -> tuple[Term, Any]:
    """Add ``head(Variables) :- goal``; the head to ask for, and the goal."""
    source = parse(text.rstrip().removesuffix(".") + "\n.", file, identifier=0)
    goal = check_goal(source, known)
    goal = goal if names is None else mapped(goal, names)
    head = Term(f"'plogic goal {number}'", *[Var(name) for name in _variables(goal)])
    db.add_statement(Clause(head, goal))
    return head.with_args(*[None] * head.arity), goal


def _observe(db: SafeDB, text: str, names: Names | None, known: frozenset[str], number: int) -> None:
    """Evidence: there is a substitution for which the goal holds."""
    source = parse(text.rstrip().removesuffix(".") + "\n.", "given", identifier=0)
    goal = check_goal(source, known)
    head = Term(f"'plogic given {number}'")
    db.add_statement(Clause(head, goal if names is None else mapped(goal, names)))
    db.add_statement(Term("evidence", head))


def _variables(goal: Any) -> list[str]:  # noqa: ANN401 - terms of ProbLog's
    """The named variables outside negations, in the order in which they appear."""
    if isinstance(goal, Var):
        return [] if goal.name.startswith("_") else [goal.name]
    if isinstance(goal, (Not, Constant)) or not isinstance(goal, Term) or goal.signature in ("not/1", "forall/2"):
        return []
    return list(dict.fromkeys(name for argument in goal.args for name in _variables(argument)))


def _evaluate(engine: SafeEngine, db: SafeDB, queries: list[Term] | None) -> dict[Term, float]:
    ground = engine.ground_all(db, queries=queries)
    try:
        results: dict[Term, float] = DDNNF.create_from(ground).evaluate()
    except CompilationError:
        results = SDD.create_from(ground).evaluate()
    return results


def _answers(results: dict[Term, float], head: Term, goal: Any, names: Names | None) -> list[list[Any]]:  # noqa: ANN401
    """Each substitution of the goal with its probability; a ground goal has exactly one answer."""
    variables = _variables(goal)
    found = [(term, p) for term, p in results.items() if term.functor == head.functor]
    if variables:
        found = [(term, p) for term, p in found if p > 0 and not any(a is None or isinstance(a, int) for a in term.args)]
    return [[shown(_bound(goal, dict(zip(variables, term.args, strict=True))), names), p] for term, p in found]


def _bound(goal: Any, values: dict[str, Any]) -> Any:  # noqa: ANN401
    if isinstance(goal, Var):
        return values.get(goal.name, goal)
    if isinstance(goal, Constant) or not isinstance(goal, Term):
        return goal
    arguments = [_bound(argument, values) for argument in goal.args]
    if isinstance(goal, (And, Or)):
        return type(goal)(*arguments)
    return Not(goal.functor, arguments[0]) if isinstance(goal, Not) else goal.with_args(*arguments)
