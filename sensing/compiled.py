"""Loops that numba compiles and keeps on disk; what is damaged there is made anew.

* ``@compiled()`` above a function of numbers and arrays: when it is first called, for the types that it is called with
* ``@compiled("f8(f8[:,::1], i8)")``: at once, for these types alone

A division by zero gives inf or NaN, as numpy's does: loops need not look for it.
"""

from collections.abc import Callable
from contextlib import suppress
from functools import partial
from typing import Any

from geometry.room import MB, check_room
from sensing.errors import SensingError

try:
    from numba import njit
except ValueError as error:
    raise SensingError(f"a variable NUMBA_... of the environment keeps numba from being loaded: {error}") from error

COMPILING = 245 * MB, 290 * MB
"""Bytes of memory and of address space that are wanted before a loop is compiled: LLVM ends a process without.

A quarter more than all our loops take where none is kept (``tests/sensing/test_compiled.py`` measures it).
"""
UNKEPT: list[str] = []
"""The loops that are compiled anew in each process, as there is no folder that takes them."""


def compiled(signature: str | None = None) -> Callable[[Callable[..., Any]], Any]:
    """Return what makes a compiled function of one of Python."""

    def made(function: Callable[..., Any]) -> Any:  # noqa: ANN401 - what is compiled takes arrays of several types
        check_room(*COMPILING)
        loop: Any
        try:
            loop = _njit(cache=True)(function)
            if loop is function:  # NUMBA_DISABLE_JIT
                return loop
            _mend(loop._cache)  # noqa: SLF001 - numba looks there first, and raises where anything is torn
        except RuntimeError:  # neither beside the source, nor in the user's home, nor where NUMBA_CACHE_DIR says
            loop = _njit()(function)
            UNKEPT.append(function.__name__)
        if signature is not None:
            loop.compile(signature)
            loop.disable_compile()
        return loop

    return made


_njit = partial(njit, error_model="numpy")


def _mend(cache: Any) -> None:  # noqa: ANN401 - numba is untyped
    """Let a cache that cannot be read be emptied."""
    load = cache.load_overload

    def mended(*what: object) -> object:
        with suppress(Exception):  # whatever is wrong with what is kept, it can be made anew
            return load(*what)
        try:
            cache.flush()
        except OSError:  # who may not write there keeps nothing
            cache.disable()
        return None

    cache.load_overload = mended
