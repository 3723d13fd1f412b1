"""Facts that were meant to ask or to observe, and do neither: ``evidnce(win)``, ``evidence(win, tru)``."""

from collections.abc import Iterator
from typing import Any

from problog.logic import AnnotatedDisjunction, Clause, Constant, Not, Term, Var

from plogic.base.errors import ProgramError
from plogic.logic.safety.check import Source, glanced, heads
from plogic.logic.safety.closest import meant
from plogic.logic.safety.guarded_engine import goals_under


def unasked(text: str, file: str) -> list[str]:
    """A line, with its place, on each such fact.

    A text that cannot be read, or not quickly, is told of elsewhere.
    """
    source = glanced(text, file)
    return [] if source is None else [str(ProgramError(why, **source.place(fact))) for why, fact in _unasked(source)]


def _unasked(source: Source) -> Iterator[tuple[str, Any]]:
    found = [head for statement in source.statements for head in heads(statement)]
    facts = {id(s) for s in source.statements if not isinstance(s, (Clause, AnnotatedDisjunction))}
    defined = {head.signature for head in found}
    bodies = (getattr(statement, "body", None) for statement in source.statements)
    called = {goal.signature for body in bodies for goal, _, _ in goals_under(body, frozenset(), None)}
    for head in found:
        if head.signature == "evidence/2" and str(head.args[1]) not in ("true", "false"):
            if not isinstance(head.args[1], Var) or id(head) in facts:
                yield f"{head} observes nothing: its second argument is true or false", head
        elif head.signature not in called and head.arity in (1, 2) and (right := meant(str(head.functor))):
            goal = head.args[0].args[0] if isinstance(head.args[0], Not) else head.args[0]
            if isinstance(goal, Term) and not isinstance(goal, (Var, Constant)) and goal.signature in defined:
                does = "asks" if right == "query" else "observes"
                yield f"{head} is a fact that {does} nothing; the closest name that does is {right}", head
