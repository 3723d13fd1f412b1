"""Every mistake that a document makes against its shape (``geometry.json_shapes``)."""

from collections.abc import Callable, Iterable, Sequence
from functools import cache
from itertools import islice
from reprlib import repr as repr_of
from types import NoneType
from typing import Annotated, Any, Literal, get_args, get_origin, is_typeddict

from geometry.errors import Mistake
from geometry.json_shapes import (
    ANY_NUMBER,
    ANY_SIZE,
    WHOLE,
    Lengths,
    Parts,
    Range,
    Row,
    Rule,
    Size,
    described,
    options_of,
    parts_of,
    span_of,
)

Check = Callable[[object], Sequence[Mistake]]
"""A function from a value to its mistakes."""
MOST = 1000
"""Mistakes of one list or table after which nobody looks further."""
NONE: tuple[Mistake, ...] = ()


def mistakes(value: object, shape: object) -> list[str]:
    """Every mistake of a document against its shape, each a line ``hypotheses.0.features.3.dv: -1.0 is not ...``.

    None of a right one.
    """
    return [str(mistake) for mistake in check_of(shape)(value)]


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
        return _number(parts)
    return _text(size) if of is str else _truth if of is bool else _nothing


def _number(parts: Parts) -> Check:
    whole, (low, high, above) = parts.of is int, span_of(parts)
    kind = "whole number" if whole else "number"
    rule = f"should be {low:g}" if low == high else f"is not a {kind}{parts.bound(Range, ANY_NUMBER)}"

    def check(value: object) -> Sequence[Mistake]:
        found = type(value)
        if (found is int or (found is float and not whole)) and low <= value <= high and not (above and value == low):  # type: ignore[operator]
            return NONE
        beyond = whole and found is int and abs(value) > WHOLE  # type: ignore[arg-type]
        return [Mistake((), f"{shown(value)} {f'is a whole number beyond {WHOLE}' if beyond else rule}")]

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
