"""Stock ProbLog on program texts, each line of which is parsed once: most lines of our texts are always the same.

The weight of the evidence is that of the whole program, and is computed once, not with each query again.
"""

from __future__ import annotations

from functools import cache


def evaluated(text):
    """Query → probability, by ProbLog's own Python interface."""
    from problog import get_evaluatable

    formula = get_evaluatable("ddnnf").create_from(program(text))
    evaluator = formula.get_evaluator()
    formula.get_evaluator = lambda *_, **__: evaluator
    evidence = evaluator._get_z()
    evaluator._get_z = lambda: evidence
    return formula.evaluate()


def program(text):
    """The program of a text, as ``PrologString`` reads it."""
    from problog.errors import ProbLogError
    from problog.program import LogicProgram, PrologString

    class Statements(LogicProgram):
        def __iter__(self):
            return iter(found)

    try:
        found = [statement for line in text.splitlines() for statement in _statements(line)]
    except ProbLogError:  # a statement of several lines
        return PrologString(text)
    return Statements()


@cache
def _statements(line):
    from problog.program import PrologString

    return tuple(PrologString(line))
