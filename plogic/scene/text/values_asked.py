"""What a predicate of the vocabulary must be given, told instead of the place in generated text where it failed."""

from collections.abc import Iterator
from contextlib import contextmanager

from plogic.base.errors import ProgramError
from plogic.logic.safety.author import load_problog
from plogic.logic.served.engine import Text


@contextmanager
def told_in_words(text: Text) -> Iterator[None]:
    """Within it, where ``text`` is run, an error in a clause of the vocabulary names the value that this lacks."""
    try:
        yield
    except ProgramError as error:
        lines = text.text.splitlines()
        if error.file != Text.file or text.file != Text.file or error.line is None or error.line > len(lines):
            raise
        from plogic.facts.vocabulary import VOCABULARY

        clause = lines[error.line - 1]
        entry = next((entry for entry in VOCABULARY if clause in entry.clause.splitlines()), None)
        load_problog()
        from plogic.logic.safety.open_negations import never_bound

        lacks = [] if entry is None else never_bound(clause)
        if entry is None or not lacks:
            raise
        what = f"{entry.usage} asks for a value of {' and '.join(lacks)}, and finds none: {entry.meaning}"
        raise type(error)(what, file="goal") from None
