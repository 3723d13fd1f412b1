"""The process of a session: answers one request a line until its input ends, so that ProbLog is imported once.

As ``plogic.logic.served.program_child``, whose limits and replies it has; started by
``plogic.logic.served.staying_process``.
"""

from __future__ import annotations

import json
import os
import sys
from typing import Any

from plogic.base.children import begin
from plogic.logic.served.program_child import reply_to


def main() -> None:
    """Serve requests."""
    begin()
    answer_to = os.fdopen(os.dup(1), "w")
    os.dup2(2, 1)  # whatever a library prints is no part of a reply
    with answer_to:
        for line in sys.stdin:
            answer_to.write(json.dumps(_reply(line)) + "\n")
            answer_to.flush()


def _reply(line: str) -> dict[str, Any]:
    try:
        return reply_to(json.loads(line))
    except MemoryError:
        return {"error": {"kind": "LimitError", "reason": "memory"}}


if __name__ == "__main__":
    main()
