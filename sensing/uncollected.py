"""Many records made at once, without the garbage collector.

It would go through all that the process holds again and again.
"""

import gc
from collections.abc import Iterator
from contextlib import contextmanager


@contextmanager
def uncollected() -> Iterator[None]:
    """No garbage collection inside.

    For thousands of records that do not refer to each other in circles, so there is nothing to collect.
    """
    active = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if active:
            gc.enable()
