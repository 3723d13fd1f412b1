"""From texts, goals and evidence to the ground program: parsed, held to the allow-list, grounded.

Plain programs are grounded by ``grounder``; what it does not know, and every program that is trusted, by ProbLog's
engine behind the allow-list. Both give the same probabilities; ProbLog's engine also tells what is wrong.
"""

import contextlib
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from operator import is_
from pathlib import Path
from typing import Any

from problog.errors import ProbLogError
from problog.logic import Clause, Constant, Not, Term, Var

from plogic.base.errors import NegativeCycleError, NonGroundError, ProgramError, UnknownPredicateError
from plogic.logic.grounding.ground_program import Ground, Literal, NamedFormula, ground_from, ground_of, negated
from plogic.logic.grounding.grounder import Grounder
from plogic.logic.grounding.indexed_clauses import Reader, UnsupportedError
from plogic.logic.safety.added import LAWFUL, check_added, lawful
from plogic.logic.safety.allowlist import SPECIAL_HEADS
from plogic.logic.safety.atoms import Names
from plogic.logic.safety.check import Source, check_goal, check_source, heads, parse, parse_quickly
from plogic.logic.safety.guarded_engine import engine_for, told
from plogic.logic.safety.mapping import mapped, shown
from plogic.logic.safety.rows import SHORT_TEXT

MENDED = (NonGroundError, NegativeCycleError, UnknownPredicateError)
"""Mistakes that may stand where the evidence rules a clause out."""
EVIDENCE = frozenset({"evidence/1", "evidence/2"})
COLLECTING = frozenset({"findall/3", "all/3", "all_or_none/3"})
"""What only their first two arguments name is theirs alone."""


@dataclass(frozen=True)
class Request:
    """What is asked of a program.

    The parsed texts, goals with the heads that stand for them, evidence as heads that must hold.

    ``sources`` and ``statements``: all texts and all clauses, those of goals and evidence last.
    """

    sources: tuple[Source, ...]
    statements: tuple[Any, ...]
    goals: tuple[tuple[Term, Any], ...]
    names: Names | None
    trust: bool
    folder: str

    def split(self) -> tuple[Source | None, tuple[Any, ...]]:
        """The program and the statements that come after its own; None and all, where some of its own are left out."""
        own = len(self.sources[0].statements)
        if own > len(self.statements) or not all(map(is_, self.sources[0].statements, self.statements)):
            return None, self.statements
        return self.sources[0], self.statements[own:]


def request_from(document: dict[str, Any]) -> Request:
    """The request that the child process got, parsed and held to the allow-list (unless trusted).

    Raises ProgramError.
    """
    atoms = document.get("names")
    names = None if atoms is None else Names.of(atoms)
    trust = bool(document.get("trust", False))
    sources, statements, known = read(document["texts"], names, trust=trust)
    texts = document.get("goals", [])
    goals = []
    for i, text in enumerate(texts):
        sources.append(parsed(text, f"goal {i}" if len(texts) > 1 else "goal", len(sources) + LIBRARY_FILES))
        goal = goal_in(sources[-1], names, known, trust=trust)
        head = Term(f"'plogic goal {i}'", *[Var(name) for name in variables(goal)])
        statements.append(Clause(head, goal))
        goals.append((head.with_args(*[None] * head.arity), goal))
    for i, text in enumerate(document.get("given", [])):
        sources.append(parsed(text, "given", len(sources) + LIBRARY_FILES))
        head = Term(f"'plogic given {i}'")
        statements += [Clause(head, goal_in(sources[-1], names, known, trust=trust)), Term("evidence", head)]
    return Request(tuple(sources), tuple(statements), tuple(goals), names, trust, document.get("folder", "."))


def with_something_asked(request: Request) -> Request:
    """A program that asks nothing is asked for every atom to which it gives a probability."""
    found = [head for statement in request.statements for head in heads(statement)]
    if request.goals or any(head.signature == "query/1" for head in found):
        return request
    labelled = dict.fromkeys(head.with_probability(None) for head in found if head.probability is not None)
    return replace(request, statements=(*request.statements, *(Term("query", head) for head in labelled)))


