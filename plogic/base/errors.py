"""What can go wrong with what is believed.

::

    geometry.errors.PlogicError
    └── BeliefError                       anything of this package
        ├── SituationError                a situation that contradicts itself (unknown id, duplicate id, not a number)
        │   ├── TooManyHypothesesError    more hypotheses occlude each other in a cycle than can be decided jointly
        │   └── WidthError                exact sums would need larger tables, or more of them, than is sensible; states
            the width
        ├── InputError                    a command's input that cannot be used; names the file
        ├── OutputError                   standard output cannot be written
        ├── InterpretationError           a file that is no complete interpretation/1
        ├── InconsistentError             no world satisfies the constraints or the evidence
        ├── ProgramError                  program text, rules or a goal that cannot be used; knows file, line and column
        │   ├── UnsafeProgramError        uses a predicate that is not on the allow-list
        │   ├── UnknownPredicateError     calls a predicate that has no clauses
        │   ├── NegativeCycleError        a negation that depends on itself
        │   ├── OutsideError              a goal that speaks of choices which a scene's graph has summed out
        │   └── NonGroundError            a probabilistic clause or a goal that keeps a variable
        └── LimitError                    the inference ran out of its time or memory

ReaderGoneError                       nobody reads standard output any more: nobody's mistake, and told to nobody
"""

from geometry.errors import PlogicError, told


class BeliefError(PlogicError):
    """Anything of this package."""


class _ManyMistakesError(BeliefError):
    """Several ``mistakes``, a line each."""

    def __init__(self, *mistakes: str) -> None:
        super().__init__(told(mistakes))
        self.mistakes = mistakes


class SituationError(_ManyMistakesError):
    """A situation contradicts itself.

    Each of ``mistakes`` names the hypothesis or appearance, the rule and the value.
    """


class TooManyHypothesesError(SituationError):
    """More hypotheses occlude each other in a cycle than can be decided jointly."""


class WidthError(SituationError):
    """Exact sums would need larger tables, or more of them, than is sensible: the message states the width in bits."""


class InputError(BeliefError):
    """A command's input cannot be used: the message names the file, what is wrong and what would be right."""


class OutputError(BeliefError):
    """Standard output cannot be written: the message says why."""


class ReaderGoneError(Exception):
    """Nobody reads standard output any more; no ``OSError``, as click makes its own of a broken pipe."""


class InterpretationError(_ManyMistakesError):
    """A file is no complete ``interpretation/1``: each of ``mistakes`` names the file, the key and the value."""


class InconsistentError(BeliefError):
    """No world satisfies the constraints or the evidence: its probability is 0."""


class ProgramError(BeliefError):
    """Program text, rules or a goal that cannot be used.

    ``line`` and ``column`` count from 1; None where ProbLog does not tell.
    """

    def __init__(
        self, reason: str, *, file: str = "program", line: int | None = None, column: int | None = None
    ) -> None:
        self.reason, self.file, self.line, self.column = reason, file, line, column
        place = file if line is None else f"{file}:{line}" if column is None else f"{file}:{line}:{column}"
        super().__init__(f"{place}: {reason}")


class UnsafeProgramError(ProgramError):
    """A predicate that is not on the allow-list: it could read files or run code."""


class UnknownPredicateError(ProgramError):
    """A call to a predicate without clauses."""


class NegativeCycleError(ProgramError):
    """A negation that depends on itself: such a program has no single meaning."""


class OutsideError(ProgramError):
    """A goal, or a rule, that speaks of what a scene's graph does not have: hits, picks, proofs, the program itself.

    Only the program has them.
    """


class NonGroundError(ProgramError):
    """A probabilistic clause, or a goal, that keeps a variable after grounding."""


class LimitError(BeliefError):
    """The inference ran out of its wall time or memory; the message states the limit."""
