"""The process that runs programs: reads one request (JSON) from stdin, writes one reply (JSON) to stdout; never a traceback.

Started by ``plogic.engine``; its limits are set before anything of the request is looked at.
"""

from __future__ import annotations

import json
import os
import resource
import sys
from typing import Any


def main() -> None:
    """Serve one request; the limit of memory (bytes) is the only argument."""
    resource.setrlimit(resource.RLIMIT_AS, (int(sys.argv[1]), int(sys.argv[1])))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    answer_to = os.fdopen(os.dup(1), "w")
    os.dup2(2, 1)  # whatever a library prints is no part of the reply
    try:
        reply = _reply(json.load(sys.stdin))
    except MemoryError:
        reply = {"error": {"kind": "LimitError", "reason": "memory"}}
    with answer_to:
        json.dump(reply, answer_to)


def _reply(request: dict[str, Any]) -> dict[str, Any]:
    from plogic.errors import BeliefError, ProgramError
    from plogic.safety.serve import serve

    sys.setrecursionlimit(5000)
    try:
        return serve(request)
    except ProgramError as error:
        places = {"file": error.file, "line": error.line, "column": error.column}
        return {"error": {"kind": type(error).__name__, "reason": error.reason, **places}}
    except BeliefError as error:
        return {"error": {"kind": type(error).__name__, "reason": str(error)}}
    except RecursionError:
        return {"error": {"kind": "ProgramError", "reason": "the recursion does not end, or terms are nested too deeply"}}


if __name__ == "__main__":
    main()
