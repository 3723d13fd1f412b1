"""The files of a KB's folder, read within limits and never outside of it, with the mistakes met.

YAML becomes plain data safely: within limits, without tags, and with the place of everything.

Vocabulary: ``Document("kb.yaml", {"name": "towers"}, root, mistakes)``; ``document.place(("rates", "hit")) == (3, 8)``.
"""

import hashlib
import math
import os.path
import re
import warnings
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any

from ruamel.yaml import YAML
from ruamel.yaml.composer import MaxDepthExceededError
from ruamel.yaml.error import MarkedYAMLError, YAMLError
from ruamel.yaml.nodes import MappingNode, Node, ScalarNode, SequenceNode
from ruamel.yaml.resolver import VersionedResolver

from geometry.files.plain_files import fault_of, is_there
from geometry.files.side_files import LIMITS, is_lost, side_files
from kb.errors import KBError, Mistake
from kb.files.changes import CHANGE, is_changing

Keys = tuple[str | int, ...]
"""Keys and indices from the root of a document."""

MAX_BYTES = 16_000_000
"""Largest YAML file."""
MAX_NODES = 500_000
"""Most values of a document, those of an alias counted each time."""
SLOWLY_READ = 30_000
"""Characters of a text that ruamel's own parser is asked about, which reads some 50,000 a second."""
MAX_DEPTH = 60
"""Deepest nesting."""

_INTEGER = re.compile(r"[-+]?[0-9]+")
_FLOAT = re.compile(r"[-+]?(\.[0-9]+|[0-9]+(\.[0-9]*)?)([eE][-+]?[0-9]+)?")
_SPECIAL = {"true": True, "True": True, "false": False, "False": False, "null": None, "~": None, "": None}
_NOT_FINITE = re.compile(r"[-+]?\.(inf|Inf|INF)|\.(nan|NaN|NAN)")
_TAGS = {f"tag:yaml.org,2002:{name}" for name in ("str", "int", "float", "bool", "null", "timestamp", "merge", "value")}


@dataclass(frozen=True, eq=False)
class Document:
    """One YAML file: its plain ``data``, its node graph, and what was wrong with the text."""

    file: str
    data: Any
    root: Node | None
    mistakes: tuple[Mistake, ...]

    def place(self, path: Sequence[str | int], *, key: bool = False) -> tuple[int, int]:
        """Line and column, from 1, of the value at ``path`` (or its key), or of the nearest thing around it."""
        node, mark = self.root, self.root.start_mark if self.root is not None else None
        for depth, step in enumerate(path):
            found = self._child(node, step)
            if found is None:
                break
            name, node = found
            mark = name.start_mark if key and depth == len(path) - 1 else node.start_mark
        return (mark.line + 1, mark.column + 1) if mark is not None else (1, 1)

    def mistake(self, path: Sequence[str | int], message: str, *, key: bool = False) -> Mistake:
        """A mistake at ``path``."""
        line, column = self.place(path, key=key)
        return Mistake(self.file, line, column, dotted(path), message)

    def _child(self, node: Node | None, step: str | int) -> tuple[Node, Node] | None:
        if isinstance(node, MappingNode):
            if id(node) not in self._children:
                named = [
                    (name, value) for name, value in reversed(node.value) if isinstance(name, ScalarNode)
                ]  # of namesakes the first
                self._children[id(node)] = {name.value: (name, value) for name, value in named}
            return self._children[id(node)].get(step)
        if isinstance(node, SequenceNode) and isinstance(step, int) and step < len(node.value):
            return node.value[step], node.value[step]
        return None

    @cached_property
    def _children(self) -> dict[int, dict[str | int, tuple[Node, Node]]]:
        """The key and the value of each name, by the id of a mapping's node, of the mappings that were asked.

        A long one is not walked for each mistake.
        """
        return {}


def dotted(path: Sequence[str | int]) -> str:
    """``("parts", 1, "type")`` as ``parts.1.type``."""
    return ".".join(str(step) for step in path)


