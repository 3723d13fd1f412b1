"""The files of a KB's folder, read within limits and never outside of it, with the mistakes met."""

import hashlib
import os.path
from dataclasses import dataclass, field
from pathlib import Path

from geometry.files.plain_files import fault_of
from kb.errors import KBError, Mistake
from kb.files.yaml_text import MAX_BYTES, Document, load


def shipped_names() -> list[str]:
    """Their names, sorted: ``["first", "lookalikes", "towers"]``."""
    return sorted(path.parent.name for path in Path(__file__).parents[1].glob("*/kb.yaml"))


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


@dataclass
class Folder:
    """The ``contents`` read so far, by relative path, and the ``mistakes`` found so far."""

    root: Path
    contents: dict[str, bytes] = field(default_factory=dict)
    mistakes: list[Mistake] = field(default_factory=list)

    def name(self, path: Path) -> str:
        """The path relative to the folder, without ``..``."""
        return Path(os.path.relpath(path, self.root)).as_posix()

    def fault(self, path: Path, limit: int) -> str | None:
        """What forbids to read a file, if anything."""
        if not Path(os.path.realpath(path)).is_relative_to(os.path.realpath(self.root)):
            return "leads out of the knowledge base's folder"
        return fault_of(path, limit)

    def content(self, path: Path, limit: int = MAX_BYTES) -> bytes | None:
        """A file's bytes; None, and a mistake, where they cannot be had."""
        fault = self.fault(path, limit)
        if fault is None:
            try:
                return self.contents.setdefault(self.name(path), path.read_bytes())
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
