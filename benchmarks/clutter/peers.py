"""The peers of ``plogic bench clutter``.

Others' ways to find one object among typed appearances, each a function of the same shape.

* ``Peer``: ``Peer("poselib", "poselib", lo_ransac)``; ``PEERS`` are all, and who comes later is one more line there
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from importlib.util import find_spec
from typing import TYPE_CHECKING

from benchmarks.clutter.pairs import Answer
from benchmarks.clutter.quadruples import quadruples
from benchmarks.clutter.ransac import lo_ransac
from benchmarks.clutter.softposit import soft_posit

if TYPE_CHECKING:
    from kb.clouds.cloud import KnowledgeBase
    from sensing.appearance import Gamma

Ask = Callable[["KnowledgeBase", "Gamma", float], Answer | None]
"""What is there, found within so many seconds of the processor; None for nothing."""


@dataclass(frozen=True)
class Peer:
    """Its name in the table, short; the package that it needs ('' for none); how it is asked."""

    name: str
    package: str
    ask: Ask


PEERS = (Peer("quadruples", "", quadruples), Peer("SoftPOSIT", "", soft_posit), Peer("poselib", "poselib", lo_ransac))


def there(say: Callable[[str], None], peers: tuple[Peer, ...] = PEERS) -> tuple[Peer, ...]:
    """Those whose package is installed; a line on ``say`` of each other."""
    missing = [peer for peer in peers if peer.package and find_spec(peer.package) is None]
    for peer in missing:
        say(f"{peer.name}: left out, for the package {peer.package} is not installed")
    return tuple(peer for peer in peers if peer not in missing)
