"""The files of a KB's folder, read within limits and never outside of it, with the mistakes met.

Vocabulary: ``Document("kb.yaml", {"name": "towers"}, composed, mistakes)``;
``document.place(("rates", "hit")) == (3, 8)``.
"""

from __future__ import annotations

import hashlib
import os
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

from geometry.files.plain_files import fault_of, is_there
from geometry.files.side_files import LIMITS, is_lost, side_files
from kb.errors import KBError, Mistake
from kb.files.changes import CHANGE, is_changing

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from ruamel.yaml.nodes import Node

Keys = tuple[str | int, ...]
"""Keys and indices from the root of a document."""

MAX_BYTES = 16_000_000
"""Largest YAML file."""


@dataclass(frozen=True, eq=False)
class Document:
    """One YAML file: its plain ``data``, what gives its node graph, and what was wrong with the text."""

    file: str
    data: Any
    composed: Callable[[], Node | None]
    mistakes: tuple[Mistake, ...]

    @cached_property
    def root(self) -> Node | None:
        """The node graph, by which everything has a place."""
        return self.composed()

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
        from ruamel.yaml.nodes import MappingNode, ScalarNode, SequenceNode  # few documents have a mistake to place

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
    """The ``contents`` read so far, by relative path, and the ``mistakes`` found so far; ``kept``: for what was read.

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
        from kb.files.yaml_text import load  # what is kept is not read again

        content = self.content(path)
        document = load(self.name(path), content) if content is not None else None
        self.mistakes.extend(document.mistakes if document else ())
        return document

    def digest(self) -> str:
        """SHA-256 over the paths and contents of the files read, in the order of paths."""
        total = hashlib.sha256()
        for name, content in sorted(self.contents.items()):
            total.update(os.fsencode(f"{name}\n{len(content)}\n") + content)
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