def read(
    texts: Sequence[dict[str, str]], names: Names | None, *, trust: bool, marked: bool = True
) -> tuple[list[Source], list[Any], frozenset[str]]:
    """The sources, their statements and the signatures that they define, none where they are trusted.

    Texts after the first are added to it (``plogic.logic.safety.added``).

    ``marked``: places say in which text they are.
    """
    known: frozenset[str] = frozenset()
    sources: list[Source] = []
    statements: list[Any] = []
    for i, item in enumerate(texts):
        number = i + LIBRARY_FILES if marked and i else 0
        source = parse(item["text"], item["file"], number)
        text = lawful(source, known) if i else source.text
        if not trust:
            known |= check_added(source, known) if i else check_source(source)
        if text != source.text:
            source, known = parse(text, item["file"], number), known | LAWFUL
        sources.append(source)
        statements += [mapped(s, names) if names is not None and i else s for s in source.statements]
    return sources, statements, known


LIBRARY_FILES = 1
"""A database's second file is ProbLog's own library; texts after the first come after it."""


def parsed(text: str, file: str, identifier: int = 0) -> Source:
    """A goal's text; ``identifier`` marks its places.

    Raises ProgramError.
    """
    if not text.strip():
        raise ProgramError("is empty; a goal is one term, like present(h1)", file=file)
    return parse_quickly(text.rstrip().removesuffix(".") + "\n.", file, identifier)


def goal_in(source: Source, names: Names | None, known: frozenset[str], *, trust: bool) -> Any:  # noqa: ANN401 - a term of ProbLog's
    """The goal that a text consists of, with atoms for labels.

    Raises ProgramError where it calls what is not ``known``, unless it is trusted.
    """
    goal = source.statements[0] if trust and len(source.statements) == 1 else check_goal(source, known)
    return goal if names is None else mapped(goal, names)


def goal_shown(text: str, names: Names | None) -> str | None:
    """A goal as its answers show it; None where it has variables, so that it may have any number of answers.

    Raises ProgramError.
    """
    goal = goal_in(parsed(text, "goal"), names, frozenset(), trust=True)
    return None if variables(goal) else shown(goal, names)


def line_of(request: Request, term: Any) -> int | None:  # noqa: ANN401 - a term of ProbLog's
    """The line of a term in its text, from 1; None where ProbLog does not tell."""
    location = getattr(term, "location", None)
    if not isinstance(location, tuple) or location[1] is None:
        return None
    source = request.sources[location[0] and location[0] - LIBRARY_FILES]
    return int(source.program.lineno(location[1])[1])


def variables(goal: Any) -> list[str]:  # noqa: ANN401 - terms of ProbLog's
    """The named variables outside negations, and outside of what is collected, in the order in which they appear."""
    if isinstance(goal, Var):
        return [] if goal.name.startswith("_") else [goal.name]
    if isinstance(goal, (Not, Constant)) or not isinstance(goal, Term) or goal.signature in ("not/1", "forall/2"):
        return []
    if goal.signature in COLLECTING:
        return variables(goal.args[2])
    return list(dict.fromkeys(name for argument in goal.args for name in variables(argument)))


def ground(request: Request, *, cyclic: bool = False) -> Ground:
    """The ground program; its cycles are broken, unless ``cyclic``.

    Raises ProgramError, and InconsistentError where evidence is a constant that contradicts it.
    """
    if not request.trust:
        with contextlib.suppress(UnsupportedError, RecursionError, ProbLogError):
            return quickly(request)
    return by_problog(request, cyclic=cyclic)


