"""A process that perceives frames.

From stdin its settings and then frames (JSON, one a line), to stdout what it says to them.

The first line out is ``{"kb": {"name", "digest"}}``, or ``{"error": ...}`` and the end; then one a frame: its status, a
blank, and its line. Before that it tells at most once a second what it is at: ``at search, 3 of 8 types``.
"""

import json
import os
import signal
import sys
from collections.abc import Callable

from plogic.base.alarm import TICK, alarmed
from plogic.base.children import begin
from plogic.base.clock import Stopwatch


def main() -> None:
    """Serve until stdin ends."""
    begin()
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the one who started us decides
    with os.fdopen(os.dup(1), "wb") as out:
        os.dup2(2, 1)  # whatever a library prints is no line
        from geometry.errors import PlogicError
        from plogic.run.batch.frames import Frame, Settings
        from plogic.run.batch.pool import AT
        from plogic.run.batch.work import Worker

        settings = Settings.of(json.loads(sys.stdin.buffer.readline()))
        try:
            worker = Worker(settings)
        except PlogicError as error:
            out.write(json.dumps({"error": str(error)}).encode() + b"\n")
            return
        out.write(json.dumps({"kb": worker.lines.kb}).encode() + b"\n")
        out.flush()
        for row in sys.stdin.buffer:
            clock = Stopwatch()
            tell = teller(clock, lambda text: os.write(out.fileno(), f"{AT} {text}\n".encode()))
            with alarmed(tell, TICK, TICK):
                status, line = worker(Frame(*json.loads(row)), clock)
            out.write(status.encode() + b" " + line)
            out.flush()


def teller(clock: Stopwatch, write: Callable[[str], object]) -> Callable[[], None]:
    """What writes the stage that a clock is at, where it is another than was written last."""
    last = ""

    def tell() -> None:
        nonlocal last
        if clock.here != last:
            last = clock.here
            write(last)

    return tell


if __name__ == "__main__":
    main()
