"""Expected, D7, as one function.

The generated program states it once more, as rules (``plogic.scene.text.rules.EXPECTED``), tested equal.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple, Protocol, overload

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Flags = NDArray[np.bool_]


class Seen(NamedTuple):
    """What geometry says of F features: in the image, in a lobe, Behind their own host; each (F,)."""

    in_image: Flags
    in_lobe: Flags
    self_hidden: Flags


class _OneSeen(Protocol):
    @property
    def in_image(self) -> bool: ...
    @property
    def in_lobe(self) -> bool: ...
    @property
    def self_hidden(self) -> bool: ...


class _AllSeen(Protocol):
    @property
    def in_image(self) -> Flags: ...
    @property
    def in_lobe(self) -> Flags: ...
    @property
    def self_hidden(self) -> Flags: ...


@overload
def expected(seen: _OneSeen, opaque: bool) -> bool: ...  # noqa: FBT001 - a truth value of D7
@overload
def expected(seen: _OneSeen, opaque: bool, hidden: Flags) -> Flags: ...  # noqa: FBT001
@overload
def expected(seen: _AllSeen, opaque: bool, hidden: Flags | bool = False) -> Flags: ...  # noqa: FBT001, FBT002


def expected(seen: Any, opaque: bool, hidden: Any = False) -> Any:  # noqa: FBT001, FBT002
    """Return whether a feature is Expected in one world, or in several (D7): truth values, or arrays of them that broadcast.

    It projects into the image (``in_image``); the viewpoint is in one of its lobes (``in_lobe``); and it is not Behind
    any opaque object of the world, neither its own host (``self_hidden``, where the host is ``opaque``) nor another
    that is present and no rival (``hidden``).
    """
    return seen.in_image & seen.in_lobe & ((seen.self_hidden & opaque | hidden) ^ True)
