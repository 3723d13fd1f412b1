"""The process that runs programs.

Reads requests from stdin, writes replies to stdout (JSON, one a line), never a traceback.

The last line that a request gives is its reply; lines before it are what was known by then, where the request asks for
that (``anytime``). Started by ``plogic.logic.served.engine``, for one request or for a session, so that ProbLog is
imported once; its limits are set before anything of a request is looked at.
"""

import json
import os
import sys
from collections.abc import Callable
from typing import Any

from plogic.base.children import begin

Tell = Callable[[dict[str, Any]], None]


def main() -> None:
    """Serve requests until the input ends."""
    begin()
    answer_to = os.fdopen(os.dup(1), "w")
    os.dup2(2, 1)  # whatever a library prints is no part of a reply

    def tell(reply: dict[str, Any]) -> None:
        answer_to.write(json.dumps(reply) + "\n")
        answer_to.flush()

    with answer_to:
        for line in sys.stdin:
            try:
                reply = reply_to(json.loads(line), tell)
            except MemoryError:
                reply = {"error": {"kind": "LimitError", "reason": "memory"}}
            tell(reply)


def reply_to(request: dict[str, Any], tell: Tell | None = None) -> dict[str, Any]:
    """The reply to one request, or the error that it came to; ``tell`` gets what is known on the way.

    One that is to be ``plain`` is answered without PySDD.
    """
    from plogic.base.errors import BeliefError, InconsistentError, ProgramError

    sys.setrecursionlimit(5000)
    if request.get("plain"):
        sys.modules["pysdd"] = None  # type: ignore[assignment]  # as where it is not installed
    file = request["texts"][0]["file"]
    try:
        return serve(request, tell)
    except ProgramError as error:
        places = {"file": error.file, "line": error.line, "column": error.column}
        return {"error": {"kind": type(error).__name__, "reason": error.reason, **places}}
    except InconsistentError as error:
        from plogic.logic.answers.impossible import blamed

        more = blamed(request)
        return {"error": {"kind": "InconsistentError", "reason": f"{error}; {more}" if more else str(error)}}
    except BeliefError as error:
        return {"error": {"kind": type(error).__name__, "reason": str(error)}}
    except MemoryError:
        raise
    except RecursionError:
        from plogic.logic.safety.recursion import endless

        suspect = endless(request["texts"], request.get("goals", ()), grown=False)
        reason = "the recursion does not end, or terms are nested too deeply" + (suspect and f"; {suspect}")
    except Exception as error:  # noqa: BLE001 - whatever a program makes of ProbLog must not look like a limit
        what = " ".join(f"{type(error).__name__}: {error}".split())[:300]
        long = isinstance(error, ValueError) and "integer string conversion" in what
        reason = f"the program cannot be run ({'a number gets more digits than can be written' if long else what})"
    return {"error": {"kind": "ProgramError", "reason": reason, "file": file}}


def serve(request: dict[str, Any], tell: Tell | None = None) -> dict[str, Any]:
    """The reply to a request: ``{"texts": [{"text", "file"}], "goals": [...], "given": [...], "names": {label.

    Atom} | null}`` and a ``task``.

    Without a task: ``{"answers": [[[goal, p], ...], ...]}``, one list of answers per goal; without goals, one list for
    the program's own query/1. With ``anytime``, ``tell`` gets replies with intervals, ``[goal, low, high]``, before the
    exact one.
    """
    match request.get("task"):
        case "outline":
            from plogic.logic.served.outline_reader import outline

            return outline(request)
        case "worlds":
            from plogic.logic.answers.state_ranking import ranked

            return ranked(request, tell)
        case "prove" | "names" as task:
            from plogic.logic.served.prove import notes, prove

            return prove(request) if task == "prove" else notes(request)
        case "formula":
            from plogic.logic.served.goal_formulas import formulas

            return formulas(request)
    if request.get("anytime") and tell:
        from plogic.logic.answers.intervals import answers_by

        return answers_by(request, tell)
    from plogic.logic.answers.answer import answers_to

    return {"answers": answers_to(request)}


if __name__ == "__main__":
    main()