def load(file: str, content: bytes) -> Document:
    """Read a document; what is wrong with it stands in ``mistakes``, and its data is then what could be read."""
    if len(content) > MAX_BYTES:
        return _unread(file, f"{len(content)} bytes are more than the {MAX_BYTES} that a file may have")
    try:
        text = content.decode("utf-8-sig")
        root = _compose(text)
    except UnicodeDecodeError as error:
        return _unread(file, f"must be UTF-8: {error.reason}", content[: error.start].count(b"\n") + 1)
    except MarkedYAMLError as error:
        mark = error.problem_mark or error.context_mark
        line, column = (mark.line + 1, mark.column + 1) if mark else (1, 1)
        deep = isinstance(error, MaxDepthExceededError)
        why = f"nested deeper than {MAX_DEPTH} levels" if deep else f"no YAML: {error.problem or error.context}"
        return _unread(file, why, line, column)
    except (YAMLError, ValueError, AssertionError) as error:  # the last of a %YAML 1.23
        return _unread(file, f"no YAML: {(str(error) or type(error).__name__).splitlines()[0]}")
    builder = _Builder(file)
    data = builder.value(root, ()) if root is not None else None
    return Document(file, data, root, tuple(builder.mistakes))


def _unread(file: str, message: str, line: int = 1, column: int = 1) -> Document:
    return Document(file, None, None, (Mistake(file, line, column, "", message),))


class _Kinds(VersionedResolver):
    """Tags by the kind of node alone: what a plain scalar means is decided below, the same for both parsers."""

    def resolve(self, kind: object, value: object, implicit: object) -> object:  # noqa: ARG002 - ruamel's signature
        if kind is ScalarNode:
            return self.DEFAULT_SCALAR_TAG
        return self.DEFAULT_SEQUENCE_TAG if kind is SequenceNode else self.DEFAULT_MAPPING_TAG


def _compose(text: str) -> Node | None:
    """The node graph; by libyaml where it is there and the text cannot be nested deeply, as its composer recurses in C.

    What libyaml refuses is put to ruamel's own parser, so that the same texts are YAML with and without it; but for
    long ones, as that takes seconds.
    """
    if text.count("\n") + text.count(",") > MAX_NODES:
        raise YAMLError(f"more than {MAX_NODES} lines and commas")
    deep, short = _may_be_deep(text), len(text) <= SLOWLY_READ
    if deep and not short:
        raise YAMLError(f"too many brackets, or spaces before a line, for a file of more than {SLOWLY_READ} characters")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of anchors that are defined twice, which YAML permits
        if not short:
            return _composed(text, pure=False)
        if not deep:
            with suppress(YAMLError, ValueError):
                return _composed(text, pure=False)
        return _composed(text, pure=True)


def _composed(text: str, *, pure: bool) -> Node | None:
    yaml = YAML(typ="safe", pure=pure)
    yaml.Resolver = _Kinds
    yaml.max_depth = MAX_DEPTH + 1  # its scanner looks at each open bracket with every token
    root: Node | None = yaml.compose(text)
    return root


def _may_be_deep(text: str) -> bool:
    depth = deepest = 0
    for bracket in re.findall(r"[\[{\]}]", text):
        depth += 1 if bracket in "[{" else -1
        deepest = max(deepest, depth)
    indents = max((len(line) - len(line.lstrip(" -?")) for line in text.splitlines()), default=0)
    return deepest + 2 * indents > 1000


