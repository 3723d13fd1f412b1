"""The process that runs programs: reads one request (JSON) from stdin, writes replies (JSON, one a line) to stdout.

Never a traceback.

The last line is the reply; lines before it are what was known by then, where the request asks for that (``anytime``).
Started by ``plogic.logic.served.engine``; its limits are set before anything of the request is looked at.
"""

from __future__ import annotations

import json
import os
import sys
from typing import TYPE_CHECKING, Any

from plogic.base.children import begin

if TYPE_CHECKING:
    from collections.abc import Callable


def main() -> None:
    """Serve one request."""
    begin()
    answer_to = os.fdopen(os.dup(1), "w")
    os.dup2(2, 1)  # whatever a library prints is no part of the reply

    def tell(reply: dict[str, Any]) -> None:
        answer_to.write(json.dumps(reply) + "\n")
        answer_to.flush()

    with answer_to:
        try:
            reply = reply_to(json.load(sys.stdin), tell)
        except MemoryError:
            reply = {"error": {"kind": "LimitError", "reason": "memory"}}
        tell(reply)


def reply_to(request: dict[str, Any], tell: Callable[[dict[str, Any]], None] | None = None) -> dict[str, Any]:
    """The reply to one request, or the error that it came to; ``tell`` gets what is known on the way."""
    from plogic.base.errors import BeliefError, ProgramError
    from plogic.logic.served.serve import serve

    sys.setrecursionlimit(5000)
    try:
        return serve(request, tell)
    except ProgramError as error:
        places = {"file": error.file, "line": error.line, "column": error.column}
        return {"error": {"kind": type(error).__name__, "reason": error.reason, **places}}
    except BeliefError as error:
        return {"error": {"kind": type(error).__name__, "reason": str(error)}}
    except RecursionError:
        reason = "the recursion does not end, or terms are nested too deeply"
        return {"error": {"kind": "ProgramError", "reason": reason, "file": request["texts"][0]["file"]}}
    except MemoryError:
        raise
    except Exception as error:  # noqa: BLE001 - whatever a program makes of ProbLog must not look like a limit
        what = " ".join(f"{type(error).__name__}: {error}".split())[:300]
        return {
            "error": {
                "kind": "ProgramError",
                "reason": f"the program cannot be run ({what})",
                "file": request["texts"][0]["file"],
            }
        }


if __name__ == "__main__":
    main()
