"""JSON documents of strangers: read within limits, and each mistake told with its line and column.

* ``Document("gamma.json", {"format": "gamma/1", ...}, text)``: what was read; without a text nobody knows any line
"""

import json
import re
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Sequence
from pathlib import Path
from typing import Any, NamedTuple, get_args

from geometry.digits import TOO_LONG, start_of_too_long
from geometry.errors import Keys, Mistake
from geometry.files.plain_files import name_of, text_of
from geometry.json_checks import check_of

DEEPEST = 100
"""Levels of nesting at which a document is called too deep, once it cannot be read; ours have below twenty."""
_SPACE = re.compile(r"[ \t\n\r]*")
_STRING = r'"[^"\\]*(?:\\.[^"\\]*)*"'
_decoded = json.JSONDecoder().raw_decode


class Document(NamedTuple):
    """``name``: what errors call it. ``data``: what it holds. ``text``: as it was read, '' where there is none."""

    name: str
    data: Any
    text: str = ""

    def told(self, mistakes: Sequence[Mistake]) -> list[str]:
        """A line for each mistake: ``gamma.json:12:7: appearances.1.uv: a list of 1, and not of 2``."""
        return [f"{place}: {mistake}" for place, mistake in zip(self.where(mistakes), mistakes, strict=True)]

    def where(self, mistakes: Sequence[Mistake]) -> list[str]:
        """Where each mistake is: ``gamma.json:12:7``."""
        found = places(self.text, mistakes) if self.text else [""] * len(mistakes)
        return [f"{self.name}{place}" for place in found]

    def against(self, shape: Any) -> list[Mistake]:  # noqa: ANN401 - a type
        """Every mistake against a shape; of a document of quite another format that alone."""
        found = list(check_of(shape)(self.data))
        return [mistake for mistake in found if mistake.place == ("format",)] if self.is_other(shape) else found

    def is_other(self, shape: Any) -> bool:  # noqa: ANN401 - a TypedDict
        """Whether the document says that it is of another format, not of another version of this one."""
        (wanted,) = get_args(shape.__annotations__["format"])
        said = self.data.get("format") if isinstance(self.data, dict) else None
        return isinstance(said, str) and said.partition("/")[0] != wanted.partition("/")[0]


def read_json(
    path: Path | str,
    most: int,
    holds: str,
    error: Callable[[str], Exception],
    *,
    finite: bool = False,
    single: bool = False,
) -> Document:
    """The document of a file, of a pipe or, of '-', of stdin, as ``parsed_json`` has it.

    Raises:
        error: The file cannot be read, is larger than ``most`` bytes, or is no JSON.
    """
    text = text_of(path, most, error, "JSON")
    return parsed_json(text, name_of(path), holds, error, finite=finite, single=single)


def parsed_json(
    text: str, name: str, holds: str, error: Callable[[str], Exception], *, finite: bool = False, single: bool = False
) -> Document:
    """The document that a text is; ``name`` opens the message of an error.

    Args:
        text: JSON.
        name: What errors call the file.
        holds: What should be in it, said where it is nested too deeply.
        error: What is raised.
        finite: NaN and infinities are refused, as JSON has none.
        single: Keys that stand twice in one object are refused, a line each.

    Raises:
        error: It is no JSON, or is refused.
    """

    def refuse(constant: str) -> float:
        raise error(f"{name}{_first(text, constant)}: is no JSON: {constant} is no number")

    doubled: list[tuple[dict[str, Any], str]] = []

    def pairs(items: list[tuple[str, Any]]) -> dict[str, Any]:
        found = dict(items)
        if len(found) < len(items):
            twice = sorted(key for key, times in Counter(key for key, _ in items).items() if times > 1)
            doubled.extend((found, key) for key in twice)
        return found

    try:
        data = json.loads(text, parse_constant=refuse if finite else None, object_pairs_hook=pairs if single else None)
    except json.JSONDecodeError as fault:
        raise error(f"{name}:{fault.lineno}:{fault.colno}: is no JSON: {fault.msg}") from None
    except RecursionError:
        raise error(f"{name}{_too_deep(text)}: is nested too deeply: {holds}") from None
    except ValueError:  # json's own is above
        start = start_of_too_long(text, _STRING)
        where = "" if start is None else _lines(text, [start])[start]
        raise error(f"{name}{where}: {TOO_LONG}") from None
    document = Document(name, data, text)
    if doubled:
        raise error("\n".join(document.told(list(_doubled(data, doubled)))))
    return document