def quickly(request: Request) -> Ground:
    """By our own grounder; raises UnsupportedError where only ProbLog's will do, before anything is told."""
    program, more = request.split()
    short = program is not None and len(program.text) <= SHORT_TEXT
    told_apart = _told_apart_before(program) if short else _told_apart(program)
    told_apart = told_apart.and_those(more)
    grounder = Grounder(told_apart.reader)
    asked = [head for head, _ in request.goals] or told_apart.asked
    wanted = [pair for goal in asked for pair in grounder.instances(goal, or_none=bool(request.goals))]
    seen = [pair for goal, holds in told_apart.observed for pair in _seen(grounder, goal, holds=holds)]
    found = ground_from(grounder.node, wanted, seen)
    if found is None:
        raise UnsupportedError
    return found


@dataclass(frozen=True)
class _ToldApart:
    """Statements: rules, what they ask, and what they observe, each with whether it holds. Nothing is added to it."""

    reader: Reader
    asked: list[Any]
    observed: list[tuple[Any, bool]]

    def and_those(self, statements: Iterable[Any]) -> "_ToldApart":
        """These and some more. Raises UnsupportedError."""
        reader, asked, observed = Reader(self.reader), [*self.asked], [*self.observed]
        for statement in statements:
            signature = getattr(statement, "signature", "")
            if signature == "query/1" and type(statement) is Term and statement.probability is None:
                asked.append(statement.args[0])
            elif signature in EVIDENCE and type(statement) is Term and statement.probability is None:
                observed += _evidence(statement)
            elif SPECIAL_HEADS & {head.signature for head in heads(statement)}:
                raise UnsupportedError
            else:
                reader.add(statement)
        return _ToldApart(reader, asked, observed)


def _told_apart(program: Source | None) -> _ToldApart:
    return _ToldApart(Reader(), [], []).and_those(() if program is None else program.statements)


_told_apart_before = lru_cache(maxsize=16)(_told_apart)
"""The next question about a program goes on from there; a long one is not kept (``plogic.logic.safety.check``)."""


def _evidence(statement: Any) -> list[tuple[Any, bool]]:  # noqa: ANN401 - a term of ProbLog's
    goal, sign = statement.args[0], True
    if len(statement.args) == 2:
        value = str(statement.args[1])
        if value not in ("true", "false"):
            raise UnsupportedError
        sign = value == "true"
    elif isinstance(goal, Not):
        goal, sign = goal.args[0], False
    return [(goal, sign)]


def _seen(grounder: Grounder, goal: Any, *, holds: bool) -> list[tuple[Any, Literal]]:  # noqa: ANN401 - a term of ProbLog's
    found = grounder.instances(goal, or_none=True)
    if holds:
        return found or [(goal, None)]
    return [(name, negated(literal)) for name, literal in found]


def by_problog(request: Request, *, cyclic: bool = False) -> Ground:
    """By ProbLog's engine; its errors become ours, with the place that it tells.

    Where it fails, once more with the evidence propagated while it grounds, as ProbLog's command line does: what the
    evidence rules out is then not grounded, and cannot fail. The probabilities are the same.
    """
    try:
        return _by_problog(request, propagate=False, cyclic=cyclic)
    except MENDED as error:
        with contextlib.suppress(Exception):
            return _by_problog(request, propagate=True, cyclic=cyclic)
        raise error from None


def _by_problog(request: Request, *, propagate: bool, cyclic: bool) -> Ground:
    engine, db = engine_for(trust=request.trust, folder=request.folder)
    for i, source in enumerate(request.sources):
        lines = source.program.line_info[0]
        if i == 0:
            db.source_files[0] = str(Path(request.folder, Path(source.file).name)) if request.trust else source.file
            db.line_info[0] = lines
        else:
            db.source_files.append(source.file)
            db.source_parent.append(None)
            db.line_info.append(lines)
    try:
        db.add_all(request.statements)
        formula = engine.ground_all(
            db, NamedFormula(db), queries=[head for head, _ in request.goals] or None, propagate_evidence=propagate
        )
        return ground_of(formula, cyclic=cyclic)
    except Exception as error:  # noqa: BLE001 - ProbLog raises what Python raises, too
        told(error, [{"text": source.text, "file": source.file} for source in request.sources], db)
