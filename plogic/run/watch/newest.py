"""The newest of what comes: a thread takes things as they come, and whoever asks gets the last one.

* ``with Newest(frames, lambda frame, skipped: ...) as newest: next(newest)``: waits where none has come since
"""

from collections.abc import Callable, Generator
from contextlib import closing
from threading import Condition, Thread
from typing import Generic, Self, TypeVar

Thing = TypeVar("Thing")
LOOK = 0.2
"""Seconds after which who waits can be interrupted."""


class Newest(Generic[Thing]):
    """``told(thing, skipped)`` is what is handed on: ``skipped`` things came before it since the last one that was."""

    def __init__(self, things: Generator[Thing], told: Callable[[Thing, int], Thing]) -> None:
        self._things, self._told = things, told
        self._last: list[Thing] = []
        self._come = self._given = 0
        self._over = False
        self._error: Exception | None = None
        self._changed = Condition()
        self._thread = Thread(target=self._take, daemon=True)

    def __enter__(self) -> Self:
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        """Take no more; a thread that waits for the next thing is left waiting, and ends with the process."""
        with self._changed:
            self._over = True
        self._thread.join(LOOK)

    def __iter__(self) -> Self:
        return self

    def __next__(self) -> Thing:
        """The newest, once there is one that was not given; what ended the things is raised after the last one."""
        with self._changed:
            while not self._last and not self._over:
                self._changed.wait(LOOK)
            if self._last:
                skipped, self._given = self._come - self._given - 1, self._come
                return self._told(self._last.pop(), skipped)
        if self._error is not None:
            raise self._error
        raise StopIteration

    def _take(self) -> None:
        error = None
        try:
            with closing(self._things) as things:
                for thing in things:
                    with self._changed:
                        if self._over:
                            return
                        self._last, self._come = [thing], self._come + 1
                        self._changed.notify()
        except Exception as fault:  # noqa: BLE001 - raised where the things are used
            error = fault
        with self._changed:
            self._over, self._error = True, error
            self._changed.notify()
