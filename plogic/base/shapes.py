"""Shapes of JSON documents: a ``TypedDict`` with bounds, and every mistake that a document makes against it.

* ``Size(2)``, ``Size(0, 20_000)``: how long a list, a text or a table of names may be
* ``Range(0.0, 1.0)``: a number's bounds, both included
* ``Row(str, str, float)``: a list whose elements have these types

``Annotated[list[float], Size(2)]`` holds such a bound; a module of shapes keeps its annotations as types, not as text.
A shape is strict: a key that it does not name is a mistake, a truth value is no number, and no number is infinite.
Why this and no library: docs/dependencies.md.
"""

import sys
from collections.abc import Callable, Iterable, Sequence
from functools import cache
from itertools import islice
from reprlib import repr as repr_of
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
    is_typeddict,
)

Mistake = tuple[tuple[str | int, ...], str]
"""The place, from the outside in, and what is wrong there."""
Check = Callable[[object], Sequence[Mistake]]
"""A function from a value to its mistakes."""
MOST = 1000
"""Mistakes of one list or table after which nobody looks further."""
LARGEST = sys.float_info.max
NONE: tuple[Mistake, ...] = ()


class Size(NamedTuple):
    """Length: from ``least`` to ``most``, exactly ``least`` where no ``most`` is given."""

    least: int
    most: int | None = None

    def ends(self) -> tuple[int, int, str]:
        """The least, the most, and both in words."""
        most = self.least if self.most is None else self.most
        return self.least, most, f"{self.least}" if self.least == most else f"{self.least} to {most}"


class Range(NamedTuple):
    """Bounds of a number, both included."""

    low: float = -LARGEST
    high: float = LARGEST


class Row(tuple[Any, ...]):
    """The types of a list's elements, one by one."""

    __slots__ = ()

    def __new__(cls, *types: Any) -> Self:  # noqa: ANN401 - types
        """A row of these types."""
        return super().__new__(cls, types)


ANY_SIZE, ANY_NUMBER = Size(0, 10_000_000), Range()


def mistakes(value: object, shape: object) -> list[str]:
    """Every mistake of a document against its shape, each a line ``hypotheses.0.features.3.dv: -1.0 is not ...``.

    None of a right one.
    """
    return [f"{'.'.join(map(str, place))}: {what}" if place else what for place, what in check_of(shape)(value)]


@cache
def check_of(shape: Any) -> Check:  # noqa: ANN401 - a type
    """The check of a type: a function from a value to its mistakes."""
    if get_origin(shape) is NotRequired:
        return check_of(get_args(shape)[0])
    if get_origin(shape) is not Annotated:
        return _table(shape) if is_typeddict(shape) else _bounded(shape, (), ANY_SIZE)
    of, *bounds = get_args(shape)
    row = next((b for b in bounds if type(b) is Row), None)
    if row is not None:
        return _row(tuple(check_of(t) for t in row))
    return _bounded(of, tuple(bounds), next((b for b in bounds if type(b) is Size), ANY_SIZE))


def _bounded(of: Any, bounds: tuple[object, ...], size: Size) -> Check:  # noqa: ANN401 - a type
    origin, args = get_origin(of), get_args(of)
    if origin is list:
        return _list(check_of(args[0]), size)
    if origin is dict:
        return _names(check_of(args[1]), size)
    if origin is Literal:
        return _one_of(args)
    if origin in (Union, UnionType):
        return _any_of(args, bounds)
    if of is float or of is int:
        return _number(next((b for b in bounds if isinstance(b, Range)), ANY_NUMBER), whole=of is int)
    return _text(size) if of is str else _truth if of is bool else _nothing


def _number(span: Range, *, whole: bool) -> Check:
    low, high, kind = span.low, span.high, "whole number" if whole else "number"
    within = "" if span == ANY_NUMBER else f" from {low} to {high}" if high < LARGEST else f" from {low}"

    def check(value: object) -> Sequence[Mistake]:
        found = type(value)
        if (found is int or (found is float and not whole)) and low <= value <= high:  # type: ignore[operator]
            return NONE
        return [((), f"{shown(value)} is not a {kind}{within}")]

    return check


def _text(size: Size) -> Check:
    least, most, said = size.ends()

    def check(value: object) -> Sequence[Mistake]:
        if type(value) is not str:
            return [((), f"{shown(value)} is no text")]
        return NONE if least <= len(value) <= most else [((), f"a text of {len(value)} characters, and not of {said}")]

    return check


def _truth(value: object) -> Sequence[Mistake]:
    return NONE if type(value) is bool else [((), f"{shown(value)} is neither true nor false")]


