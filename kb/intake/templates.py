"""Templates of robot descriptions: what xacro or roslaunch fills in, where nobody has.

* ``unfilled(path, text)``: what to tell of the first such thing of which a shape would be read
"""

import re
from contextlib import suppress
from pathlib import Path
from shlex import quote
from typing import NamedTuple
from xml.parsers import expat

from geometry.files.xml_files import without_declaration

_SUBSTITUTION = re.compile(r"(file://)?\$\([a-z]+\b[^)$]*\)|\$\{[^}$]*\}")
"""Of one within another, the inner one; so no text is read twice."""
_PACKAGE = re.compile(r"(?:file://)?\$\(find\s+([^\s)]+)\s*\)")
_TEMPLATE = re.compile(r"\$[({]|<xacro:")
"""What every template has, somewhere."""
FILES = frozenset({"filename", "uri"})
"""Attributes (URDF) and elements (SDF) that name files."""
READ = FILES | {"xyz", "rpy", "pose", "size", "radius", "length", "scale", "rgba"}
"""Attributes and elements of which shapes are read. A name may be anything."""
UNREAD = frozenset({"axis", "collision", "gazebo", "inertial", "plugin", "ros2_control", "sensor", "transmission"})
"""Elements below the root of which nothing is read."""


class _Found(NamedTuple):
    """``what``: a substitution in an attribute or element called ``key``, or the begin of an element, without one.

    ``at``: where its element or text begins, bytes.
    """

    key: str
    what: str
    at: int


def unfilled(path: Path, text: str) -> str | None:
    """Where a shape would be read of something that xacro or roslaunch fills in: what it is, and what to do."""
    if not _TEMPLATE.search(text) or "<!DOCTYPE" in text or "<!ENTITY" in text:
        return None
    plain = without_declaration(text)
    found = _first(plain)
    if found is None:
        return None
    begin = len(plain.encode()[: found.at].decode())
    at = max(plain.find(found.what, begin), begin)
    return f"{path}:{plain.count(chr(10), 0, at) + 1}:{at - plain.rfind(chr(10), 0, at)}: {_told(path, found)}"


def _told(path: Path, found: _Found) -> str:
    package = _PACKAGE.fullmatch(found.what)
    if package and found.key in FILES:
        how = f"write package://{package[1]:.60} in its place, for no absolute path, as they would write, is read"
    else:
        filled = path.with_name(f"{path.stem}_filled{path.suffix}")
        how = f"run xacro first, and import what it writes: xacro {quote(str(path))} > {quote(str(filled))}"
    shown = found.what if found.key else f"{found.what}>"
    return f"{' '.join(shown.split()):.80} is for xacro or roslaunch to fill in: {how}"


def _first(text: str) -> _Found | None:
    """The first start of an element of xacro's, or substitution in what is read, as far as the text is XML."""
    tags, found, parser = list[str](), list[_Found](), expat.ParserCreate()
    unread = 0

    def seek(key: str, words: str) -> None:
        if key in READ and not (unread or found) and (some := _SUBSTITUTION.search(words)):
            found.append(_Found(key, some[0], parser.CurrentByteIndex))

    def start(tag: str, attributes: dict[str, str]) -> None:
        nonlocal unread
        unread += bool(tags) and tag in UNREAD
        tags.append(tag)
        if tag.startswith("xacro:") and not (unread or found):
            found.append(_Found("", f"<{tag}", parser.CurrentByteIndex))
        for key, words in attributes.items():
            seek(key, words)

    def end(tag: str) -> None:
        nonlocal unread
        tags.pop()
        unread -= bool(tags) and tag in UNREAD

    parser.StartElementHandler, parser.EndElementHandler = start, end
    parser.CharacterDataHandler = lambda words: seek(tags[-1], words)
    with suppress(expat.ExpatError):  # who reads it tells that
        parser.Parse(text, True)  # noqa: FBT003 - it takes no names
    return next(iter(found), None)
