"""The lines of a saved session, done again."""

from __future__ import annotations

from typing import TYPE_CHECKING

from geometry.errors import PlogicError
from plogic.base.errors import InputError
from plogic.face.session.results import Replayed
from plogic.face.session.verbs import perform, verb_of

if TYPE_CHECKING:
    from plogic.face.session.session import Session


def replayed(session: Session, file: str, text: str) -> Replayed:
    """What each line comes to; raises InputError with file and line at the first that fails."""
    results = []
    for number, line in enumerate(text.splitlines(), 1):
        try:
            if verb_of(line)[0] == "load":
                raise InputError("a saved session loads no other")
            result = perform(session, line)
        except PlogicError as error:
            raise InputError(f"{file}:{number}: {error}") from None
        if result is not None:
            results.append(result)
    return Replayed(tuple(results))
