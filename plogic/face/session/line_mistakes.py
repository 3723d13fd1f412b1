"""What the user is told of a line that failed: its mistakes; of a mistake of ours, where to get its traceback."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING

from geometry.errors import PlogicError
from plogic.face.session.verbs import perform

if TYPE_CHECKING:
    from plogic.face.session.rows import Result
    from plogic.face.session.session import Session


def attempted(session: Session, line: str) -> tuple[Result | None, list[str]]:
    """What the line came to, and the mistakes in it, a sentence each: a line that fails never ends the session."""
    try:
        return perform(session, line), []
    except PlogicError as error:
        return None, str(error).splitlines()
    except Exception as error:  # a mistake of ours in one verb is no reason to lose the session
        if os.environ.get("PLOGIC_TRACEBACK"):
            raise
        what = " ".join(f"{type(error).__name__}: {error}".split())
        return None, [f"internal error: {what} (please report it with the traceback that PLOGIC_TRACEBACK=1 shows)"]


def shown(text: str) -> str:
    """A result's text, set off from the next by an empty line where it is more than a sentence."""
    return text.rstrip("\n") + "\n" + "\n" * ("\n" in text)
