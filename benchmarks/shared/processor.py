"""The clock of benchmarks that run beside other work.

Seconds of the processor, which waiting for others does not lengthen.
"""

from __future__ import annotations

import os
import resource
from contextlib import suppress
from pathlib import Path
from time import process_time


def processor_seconds() -> float:
    """What this process and the children that it has waited for have used, all threads together.

    On an idle machine, about wall time.
    """
    children = resource.getrusage(resource.RUSAGE_CHILDREN)
    return process_time() + children.ru_utime + children.ru_stime


def group_seconds(group: int) -> float:
    """What the living processes of a group have used, with the children that they have waited for.

    0 where the system does not tell.
    """
    ticks = 0
    for stat in Path("/proc").glob("[0-9]*/stat"):
        with suppress(OSError):
            fields = stat.read_text().rpartition(")")[2].split()  # after the name: state, parent, group, ...
            ticks += sum(map(int, fields[11:15])) if int(fields[2]) == group else 0
    return ticks / os.sysconf("SC_CLK_TCK")