def _doubled(data: object, doubled: Sequence[tuple[dict[str, Any], str]]) -> Iterator[Mistake]:
    """A mistake for each key that an object has twice, at the last one; the object's place is told if it has one."""
    where = dict(_objects(data))
    for found, key in doubled:
        place = (*where[id(found)], key) if id(found) in where else ()
        yield Mistake(place, f"the key {key!r:.60} is given twice in one object: once would be right", at_key=True)


def _objects(data: object) -> Iterator[tuple[int, Keys]]:
    """The identity and the keys of every object in a document."""
    todo: list[tuple[Keys, object]] = [((), data)]
    while todo:
        keys, value = todo.pop()
        if isinstance(value, dict):
            yield id(value), keys
            todo += [((*keys, key), inner) for key, inner in value.items()]
        elif isinstance(value, list):
            todo += [((*keys, i), inner) for i, inner in enumerate(value) if isinstance(inner, (dict, list))]


# -- places in the text ------------------------------------------------------------------------------------------------

Wanted = dict[str | int, Any]
"""A tree of the keys that are looked for."""


def places(text: str, mistakes: Sequence[Mistake]) -> list[str]:
    """``:12:7``, line and column of each, from 1: of its value, or of the nearest thing around it.

    The text, which is JSON, is walked once; of namesakes in an object the last one counts, as for ``json``.
    """
    wanted: Wanted = {}
    for mistake in mistakes:
        branch = wanted
        for step in mistake.place:
            branch = branch.setdefault(step, {})
    found: dict[Keys, tuple[int, int]] = {}
    _walked(text, 0, wanted, (), found)
    starts = [_start(found, mistake) for mistake in mistakes]
    lines = _lines(text, sorted(set(starts)))
    return [lines[start] for start in starts]


def _start(found: dict[Keys, tuple[int, int]], mistake: Mistake) -> int:
    place = mistake.place
    while place not in found:
        place = place[:-1]
    value, key = found[place]
    return key if mistake.at_key and place == mistake.place else value


def _lines(text: str, starts: Iterable[int]) -> dict[int, str]:
    """Line and column of ascending places in a text."""
    line, before, found = 1, 0, {}
    for start in starts:
        line += text.count("\n", before, start)
        before = start
        found[start] = f":{line}:{start - text.rfind(chr(10), 0, start)}"
    return found


def _after(text: str, at: int) -> int:
    """The next place that is no white space."""
    space = _SPACE.match(text, at)
    return space.end() if space else at


def _walked(text: str, at: int, wanted: Wanted, here: Keys, found: dict[Keys, tuple[int, int]]) -> int:
    """Note where the value at a place, and what is wanted in it, begins, and return where it ends."""
    at = _after(text, at)
    found[here] = at, found.get(here, (at, at))[1]
    if not wanted or text[at] not in "{[":
        return int(_decoded(text, at)[1])
    close, count = "}" if text[at] == "{" else "]", 0
    at = _after(text, at + 1)
    while text[at] != close:
        step: str | int = count
        start = at
        if close == "}":
            step, at = _decoded(text, at)
            at = _after(text, _after(text, at) + 1)
        if step in wanted:
            found[*here, step] = at, start
            at = _walked(text, at, wanted[step], (*here, step), found)
        else:
            at = _decoded(text, at)[1]
        at = _after(text, at)
        at = _after(text, at + 1) if text[at] == "," else at
        count += 1
    return at + 1


def _first(text: str, pattern: str) -> str:
    """Line and column of the first match outside of texts; '' where there is none."""
    for match in re.finditer(f"{_STRING}|({pattern})", text):
        if match[1] is not None:
            return _lines(text, [match.start()])[match.start()]
    return ""


def _too_deep(text: str) -> str:
    """Line and column of the bracket at which a text is nested deeper than ``DEEPEST``; '' where none is."""
    depth = 0
    for match in re.finditer(rf"{_STRING}|([\[{{])|([\]}}])", text):
        depth += (match[1] is not None) - (match[2] is not None)
        if depth > DEEPEST:
            return _lines(text, [match.start()])[match.start()]
    return ""
