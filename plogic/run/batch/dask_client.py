"""A connection to the scheduler of a Dask cluster: who does not answer, or has no workers, is waited for so long and no longer."""

from __future__ import annotations

import asyncio
import threading
from contextlib import suppress
from importlib import import_module
from time import monotonic, sleep
from typing import TYPE_CHECKING, Any

from plogic.base.errors import InputError

if TYPE_CHECKING:
    from collections.abc import Callable

CONNECTING = 10.0
"""Seconds that a scheduler has to answer in, whatever it is asked."""
WAITING = 60.0
"""Seconds that a scheduler may be without workers."""
LOOK = 2.0
"""Seconds between two looks for workers."""
CLOSING = 5.0
"""Seconds that taking leave may take."""


def distributed() -> Any:  # noqa: ANN401 - the module
    """Dask's package, which is to keep its tracebacks to itself: what happens is told in one line.

    Raises InputError where it is absent.
    """
    try:
        import_module("dask").config.set({"logging": {"distributed": "critical", "distributed.client": "critical"}})
        return import_module("distributed")
    except ImportError:
        raise InputError("--dask needs the package distributed: pip install 'plogic[dask]'") from None


class Connection:
    """To the scheduler at ``address``; ``say`` gets the lines that a user is to see meanwhile."""

    def __init__(self, address: str, say: Callable[[str], None]) -> None:
        """Connect. Raises InputError where the package is absent, or nobody answers in time."""
        self.address, self._say, self._empty, self._looked = address, say, 0.0, 0.0
        self.dask = distributed()
        try:
            asyncio.run(asyncio.wait_for(_greet(self.dask, address), CONNECTING))
            self.client: Any = self.dask.Client(address, timeout=CONNECTING, set_as_default=False)
        except Exception as error:
            what = " ".join(str(error).split()) or f"nothing is said within {CONNECTING:g} s"
            what = (
                "what answers is something else" if isinstance(error, MemoryError) else what
            )  # its first bytes are no length
            raise InputError(f"{address}: no Dask scheduler answers there: {what}") from error

    def wait(self) -> int:
        """The threads of all workers, as soon as there are any. Raises InputError as ``threads``."""
        while not (found := self.threads()):
            sleep(LOOK)
        return found

    def due(self) -> bool:
        """Whether it is time to ask for ``threads`` again."""
        return monotonic() - self._looked > LOOK

    def threads(self) -> int:
        """The threads of all workers; where there are none that is said once.

        Raises InputError where that lasts, or the scheduler is lost.
        """
        try:
            found = sum(self.client.nthreads(callback_timeout=CONNECTING).values())
        except Exception as error:
            raise self.failed(error) from error
        self._looked = now = monotonic()
        if found:
            self._empty = 0.0
        elif not self._empty:
            self._empty = now
            self._say(f"{self.address}: the Dask scheduler has no workers: waiting for them, for {WAITING:g} s")
        elif now - self._empty > WAITING:
            raise InputError(f"{self.address}: the Dask scheduler has had no workers for {WAITING:g} s")
        return found

    def failed(self, error: BaseException) -> InputError:
        """What is said of an error of the cluster's."""
        what = " ".join(f"{type(error).__name__}: {error}".split())
        if self.client.status != "running" or isinstance(error, OSError):
            what = "its scheduler is gone, or does not answer"
        return InputError(f"{self.address}: the Dask cluster failed: {what}")

    def close(self, farewell: Callable[[], object]) -> None:
        """Do a last thing, and let the scheduler forget what it was asked for: within some seconds, or not at all."""

        def leave() -> None:
            with suppress(Exception):  # the cluster may be gone
                farewell()

        left = threading.Thread(target=leave, daemon=True)
        left.start()
        left.join(CLOSING)
        with suppress(Exception):
            self.client.close(timeout=CLOSING)


async def _greet(dask: Any, address: str) -> None:  # noqa: ANN401 - the module
    """Raise whatever goes wrong where no scheduler answers."""
    comm = await dask.core.connect(address, timeout=CONNECTING, **dask.Security().get_connection_args("client"))
    try:
        await comm.write({"op": "identity", "reply": True})
        kind = (await comm.read())["type"]
    finally:
        comm.abort()
    if kind != "Scheduler":
        raise ValueError(f"it is a {kind.lower()}")
