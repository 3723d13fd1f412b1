"""Changes to a document that mostly keep its shape: what passes the first checks reaches those after them.

``ShapedAs("plogic.facts.document", "Interpretation")`` is a mutator: it adds keys that a document may have, and
elements of its lists, and puts other values of their shape in the place of some; then it changes half of the documents
as ``mutators.as_json`` does. Programs it does not make: each would start a process, and they are a kind of their own.
"""

from __future__ import annotations

import json
from dataclasses import dataclass
from functools import cache
from importlib import import_module
from math import pi
from types import NoneType
from typing import TYPE_CHECKING, Any, Literal, get_args, get_origin, is_typeddict

from benchmarks.fuzz.mutators import CHANGES, LONGEST, MANY, TEXTS, as_json, values
from geometry.camera_row import RIGID
from geometry.frames import from_rotation_translation, turn_about
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
    options_of,
    parts_of,
)

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence
    from random import Random

DEEP = 4
"""Tables in tables, below which a new table has no key that it need not have."""
PROGRAM = "rules"
"""The key of a program."""
PLAIN = 0.0, 1.0, 0.5, -1.0, 2.0, 3.0, 1e-9, 1e-300, 1e9, 1e300
"""Numbers, beside the ends of their range."""

Place = tuple[Any, Any, Any]
"""A table or list of the document, a key or index that it has or may have, and the shape of what stands there."""


@dataclass(frozen=True)
class ShapedAs:
    """Changes within a shape, by the name of its module and its own."""

    module: str
    name: str

    def __call__(self, data: bytes, rng: Random, pool: Sequence[bytes]) -> bytes:
        """One to eight such changes."""
        try:
            tree = json.loads(data)
        except (ValueError, RecursionError):
            return as_json(data, rng, pool)
        shape = self.shape()
        for _ in range(rng.choice(CHANGES)):
            change(tree, shape, rng)
        text = json.dumps(tree).encode()[: 10 * LONGEST]
        return as_json(text, rng, pool) if rng.randrange(2) else text

    def shape(self) -> Any:  # noqa: ANN401 - a type
        """The shape itself."""
        return getattr(import_module(self.module), self.name)


def change(tree: Any, shape: Any, rng: Random) -> None:  # noqa: ANN401 - JSON
    """One change, in the tree itself."""
    places = [place for place in _places(tree, shape) if place[1] != PROGRAM][:MANY]
    if not places:
        return
    new = [place for place in places if isinstance(place[0], dict) and place[1] not in place[0]]
    holder, key, of = rng.choice(new if new and rng.randrange(2) else places)
    made = _Maker(rng, sorted(_texts(tree))).made(of, DEEP)
    if isinstance(holder, list):
        holder[key : key + 1] = [made]  # or at its end, where there may be one more
    else:
        holder[key] = made


@cache
def _taken_apart(shape: Any) -> tuple[tuple[Any, ...], Parts, Row | None]:  # noqa: ANN401 - a type
    """Its options, its parts, and of these the row."""
    parts = parts_of(shape)
    return options_of(shape), parts, parts.bound(Row)


def _places(tree: Any, shape: Any) -> Iterator[Place]:  # noqa: ANN401 - JSON
    """Where something stands in a document, or may stand, as far as it has the shape."""
    todo = [(tree, shape)]
    while todo:
        at, wanted = todo.pop()
        options, parts, row = _taken_apart(wanted)
        if parts.bound(Rule) == RIGID:
            continue  # a pose is another as a whole
        if options:
            todo += [(at, option) for option in options]
        elif isinstance(at, dict) and is_typeddict(parts.of):
            shapes = parts.of.__annotations__
            yield from ((at, key, of) for key, of in shapes.items())
            todo += [(at[key], of) for key, of in shapes.items() if key in at]
        elif isinstance(at, dict) and get_origin(parts.of) is dict:
            of = get_args(parts.of)[1]
            yield from ((at, key, of) for key in at)
            todo += [(each, of) for each in at.values()]
        elif isinstance(at, list) and row is not None:
            yield from ((at, i, of) for i, of in zip(range(len(at)), row, strict=False))
        elif isinstance(at, list) and get_origin(parts.of) is list:
            of = get_args(parts.of)[0]
            yield from (
                (at, i, of) for i in range(len(at) + parts.bound((Size, Lengths), ANY_SIZE).admits(len(at) + 1))
            )
            todo += [(each, of) for each in at]


def _texts(tree: Any) -> set[str]:  # noqa: ANN401 - JSON
    """All texts of a document, keys too: what one place names stands in another."""
    every = values(tree)
    texts = {at for at in every if isinstance(at, str)}.union(*(at for at in every if isinstance(at, dict)))
    return {text for text in texts if len(text) < 100}


@dataclass(frozen=True)
class _Maker:
    """Makes values of any shape; ``texts``: what may be named."""

    rng: Random
    texts: Sequence[str]

    def made(self, shape: Any, deep: int) -> Any:  # noqa: ANN401 - JSON
        """A value of the shape."""
        options, parts, row = _taken_apart(shape)
        of = parts.of
        if parts.bound(Rule) == RIGID:
            return self._pose()
        if options:
            return self.made(self.rng.choice(options), deep)
        if row is not None or get_origin(of) is list:
            each = row if row is not None else get_args(of) * self._length(parts.bound((Size, Lengths)))
            return [self.made(one, deep - 1) for one in each]
        if get_origin(of) is dict:
            return {self._text(): self.made(get_args(of)[1], deep - 1) for _ in range(self.rng.randrange(3))}
        if is_typeddict(of):
            return {key: self.made(one, deep - 1) for key, one in self._keys(of, deep).items()}
        return self._plain(of, parts.bound(Range, ANY_NUMBER))

    def _keys(self, table: Any, deep: int) -> dict[str, Any]:  # noqa: ANN401 - a type
        """Those that a table must have, and some that it may."""
        more = {key for key in table.__optional_keys__ - {PROGRAM} if deep > 0 and self.rng.randrange(2)}
        return {key: of for key, of in table.__annotations__.items() if key in table.__required_keys__ | more}

    def _plain(self, of: Any, within: Range) -> Any:  # noqa: ANN401 - JSON
        if of in (float, int):
            return self._number(within, whole=of is int)
        if get_origin(of) is Literal:
            return self.rng.choice(get_args(of))
        return {str: self._text(), bool: self.rng.randrange(2) == 1, NoneType: None}.get(of)

    def _text(self) -> str:
        return self.rng.choice(self.texts if self.texts and self.rng.randrange(4) else TEXTS)

    def _number(self, within: Range, *, whole: bool) -> float:
        low, high = within.low if not within.open_low else max(within.low, 1e-9), within.high
        ends = [end for end in (low, high) if abs(end) < ANY_NUMBER.high]
        value = min(max(self.rng.choice((*PLAIN, *ends, self.rng.random())), low), high)
        return int(min(max(value, -WHOLE), WHOLE)) if whole else value

    def _pose(self) -> list[list[float]]:
        """A turn about an axis of the frame, and a place."""
        angle, axis = self.rng.choice((0.0, pi, self.rng.random())), [0.0, 0.0, 0.0]
        axis[self.rng.randrange(3)] = 1.0
        pose: list[list[float]] = from_rotation_translation(
            turn_about(axis, angle), self.rng.choices(PLAIN, k=3)
        ).tolist()
        return pose

    def _length(self, size: Size | Lengths | None) -> int:
        least, most = (0, 3) if size is None else size.ends()
        if isinstance(size, Lengths):
            return int(self.rng.choice(size))
        return self.rng.randint(least, max(least, min(most, 3)))
