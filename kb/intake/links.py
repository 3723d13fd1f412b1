"""Parts named by the links of a robot description: which pieces of the joined surface are of which link.

* ``named(pieces, surface, source, scale)``: the pieces by their links' names, and the links that are one piece
* ``told_together(links)``: a note of such
"""

import re
from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from geometry.arrays import Floats, Indices
from kb.intake.source import Source
from kb.surfaces.pieces import Piece
from kb.surfaces.surface import Surface


def named(
    pieces: Sequence[Piece], surface: Surface, source: Source, scale: float
) -> tuple[list[Piece], list[list[str]]]:
    """Each piece by the links of which most is on it, ``base+upper`` where two hang together; and such links.

    A further piece of a link is ``base_2``; as they were where the ``source``, ``scale`` metres a unit, has no links.
    """
    links = list(dict.fromkeys(shape.name for shape in source.pieces))
    if "" in links:
        return list(pieces), []
    if not pieces:
        return [], [links][: len(links) > 1]
    vertices = np.concatenate([shape.vertices for shape in source.pieces]) * scale
    link = np.repeat([links.index(shape.name) for shape in source.pieces], [len(s.vertices) for s in source.pieces])
    votes = np.zeros((len(pieces), len(links)))
    np.add.at(votes, (_nearest(pieces, surface, vertices), link), 1)
    home = votes.argmax(axis=0)
    on = [[links[j] for j in np.flatnonzero(home == i)] for i in range(len(pieces))]
    names = ["+".join(some) or links[votes[i].argmax()] for i, some in enumerate(on)]
    return [replace(piece, name=name) for piece, name in zip(pieces, _apart(names), strict=True)], [
        some for some in on if len(some) > 1
    ]


TOLD = 4
"""Links that a note names, of those that are one part."""


def told_together(links: Sequence[str]) -> str:
    """A note that these links are one part."""
    named = ", ".join(name[:60] for name in links[:TOLD])
    more = f" and {len(links) - TOLD} more" if len(links) > TOLD else ""
    why = "their shapes touch, or some are too small for a part of their own"
    return f"the links {named}{more} are one part: {why}; what is to be a part of its own: write it in object.yaml"


def _nearest(pieces: Sequence[Piece], surface: Surface, vertices: Floats) -> Indices:
    """(N,) the piece of which a corner is nearest to each of ``vertices`` (N, 3) m."""
    from scipy.spatial import cKDTree

    corners = [np.unique(surface.triangles[piece.triangles]) for piece in pieces]
    owner = np.repeat(np.arange(len(pieces)), [len(some) for some in corners])
    return np.asarray(owner[cKDTree(surface.vertices[np.concatenate(corners)]).query(vertices)[1]], np.intp)


def _apart(names: Sequence[str]) -> Iterator[str]:
    """Names that a part may have, each once."""
    used = set[str]()
    for name in (re.sub(r"[/#\s]+", "_", name) for name in names):
        number, own = 1, name
        while own in used:
            number += 1
            own = f"{name}_{number}"
        used.add(own)
        yield own