class _Builder:
    """Plain data of a node graph, and the mistakes met on the way."""

    def __init__(self, file: str) -> None:
        self.file = file
        self.mistakes: list[Mistake] = []
        self.count = 0
        self.above: set[int] = set()

    def report(self, node: Node, path: Keys, message: str) -> None:
        mark = node.start_mark
        self.mistakes.append(Mistake(self.file, mark.line + 1, mark.column + 1, dotted(path), message))

    def value(self, node: Node, path: Keys) -> object:
        self.count += 1
        if isinstance(node, ScalarNode):
            return self.scalar(node, path)
        if not self.may_enter(node, path):
            return None
        self.above.add(id(node))
        result = self.mapping(node, path) if isinstance(node, MappingNode) else self.sequence(node, path)
        self.above.discard(id(node))
        return result

    def may_enter(self, node: Node, path: Keys) -> bool:
        if id(node) in self.above:
            self.report(node, path, "A2: an alias makes this a part of itself")
        elif len(path) > MAX_DEPTH:
            self.report(node, path, f"nested deeper than {MAX_DEPTH} levels")
        elif self.count > MAX_NODES:
            if self.count != math.inf:
                self.report(node, path, f"more than {MAX_NODES} values, those of aliases counted each time")
            self.count = math.inf  # type: ignore[assignment]  # once is enough
        elif str(node.tag) not in ("tag:yaml.org,2002:map", "tag:yaml.org,2002:seq"):
            self.report(node, path, f"the tag {str(node.tag)[:60]} is not allowed")
        else:
            return True
        return False

    def sequence(self, node: Node, path: Keys) -> list[object]:
        return [self.value(item, (*path, index)) for index, item in enumerate(node.value)]

    def mapping(self, node: Node, path: Keys) -> dict[str, object]:
        result: dict[str, object] = {}
        for name, item in node.value:
            if not isinstance(name, ScalarNode):
                self.report(name, path, "a key must be a text")
            elif name.value in result:
                self.report(name, (*path, name.value), "this key was given before")
            else:
                result[self.whole(name, path)] = self.value(item, (*path, name.value))
        return result

    def scalar(self, node: ScalarNode, path: Keys) -> object:
        if str(node.tag) not in _TAGS:
            self.report(node, path, f"the tag {str(node.tag)[:60]} is not allowed")
            return None
        return self.whole(node, path) if node.style else self.plain(node, path)

    def whole(self, node: ScalarNode, path: Keys) -> str:
        """The text, two halves of a character (UTF-16, as JSON escapes it) made one; a half alone is a mistake."""
        text = str(node.value).encode("utf-16-le", "surrogatepass")
        try:
            return text.decode("utf-16-le")
        except UnicodeDecodeError:
            self.report(
                node,
                tuple(str(step).encode(errors="replace").decode() for step in path),
                "holds half of a character, \\ud800 to \\udfff",
            )
            return text.decode("utf-16-le", "replace")

    def plain(self, node: Node, path: Keys) -> object:
        text = node.value
        if text in _SPECIAL:
            return _SPECIAL[text]
        if _NOT_FINITE.fullmatch(text):
            self.report(node, path, f"must be finite, not {text}")
            return 0.0
        if len(text) <= 400 and _INTEGER.fullmatch(text):
            return int(text)
        return float(text) if _FLOAT.fullmatch(text) else text


def shipped_names() -> list[str]:
    """Their names, sorted: ``["first", "lookalikes", "paper", "towers"]``."""
    return sorted(path.parent.name for path in Path(__file__).parents[1].glob("*/kb.yaml"))


def parts_of(folder: str | Path) -> list[Path]:
    """The files and the folder that a knowledge base in a folder is made of, whether they are there or not."""
    return [Path(folder, name) for name in ("kb.yaml", "rules.pl", "words.npz", "objects")]


def shipped(name: str) -> Path:
    """The folder of a knowledge base inside the package: ``shipped("towers")``.

    Raises:
        KBError: for any other name, naming those that exist.
    """
    if name not in shipped_names():
        raise KBError(f"no knowledge base {name!r:.80} comes with plogic; these do: {', '.join(shipped_names())}")
    return Path(__file__).parents[1] / name


MAX_MESH_BYTES = 200_000_000
"""Largest mesh file."""


Stamp = tuple[int, int, int, int] | None
"""What changes when a file does: device, number, size and time; None where there is none."""


def _stamp(path: Path) -> Stamp:
    try:
        found = path.stat()
    except (OSError, ValueError):
        return None
    return found.st_dev, found.st_ino, found.st_size, found.st_mtime_ns


HALF_MOVED = (
    "a change was cut short, and what the mesh names is not all moved: whoever may write here runs plogic kb check"
)


