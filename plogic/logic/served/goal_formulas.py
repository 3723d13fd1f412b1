"""Goals as formulas over a program's choices, served in the child process: ground, not counted.

Vocabulary: a *key* is a number from 1, a node; its negative, the negation; 0 is true and null false, as in ProbLog's
formulas. A node is ``["and", [keys]]``, ``["or", [keys]]`` or a choice: ``["present", [["h1"]]]``, its functor and its
arguments' labels, or one of a rule's own, ``["choice", [alternative, number]]``, whose probabilities come beside.
"""

from collections.abc import Iterator, Sequence
from functools import lru_cache
from typing import Any

from problog.errors import ProbLogError
from problog.logic import AnnotatedDisjunction, Clause, Term

from plogic.logic.answers.answer import grouped
from plogic.logic.grounding.ground_program import Alternative, Ground
from plogic.logic.grounding.indexed_clauses import UnsupportedError
from plogic.logic.grounding.load import Request, by_problog, quickly, request_from, variables
from plogic.logic.safety.added import LAWFUL
from plogic.logic.safety.allowlist import SPECIAL_HEADS
from plogic.logic.safety.atoms import Names
from plogic.logic.safety.check import Source, heads, is_directive
from plogic.logic.safety.guarded_engine import told
from plogic.logic.safety.rows import SHORT_TEXT

OPEN = ("present", "chosen", "support", "footing")
"""The choices that are left open, so that their labels mean nothing; all others are a rule's own."""


def formulas(document: dict[str, Any]) -> dict[str, Any]:
    """The proofs' document, or ``{"outside": reason}``.

    ``{"nodes": [...], "choices": {alternative: [[number, probability], ...]}, "answers": [[[shown goal, key], ...] per
    goal], "single": [...], "given": [keys], "by": grounder}``; alternatives of two grounders are not compared.

    A goal is single where it has no variables, so that it has one answer, possible or not. A goal is outside where it,
    or a rule, speaks of the choices in ``document["outside"]``.
    """
    request = request_from(document)
    reason = _spoken(request, frozenset(document["outside"]))
    if reason:
        return {"outside": reason}
    try:
        ground, by = _ground(request)
    except ProbLogError as error:
        told(error, document["texts"])
    single = [not variables(goal) for _, goal in request.goals]
    return {
        **_reply(ground, grouped(request, ground, [[literal] for _, literal in ground.asked]), request.names),
        "by": by,
        "single": single,
    }


def _ground(request: Request) -> tuple[Ground, str]:
    """The ground program, and by whom: what our own grounder does not know is for ProbLog's engine."""
    try:
        return quickly(request), "us"
    except (UnsupportedError, RecursionError):
        return by_problog(request), "problog"


def _reply(ground: Ground, answers: list[list[tuple[str, Any]]], names: Names | None) -> dict[str, Any]:
    nodes: list[list[Any]] = [[]] * ground.size
    choices: dict[str, list[tuple[int, float]]] = {}
    for number, gate in ground.gates.items():
        nodes[number - 1] = [gate.kind, list(gate.children)]
    for alternative in ground.alternatives:
        left_open, name = _open(alternative), str(alternative.group)
        if left_open is None:
            choices[name] = list(zip(alternative.numbers, alternative.shares, strict=True))
        for variable, number in zip(alternative.variables, alternative.numbers, strict=True):
            nodes[variable - 1] = ["choice", [name, number]] if left_open is None else _choice(left_open, names)
    if [] in nodes:
        return {"outside": "a choice without a probability is used"}
    found = [[(shown, literal) for shown, (literal,) in goal] for goal in answers]
    return {"nodes": nodes, "choices": choices, "answers": found, "given": list(ground.observed)}


def _open(alternative: Alternative) -> Any | None:  # noqa: ANN401 - a term of ProbLog's
    name = alternative.names[0]()
    return name if str(name.functor) in OPEN else None


def _choice(name: Any, names: Names | None) -> list[Any]:  # noqa: ANN401 - a term of ProbLog's
    return [str(name.functor), [_label(argument, names) for argument in name.args]]


def _label(argument: Any, names: Names | None) -> list[str]:  # noqa: ANN401 - a term of ProbLog's
    """The labels of ``h1`` or of ``h1/f1``."""
    parts = argument.args if str(argument.functor).strip("'") == "/" and argument.arity == 2 else [argument]
    labels = {} if names is None else names.labels
    return [labels.get(str(part), str(part)) for part in parts]


def _spoken(request: Request, outside: frozenset[str]) -> str | None:
    """What the first body says that has a signature of ``outside`` in it; rules that nobody asks say nothing."""
    program, more = request.split()
    said = (
        ()
        if program is None
        else _said_by_short(program)
        if len(program.text) <= SHORT_TEXT
        else _said(program.statements)
    )
    reached = more if program is None else _reached(more, said)
    found = next((signature for signature in (*said, *_said(reached)) if signature in outside), None)
    return None if found is None else f"{found}, which only the program itself can tell, is spoken of"


def _reached(statements: Sequence[Any], said: Sequence[str]) -> list[Any]:
    """The statements that may be asked: goals, evidence, and those whose name the program or one of these writes."""
    names = {_name(signature) for signature in said}
    found: dict[int, Any] = {}
    while reached := {i: s for i, s in enumerate(statements) if i not in found and _asked(s, names)}:
        found |= reached
        parts = [
            part for statement in reached.values() for part in (*heads(statement), getattr(statement, "body", None))
        ]
        names |= {_name(signature) for part in parts for signature in _signatures(part)}
    return list(found.values())


def _asked(statement: Any, names: set[str]) -> bool:  # noqa: ANN401 - a term of ProbLog's
    """Whether one of these names calls it; who asks, observes, directs or constrains calls itself."""
    return is_directive(statement) or any(
        head.signature in SPECIAL_HEADS | LAWFUL
        or str(head.functor).startswith("'plogic ")
        or _name(head.signature) in names
        for head in heads(statement)
    )


def _name(signature: str) -> str:
    return signature.rpartition("/")[0].replace("'", "")


def _said(statements: Sequence[Any]) -> tuple[str, ...]:
    """Each signature that occurs in a body, in the order in which they do."""
    bodies = (s.body for s in statements if isinstance(s, (Clause, AnnotatedDisjunction)))
    return tuple(dict.fromkeys(signature for body in bodies for signature in _signatures(body)))


@lru_cache(maxsize=16)
def _said_by_short(program: Source) -> tuple[str, ...]:
    return _said(program.statements)


def _signatures(term: Any) -> Iterator[str]:  # noqa: ANN401 - a term of ProbLog's
    stack = [term]
    while stack:
        top = stack.pop()
        if isinstance(top, Term):
            yield str(top.signature).replace("'", "")
            stack += list(top.args)
