"""Shapes of JSON documents: a ``TypedDict`` with bounds, and every mistake that a document makes against it.

* ``Size(2)``, ``Size(0, 20_000)``: how long a list, a text or a table of names may be
* ``Lengths(0, 4, 5)``: the lengths that a list may have
* ``Range(0.0, 1.0)``: a number's bounds, both included; ``Range(0.0, open_low=True)``: above 0
* ``Row(str, str, float)``: a list whose elements have these types
* ``Rule("should be ...")``: what is said of any mistake inside, in one line

``Annotated[list[float], Size(2), "Pixels."]`` holds such a bound, and what the value means; a module of shapes keeps
its annotations as types, not as text. A shape is strict: a key that it does not name is a mistake, a truth value is no
number, and no number is infinite. Why this and no library: docs/dependencies.md.

The JSON Schemas (``geometry.files.json_schema``) and docs/formats.md are made from the same shapes.
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

from geometry.errors import Mistake

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


def mistakes(value: object, shape: object) -> list[str]:
    """Every mistake of a document against its shape, each a line ``hypotheses.0.features.3.dv: -1.0 is not ...``.

    None of a right one.
    """
    return [str(mistake) for mistake in check_of(shape)(value)]


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


def options_of(shape: Any) -> tuple[Any, ...]:  # noqa: ANN401 - types
    """The types of a union, null last, each with the bounds that the union has; none of any other type."""
    parts = parts_of(shape)
    if get_origin(parts.of) not in (Union, UnionType):
        return ()
    rest = [each for each in get_args(parts.of) if each is not NoneType]
    bounded = [Annotated[(each, *parts.bounds)] if parts.bounds else each for each in rest]
    return (*bounded, *((NoneType,) if NoneType in get_args(parts.of) else ()))


@cache
def check_of(shape: Any) -> Check:  # noqa: ANN401 - a type
    """The check of a type: a function from a value to its mistakes."""
    parts = parts_of(shape)
    rule, row = parts.bound(Rule), parts.bound(Row)
    if rule is not None:
        bounds = tuple(bound for bound in parts.bounds if bound is not rule)
        return _ruled(check_of(Annotated[(parts.of, *bounds, "")]), rule)
    if row is not None:
        return _row(tuple(check_of(t) for t in row))
    if is_typeddict(parts.of):
        return _table(parts.of)
    if options := options_of(shape):
        return _any_of(options)
    return _bounded(parts, parts.bound((Size, Lengths), ANY_SIZE))


def _ruled(inner: Check, rule: Rule) -> Check:
    def check(value: object) -> Sequence[Mistake]:
        return [Mistake((), f"{rule}, not {shown(value)}")] if inner(value) else NONE

    return check


def _bounded(parts: Parts, size: Size | Lengths) -> Check:
    of, origin, args = parts.of, get_origin(parts.of), get_args(parts.of)
    if origin is list:
        return _list(check_of(args[0]), size)
    if origin is dict:
        return _names(check_of(args[1]), size)
    if origin is Literal:
        return _one_of(args)
    if of is float or of is int:
        return _number(parts.bound(Range, ANY_NUMBER), whole=of is int)
    return _text(size) if of is str else _truth if of is bool else _nothing


def described(shape: Any) -> str:  # noqa: ANN401 - a type
    """What a value of this shape is, in words: "a list of 2, each a number", "a number from 0 to 1 or null"."""
    parts, options = parts_of(shape), options_of(shape)
    if options:
        return " or ".join(dict.fromkeys(map(described, options)))
    of, row, rule = parts.of, parts.bound(Row), parts.bound(Rule)
    if rule is not None or row is not None:
        return rule.removeprefix("should be ") if rule else f"[{', '.join(map(described, row))}]"
    if of is float or of is int:
        return f"a {'whole ' if of is int else ''}number{parts.bound(Range, ANY_NUMBER)}"
    if get_origin(of) is list:
        return f"a list{_counted(parts)}, each {described(get_args(of)[0])}"
    if get_origin(of) is Literal:
        return " or ".join(f"'{each}'" for each in get_args(of))
    return {str: "a text", bool: "true or false", NoneType: "null"}.get(of, "an object")


def _counted(parts: Parts) -> str:
    """How many a list has, in words, where that is no mere limit."""
    size = parts.bound((Size, Lengths))
    return f" of {size}" if isinstance(size, Lengths) or (size is not None and size.most is None) else ""


def _number(span: Range, *, whole: bool) -> Check:
    low, high, kind = span.low, span.high, "whole number" if whole else "number"
    above = span.open_low
    rule = f"should be {low:g}" if low == high else f"is not a {kind}{span}"

    def check(value: object) -> Sequence[Mistake]:
        found = type(value)
        if (found is int or (found is float and not whole)) and low <= value <= high and not (above and value == low):  # type: ignore[operator]
            return NONE
        return [Mistake((), f"{shown(value)} {rule}")]

    return check


def _text(size: Size | Lengths) -> Check:
    least, most = size.ends()

    def check(value: object) -> Sequence[Mistake]:
        if type(value) is not str:
            return [Mistake((), f"{shown(value)} is no text")]
        return (
            NONE
            if least <= len(value) <= most
            else [Mistake((), f"a text of {len(value)} characters, and not of {size}")]
        )

    return check


def _truth(value: object) -> Sequence[Mistake]:
    return NONE if type(value) is bool else [Mistake((), f"{shown(value)} is neither true nor false")]


def _nothing(value: object) -> Sequence[Mistake]:
    return NONE if value is None else [Mistake((), f"{shown(value)} is not null")]


def _one_of(allowed: tuple[object, ...]) -> Check:
    said = (
        f"should be one of {', '.join(str(each) for each in allowed if each != '')}"
        if len(allowed) > 1
        else f"should be {allowed[0]!r}"
    )
    types = {type(a) for a in allowed}

    def check(value: object) -> Sequence[Mistake]:
        return NONE if type(value) in types and value in allowed else [Mistake((), f"{shown(value)} {said}")]

    return check


def _inside(inner: Check, elements: Iterable[tuple[str | int, object]]) -> Sequence[Mistake]:
    """The first mistakes of what a list or a table of names holds."""
    found = (mistake.below(key) for key, element in elements for mistake in inner(element))
    return list(islice(found, MOST))


def _list(inner: Check, size: Size | Lengths) -> Check:
    admits = size.admits

    def check(value: object) -> Sequence[Mistake]:
        if type(value) is not list:
            return [Mistake((), f"{shown(value)} is no list")]
        if not admits(len(value)):
            return [Mistake((), f"a list of {len(value)}, and not of {size}")]
        return _inside(inner, enumerate(value)) if any(map(inner, value)) else NONE

    return check


def _row(inner: tuple[Check, ...]) -> Check:
    def check(value: object) -> Sequence[Mistake]:
        if type(value) is not list or len(value) != len(inner):
            return [Mistake((), f"{shown(value)} is no list of {len(inner)}")]
        return [mistake.below(i) for i, one in enumerate(inner) for mistake in one(value[i])]

    return check


def _names(inner: Check, size: Size | Lengths) -> Check:
    admits = size.admits

    def check(value: object) -> Sequence[Mistake]:
        if type(value) is not dict:
            return [Mistake((), f"{shown(value)} is no object")]
        if not admits(len(value)):
            return [Mistake((), f"an object of {len(value)} keys, and not of {size}")]
        return _inside(inner, value.items()) if any(map(inner, value.values())) else NONE

    return check


def _table(shape: Any) -> Check:  # noqa: ANN401 - a TypedDict
    checks = {key: check_of(of) for key, of in shape.__annotations__.items()}
    required = {
        key: f"is missing: should be {described(shape.__annotations__[key])}"
        for key in checks
        if key in shape.__required_keys__
    }
    known = f"unknown key; known are {', '.join(checks)}"

    def check(value: object) -> Sequence[Mistake]:
        if type(value) is not dict:
            return [Mistake((), f"{shown(value)} is no object with the keys {', '.join(required)}")]
        found: list[Mistake] = []
        if not value.keys() >= required.keys():
            found += [Mistake((key,), said) for key, said in required.items() if key not in value]
        for key, element in value.items():
            if key not in checks:
                found.append(Mistake((key,), known, at_key=True))
            elif wrong := checks[key](element):
                found += [mistake.below(key) for mistake in wrong]
        return found or NONE

    return check


def _any_of(options: tuple[Any, ...]) -> Check:
    """Of null and one type, or of tables that a key with one text tells apart."""
    rest = tuple(o for o in options if o is not NoneType)
    inner = check_of(rest[0]) if len(rest) == 1 else _tagged(rest) or _nearest_of(tuple(map(check_of, rest)))
    if NoneType not in options:
        return inner

    def check(value: object) -> Sequence[Mistake]:
        return NONE if value is None else inner(value)

    return check


def _nearest_of(checks: tuple[Check, ...]) -> Check:
    """Right by one of them; else the mistakes by the one that finds the fewest."""

    def check(value: object) -> Sequence[Mistake]:
        return min((one(value) for one in checks), key=len)

    return check


def tag_of(tables: tuple[Any, ...]) -> str | None:
    """The key whose texts tell these tables apart; None where there is no such key, or one is no table."""
    if not all(map(is_typeddict, tables)):
        return None
    hints = [table.__annotations__ for table in tables]
    for key in hints[0]:
        texts = [get_args(h[key]) if get_origin(h.get(key)) is Literal else ("", "") for h in hints]
        if len(set().union(*texts)) == sum(map(len, texts)):
            return str(key)
    return None


def _tagged(tables: tuple[Any, ...]) -> Check | None:
    tag = tag_of(tables)
    if tag is None:
        return None
    checks = {text: check_of(table) for table in tables for text in get_args(table.__annotations__[tag])}

    def check(value: object) -> Sequence[Mistake]:
        if type(value) is not dict:
            return [Mistake((), f"{shown(value)} is no object")]
        kind = value.get(tag)
        if type(kind) is not str or kind not in checks:
            said = f"should be one of {', '.join(checks)}"
            return [Mistake((tag,), f"{shown(kind)} {said}" if tag in value else f"is missing: {said}")]
        return checks[kind](value)

    return check


def shown(value: object) -> str:
    """A value in a message, cut to 60 characters."""
    return f"{repr_of(value):.60}"
