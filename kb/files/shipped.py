"""The knowledge bases that come with the package."""

from __future__ import annotations

from pathlib import Path

from kb.errors import KBError


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