def _nothing(value: object) -> Sequence[Mistake]:
    return NONE if value is None else [((), f"{shown(value)} is not null")]


def _one_of(allowed: tuple[object, ...]) -> Check:
    said = (
        f"should be one of {', '.join(str(each) for each in allowed if each != '')}"
        if len(allowed) > 1
        else f"should be {allowed[0]!r}"
    )
    types = {type(a) for a in allowed}

    def check(value: object) -> Sequence[Mistake]:
        return NONE if type(value) in types and value in allowed else [((), f"{shown(value)} {said}")]

    return check


def _inside(inner: Check, elements: Iterable[tuple[str | int, object]]) -> Sequence[Mistake]:
    """The first mistakes of what a list or a table of names holds."""
    found = (((key, *place), what) for key, element in elements for place, what in inner(element))
    return list(islice(found, MOST))


def _list(inner: Check, size: Size) -> Check:
    least, most, said = size.ends()

    def check(value: object) -> Sequence[Mistake]:
        if type(value) is not list:
            return [((), f"{shown(value)} is no list")]
        if not least <= len(value) <= most:
            return [((), f"a list of {len(value)}, and not of {said}")]
        return _inside(inner, enumerate(value)) if any(map(inner, value)) else NONE

    return check


def _row(inner: tuple[Check, ...]) -> Check:
    def check(value: object) -> Sequence[Mistake]:
        if type(value) is not list or len(value) != len(inner):
            return [((), f"{shown(value)} is no list of {len(inner)}")]
        return [((i, *place), what) for i, one in enumerate(inner) for place, what in one(value[i])]

    return check


def _names(inner: Check, size: Size) -> Check:
    least, most, said = size.ends()

    def check(value: object) -> Sequence[Mistake]:
        if type(value) is not dict:
            return [((), f"{shown(value)} is no object")]
        if not least <= len(value) <= most:
            return [((), f"an object of {len(value)} keys, and not of {said}")]
        named = ((_name(key), element) for key, element in value.items())
        return _inside(inner, named) if any(map(inner, value.values())) else NONE

    return check


def _table(shape: Any) -> Check:  # noqa: ANN401 - a TypedDict
    checks = {key: check_of(of) for key, of in shape.__annotations__.items()}
    required = shape.__required_keys__

    def check(value: object) -> Sequence[Mistake]:
        if type(value) is not dict:
            return [((), f"{shown(value)} is no object")]
        found: list[Mistake] = []
        if not value.keys() >= required:
            found += [((key,), "is missing") for key in checks if key in required and key not in value]
        for key, element in value.items():
            if key not in checks:
                found.append(((_name(key),), "unknown key"))
            elif wrong := checks[key](element):
                found += [((key, *place), what) for place, what in wrong]
        return found or NONE

    return check


def _any_of(options: tuple[Any, ...], bounds: Sequence[object]) -> Check:
    """Of null and one type, or of tables that a key with one text tells apart."""
    rest = tuple(o for o in options if o is not NoneType)
    if len(rest) > 1:
        return _tagged(rest) if all(map(is_typeddict, rest)) else _first_of(tuple(map(check_of, options)))
    inner = check_of(Annotated.__class_getitem__((rest[0], *bounds)) if bounds else rest[0])  # type: ignore[attr-defined]

    def check(value: object) -> Sequence[Mistake]:
        return NONE if value is None else inner(value)

    return check


def _first_of(checks: tuple[Check, ...]) -> Check:
    def check(value: object) -> Sequence[Mistake]:
        return NONE if any(not one(value) for one in checks) else checks[0](value)

    return check


def _tagged(tables: tuple[Any, ...]) -> Check:
    hints = [table.__annotations__ for table in tables]
    tag = next(key for key in hints[0] if all(get_origin(h.get(key)) is Literal for h in hints))
    checks = {text: check_of(table) for table, h in zip(tables, hints, strict=True) for text in get_args(h[tag])}

    def check(value: object) -> Sequence[Mistake]:
        if type(value) is not dict:
            return [((), f"{shown(value)} is no object")]
        kind = value.get(tag)
        if type(kind) is not str or kind not in checks:
            said = f"{shown(kind)} should be one of {', '.join(checks)}" if tag in value else "is missing"
            return [((tag,), said)]
        return checks[kind](value)

    return check


def _name(key: object) -> str:
    return f"{key!s:.60}"


def shown(value: object) -> str:
    """A value in a message, cut to 60 characters."""
    return f"{repr_of(value):.60}"
