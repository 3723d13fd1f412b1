"""What Python hands in, held to what it should be: a wrong argument is an ``InputError`` that names it.

numpy's numbers are numbers.
"""

from collections.abc import Sequence
from numbers import Real
from operator import index

from plogic.base.errors import InputError


def seconds(name: str, value: object) -> float | None:
    """A deadline above 0, or None. Raises InputError."""
    if value is None:
        return None
    number = float(value) if isinstance(value, Real) else 0.0
    if not number > 0.0:
        raise InputError(f"{name}: {value!r:.60} should be a number of seconds above 0")
    return number


def share(name: str, value: object, below: float) -> float:
    """A number from 0 to ``below``. Raises InputError."""
    number = float(value) if isinstance(value, Real) else -1.0
    if not 0.0 <= number < below:
        raise InputError(f"{name}: {value!r:.60} should be at least 0 and below {below:g}")
    return number


def count(name: str, value: object) -> int:
    """A whole number from 1. Raises InputError."""
    try:
        number = 0 if isinstance(value, bool) else index(value)  # type: ignore[arg-type]
    except TypeError:
        number = 0
    if number < 1:
        raise InputError(f"{name}: {value!r:.60} should be a whole number from 1")
    return number


def text(name: str, value: object) -> str:
    """A string. Raises InputError."""
    if not isinstance(value, str):
        raise InputError(f"{name}: {value!r:.60} should be a text")
    return value


def texts(name: str, value: object) -> tuple[str, ...]:
    """One string, or several. Raises InputError."""
    if isinstance(value, str):
        return (value,)
    if not isinstance(value, Sequence) or not all(isinstance(one, str) for one in value):
        raise InputError(f"{name}: {value!r:.60} should be a text, or several")
    return tuple(value)