@dataclass
class Folder:
    """The ``contents`` read so far, by relative path, and the ``mistakes`` found so far; ``kept``: for surfaces.

    ``rules``: what is read instead of ``rules.pl``; empty: as though there were none. ``stamps``: of all that was
    looked at, so that one can say whether it was the same all the time.
    """

    root: Path
    kept: Path | None = None
    rules: bytes | None = None
    contents: dict[str, bytes] = field(default_factory=dict)
    mistakes: list[Mistake] = field(default_factory=list)
    stamps: dict[Path, Stamp] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self._changing = is_changing(self.root)

    def name(self, path: Path) -> str:
        """The path relative to the folder, without ``..``."""
        return Path(os.path.relpath(path, self.root)).as_posix()

    def at(self, path: Path) -> Path:
        """Where a file or folder lies: what a change left that is in force and not moved yet comes first."""
        moved = self.root / CHANGE / self.name(path)
        found = moved if self._changing and is_there(moved) else path
        self.stamps.setdefault(found, _stamp(found))
        return found

    def is_split(self, folder: Path) -> bool:
        """Whether some of the files of a folder may be those of a change that are not moved yet."""
        return self._changing and is_there(self.root / CHANGE / self.name(folder))

    def is_as_it_was(self) -> bool:
        """Whether all that was looked at is still the same, so that it was read as it was at one moment."""
        same = all(_stamp(path) == stamp for path, stamp in self.stamps.items())
        return same and is_changing(self.root) == self._changing

    def listed(self, folder: Path) -> list[Path]:
        """What is in a folder, by the paths that it has there, in order."""
        changed = self.root / CHANGE / self.name(folder)
        self.stamps.setdefault(folder, _stamp(folder))
        inside = list(folder.iterdir()) if folder.is_dir() else []
        inside += [folder / path.name for path in changed.iterdir()] if self.is_split(folder) else []
        return sorted(set(inside))

    def fault(self, path: Path, limit: int) -> str | None:
        """What forbids to read a file, if anything."""
        path = self.at(path)
        if not Path(os.path.realpath(path)).is_relative_to(os.path.realpath(self.root)):
            return "leads out of the knowledge base's folder"
        return fault_of(path, limit)

    def content(self, path: Path, limit: int = MAX_BYTES) -> bytes | None:
        """A file's bytes; None, and a mistake, where they cannot be had."""
        fault = self.fault(path, limit)
        if fault is None:
            try:
                return self.contents.setdefault(self.name(path), self.at(path).read_bytes())
            except OSError as error:
                fault = f"cannot be read: {error.strerror}"
        self.mistakes.append(Mistake(self.name(path), 0, 0, "", f"the file {fault}"))
        return None

    def document(self, path: Path) -> Document | None:
        """A YAML file; its mistakes join the folder's."""
        content = self.content(path)
        document = load(self.name(path), content) if content is not None else None
        self.mistakes.extend(document.mistakes if document else ())
        return document

    def digest(self) -> str:
        """SHA-256 over the paths and contents of the files read, in the order of paths."""
        total = hashlib.sha256()
        for name, content in sorted(self.contents.items()):
            total.update(f"{name}\n{len(content)}\n".encode() + content)
        return total.hexdigest()

    def read_sides(self, path: Path, content: bytes) -> None:
        """Read the materials, pictures and buffers that a mesh file names, for they are among what the digest is over.

        One that leads out is a mistake; one that is missing is not, as the mesh may do without.
        """
        sides = side_files(path, content)
        if sides and self.is_split(path.parent):
            self.mistakes.append(Mistake(self.name(path), 0, 0, "", HALF_MOVED))
            return
        for side in sides:
            fault = side.fault or self.fault(side.place, LIMITS[side.kind])
            if fault is None:
                self.content(side.place, LIMITS[side.kind])
            elif not is_lost(side):
                self.mistakes.append(Mistake(self.name(path), 0, 0, "", f"the {side.kind} {side.name!r:.100} {fault}"))
