"""A knowledge base for Python.

Read once, made ready once, and used for any number of images, in several processes too.
"""

import os
from functools import lru_cache
from multiprocessing import parent_process
from pathlib import Path
from threading import Lock, active_count
from typing import Self

from kb.clouds.cloud import KnowledgeBase as Sigma
from plogic.base.errors import InputError
from plogic.face.session.blocks import Block, Column, Result, Table
from plogic.run.perceive import Perceiver, perceiver_of
from plogic.run.sources import kb_of

MOST_KEPT = 8
"""Knowledge bases that a process keeps of those which other processes sent it."""


class KnowledgeBase(Result):
    """What can exist: object types, detector statistics, priors and rules.

    A copy that another process receives reads the folder again, once for each process, and holds it to the digest.
    """

    def __init__(self, folder: str | Path) -> None:
        """Read a folder; ``"first"`` and ``"towers"`` stand for the shipped ones where no such folder exists.

        Raises:
            Error: telling every mistake of the folder, with file, line and column.
        """
        self._sigma: Sigma = kb_of(str(folder))
        here = Path(folder)
        self._folder = os.path.abspath(here) if here.exists() else str(folder)  # noqa: PTH100 - links stay as they are
        self._perceivers: dict[str, Perceiver] = {}
        self._lock = Lock()

    @classmethod
    def load(cls, folder: str | Path) -> Self:
        """Read a folder, or a shipped knowledge base by its name. Raises Error with every mistake of the folder."""
        return cls(folder)

    @property
    def name(self) -> str:
        """Its name."""
        return self._sigma.name

    @property
    def digest(self) -> str:
        """SHA-256 over the folder's contents."""
        return self._sigma.digest

    @property
    def types(self) -> tuple[str, ...]:
        """The names of its object types."""
        return tuple(t.name for t in self._sigma.types)

    @property
    def appearance_types(self) -> tuple[str, ...]:
        """The names of what detectors may report."""
        return tuple(self._sigma.appearance_types)

    @property
    def sigma(self) -> Sigma:
        """Σ itself, as the engine has it."""
        return self._sigma

    def ready(self, generator: str = "index") -> Self:
        """Make the search ready now, and not at the first image; processes that are forked afterwards share it.

        Returns itself.
        """
        self.perceiver(generator)
        return self

    def perceiver(self, generator: str = "index") -> Perceiver:
        """Return what interprets images, made at the first call. Raises InputError where there is no such generator."""
        with self._lock:
            if generator not in self._perceivers:
                alone = parent_process() is None and active_count() == 1
                self._perceivers[generator] = perceiver_of(self._sigma, generator, None if alone else 1)
            return self._perceivers[generator]

    def blocks(self) -> tuple[Block, ...]:
        """One table with a row each object type."""
        columns = (Column("object type"), Column("features", right=True), Column("feature types"), Column("learned"))
        rows = tuple(
            (t.name, str(len(t.features)), ", ".join(t.kind_codes[0][:8]), "yes" if t.learned is not None else "no")
            for t in self._sigma.types
        )
        return (Table(f"knowledge base {self.name}", columns, rows),)

    def __eq__(self, other: object) -> bool:
        return self.digest == other.digest if isinstance(other, KnowledgeBase) else NotImplemented

    def __hash__(self) -> int:
        return hash(self.digest)

    def __reduce__(self) -> tuple[object, ...]:
        return _again, (self._folder, self.digest)


@lru_cache(MOST_KEPT)
def _again(folder: str, digest: str) -> KnowledgeBase:
    """Return what another process had read; raises InputError where the folder has changed since."""
    kb = KnowledgeBase(folder)
    if kb.digest != digest:
        raise InputError(f"{folder}: has changed since the knowledge base was read")
    return kb
