"""Shapes of JSON documents: a ``TypedDict`` with bounds on its values and what each key means.

* ``Size(2)``, ``Size(0, 20_000)``: how long a list, a text or a table of names may be
* ``Lengths(0, 4, 5)``: the lengths that a list may have
* ``Range(0.0, 1.0)``: a number's bounds, both included; ``Range(0.0, open_low=True)``: above 0
* ``Row(str, str, float)``: a list whose elements have these types
* ``Rule("should be ...")``: what is said of any mistake inside, in one line

``Annotated[list[float], Size(2), "Pixels."]`` holds such a bound, and what the value means; a module of shapes keeps
its annotations as types, not as text. A shape is strict: a key that it does not name is a mistake, a truth value is no
number, and no number is infinite. Why this and no library: docs/dependencies.md.

Checks (``geometry.json_checks``), JSON Schemas (``geometry.files.json_schema``) and docs/formats.md are made of them.
"""

import sys
from collections.abc import Callable
from types import NoneType, UnionType
from typing import (
    Annotated,
    Any,
    Literal,
    NamedTuple,
    NotRequired,
    Self,
    Union,
    get_args,
    get_origin,
)

LARGEST = sys.float_info.max


class Size(NamedTuple):
    """Length: from ``least`` to ``most``, exactly ``least`` where no ``most`` is given."""

    least: int
    most: int | None = None

    def ends(self) -> tuple[int, int]:
        """The least and the most."""
        return self.least, self.least if self.most is None else self.most

    def admits(self, length: int) -> bool:
        """Whether something may be so long."""
        least, most = self.ends()
        return least <= length <= most

    def __str__(self) -> str:
        least, most = self.ends()
        return f"{least}" if least == most else f"{least} to {most}"


class Lengths(tuple[int, ...]):
    """Lengths that a list may have."""

    __slots__ = ()

    def __new__(cls, *lengths: int) -> Self:
        """These lengths, ascending."""
        return super().__new__(cls, lengths)

    def ends(self) -> tuple[int, int]:
        """The least and the most."""
        return self[0], self[-1]

    def admits(self, length: int) -> bool:
        """Whether something may be so long."""
        return length in self

    def __str__(self) -> str:
        return f"{', '.join(map(str, self[:-1]))} or {self[-1]}"


class Range(NamedTuple):
    """Bounds of a number, both included, or without the lower one."""

    low: float = -LARGEST
    high: float = LARGEST
    open_low: bool = False

    def __str__(self) -> str:
        low, high = (f"{end}" for end in (self.low, self.high))
        if self.open_low:
            return f" above {low}" if self.high >= LARGEST else f" above {low} and at most {high}"
        if self.high < LARGEST:
            return f" from {low} to {high}"
        return "" if self.low <= -LARGEST else f" from {low}"


class Row(tuple[Any, ...]):
    """The types of a list's elements, one by one."""

    __slots__ = ()

    def __new__(cls, *types: Any) -> Self:  # noqa: ANN401 - types
        """A row of these types."""
        return super().__new__(cls, types)


class Rule(str):
    """What is said of a value that has any mistake in it: ``Rule("should be a 3x3 matrix")``."""

    __slots__ = ()


ANY_SIZE, ANY_NUMBER = Size(0, 10_000_000), Range()
WHOLE = 1 << 53
"""No whole number is larger, either way: programs differ on those beyond (RFC 8259 §6), arrays may not hold them."""


class Parts(NamedTuple):
    """A shape taken apart: its type, its bounds, and what it means ('' where nobody says)."""

    of: Any
    bounds: tuple[object, ...]
    meaning: str

    def bound(self, kind: type | tuple[type, ...], default: Any = None) -> Any:  # noqa: ANN401 - a bound
        """The bound of this kind, else ``default``."""
        return next((b for b in self.bounds if isinstance(b, kind)), default)


def parts_of(shape: Any) -> Parts:  # noqa: ANN401 - a type
    """A shape's type, bounds and meaning, whether required or not."""
    if get_origin(shape) is NotRequired:
        return parts_of(get_args(shape)[0])
    if get_origin(shape) is not Annotated:
        return Parts(shape, (), "")
    of, *rest = get_args(shape)
    said = [each for each in rest if type(each) is str]
    return Parts(of, tuple(each for each in rest if type(each) is not str), said[-1] if said else "")


def span_of(parts: Parts) -> Range:
    """The bounds of a number; ``WHOLE`` bounds every whole one."""
    span: Range = parts.bound(Range, ANY_NUMBER)
    return span._replace(low=max(span.low, -WHOLE), high=min(span.high, WHOLE)) if parts.of is int else span


def options_of(shape: Any) -> tuple[Any, ...]:  # noqa: ANN401 - types
    """The types of a union, null last, each with the bounds that the union has; none of any other type."""
    parts = parts_of(shape)
    if get_origin(parts.of) not in (Union, UnionType):
        return ()
    rest = [each for each in get_args(parts.of) if each is not NoneType]
    bounded = [Annotated[(each, *parts.bounds)] if parts.bounds else each for each in rest]
    return (*bounded, *((NoneType,) if NoneType in get_args(parts.of) else ()))


def an_object(_: object) -> str:
    """What a table is called where nobody names it."""
    return "an object"


def described(shape: Any, called: Callable[[Any], str] = an_object) -> str:  # noqa: ANN401 - a type
    """What a value of this shape is, in words: "a list of 2, each a number", "a number from 0 to 1 or null".

    ``called`` names a table.
    """
    parts, options = parts_of(shape), options_of(shape)
    if options:
        return " or ".join(dict.fromkeys(described(option, called) for option in options))
    of, row, rule = parts.of, parts.bound(Row), parts.bound(Rule)
    if rule is not None or row is not None:
        return rule.removeprefix("should be ") if rule else f"[{', '.join(described(each, called) for each in row)}]"
    if of is float or of is int:
        return f"a {'whole ' if of is int else ''}number{parts.bound(Range, ANY_NUMBER)}"
    if get_origin(of) in (list, dict):
        whole = f"a list{_counted(parts)}, each" if get_origin(of) is list else "an object, each value"
        return f"{whole} {described(get_args(of)[-1], called)}"
    if get_origin(of) is Literal:
        return " or ".join(f"'{each}'" for each in get_args(of))
    return {str: "a text", bool: "true or false", NoneType: "null"}.get(of) or called(of)


def _counted(parts: Parts) -> str:
    """How many a list has, in words, where that is no mere limit."""
    size = parts.bound((Size, Lengths))
    return f" of {size}" if isinstance(size, Lengths) or (size is not None and size.most is None) else ""
