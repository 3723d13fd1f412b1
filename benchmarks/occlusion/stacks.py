"""Connected bodies of blocks that stand in rows along the lines of sight.

Their occlusion relations can be read off exactly.

A *stack* is a grid over a piece of the image, U x V squares, with L layers of depth behind each square; a body is a set
of its blocks that is connected by faces. As a solid a block is a frustum, its sides in planes through the camera's
centre: the image of a body is exactly the union of its squares, and of two bodies the one in the nearer layer is first.
Bodies of one grid share no volume (A4), and may be concave, interlocked, nested in the image, and of equal silhouettes.

``Grids`` (B, U, V, L) of small numbers: 0 nobody's, 1, 2, ... the body whose block it is.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from geometry.visibility.roc import ROC20, Front, Roc, roc

if TYPE_CHECKING:
    from collections.abc import Iterator

    from numpy.typing import NDArray

    from geometry.visibility.roc import Rcc8

    Grids = NDArray[np.int8]
    Masks = NDArray[np.bool_]

SIDE, LAYERS = 6, 4
MUTUAL = ROC20.index("mutually_occludes_po")
"""Where the mutual relations begin."""
STEPS = 9
"""Rounds of growth."""


def grown(
    rng: np.random.Generator, count: int, bodies: int = 3, side: int = SIDE, layers: int = LAYERS
) -> Iterator[Grids]:
    """Grids (count, side, side, layers) of connected bodies as they grow, each within an image of its own.

    After some rounds, and full-grown.
    """
    masks = masks_of(rng, count, bodies, side)
    grids = np.zeros((count, side, side, layers), dtype=np.int8)
    for body in range(bodies):
        _sow(rng, grids, masks[:, body], body + 1)
    greed = rng.choice([0.15, 0.4, 0.9], (count, bodies))
    deep = rng.choice([0.0, 0.3, 1.0], (count, bodies))
    for step in range(STEPS):
        for body in rng.permutation(bodies):
            reached = _beside(grids == body + 1, rng.random((count, 1, 1, 1)) < deep[:, body, None, None, None])
            wanted = reached & (grids == 0) & masks[:, body, :, :, None]
            grids[wanted & (rng.random(grids.shape) < greed[:, body, None, None, None])] = body + 1
        if step in (1, 3, STEPS - 1):
            yield grids.copy()


def _sow(rng: np.random.Generator, grids: Grids, mask: Masks, body: int) -> None:
    """One block of the body in each grid, in its mask, where nobody stands (there is none where nothing is free)."""
    chance = np.where((grids == 0) & mask[..., None], rng.random(grids.shape), -1.0).reshape(len(grids), -1)
    place = chance.argmax(axis=1)
    rows = np.flatnonzero(chance[np.arange(len(grids)), place] >= 0)
    grids.reshape(len(grids), -1)[rows, place[rows]] = body


def _beside(mine: Masks, along: Masks) -> Masks:
    """The blocks that share a face with one of the body's; those before and behind only where ``along``."""
    found = np.zeros_like(mine)
    for axis in (1, 2, 3):
        here, there = [slice(None)] * 4, [slice(None)] * 4
        here[axis], there[axis] = slice(1, None), slice(None, -1)
        allowed = along if axis == 3 else np.ones_like(along)
        found[tuple(here)] |= mine[tuple(there)] & allowed
        found[tuple(there)] |= mine[tuple(here)] & allowed
    return found


def clamps(rng: np.random.Generator, count: int, side: int = 9) -> Grids:
    """(count, side, side, 7) two bodies that reach round each other and have room to move.

    A clamp, 2, and what it holds, 1.

    The clamp has a plate in front and one at the back, and a pillar between them; the other a plate between those two,
    one behind both, and a pillar that leads through a hole of the clamp's back plate, which its front plate covers. One
    square is free round each pillar.
    """
    made: list[Grids] = []
    while len(made) < count:
        grid = _clamp(rng, side)
        if grid is not None and one_piece(grid == 1) and one_piece(grid == 2) and codes(grid[None], 1, 2)[0] >= MUTUAL:
            made.append(grid)
    return np.stack(made)


def _clamp(rng: np.random.Generator, side: int) -> Grids | None:
    pillars = np.zeros((2, side, side), dtype=bool)
    for pillar, place in zip(pillars, rng.integers(1, side - 1, (2, 2)), strict=True):
        pillar[tuple(place)] = True
    mine, theirs = pillars
    if (widened(mine) & widened(theirs)).any():
        return None
    front, back, between, behind = boxes(rng, 4, side)
    front |= widened(mine)
    clamp = front | (back & ~widened(mine)) | theirs
    kinds = (behind, clamp, _shrunk(clamp), widened(clamp))
    kind = int(rng.integers(len(kinds)))
    behind = kinds[kind] | mine
    between = (between & ~widened(theirs) & (clamp | (kind in (0, 3)))) | mine
    grid = np.zeros((side, side, 7), dtype=np.int8)
    for layer, squares in (
        (0, front | theirs),
        (4, (back & ~widened(mine)) | theirs),
        (1, theirs),
        (2, theirs),
        (3, theirs),
    ):
        grid[squares, layer] = 2
    for layer, squares in ((2, between), (6, behind), (3, mine), (4, mine), (5, mine)):
        grid[squares, layer] = 1
    return grid


def masks_of(rng: np.random.Generator, count: int, bodies: int, side: int) -> Masks:
    """(count, bodies, side, side) the image that each body may fill.

    Boxes of their own, or another's, one's within it, or round it.
    """
    masks = np.zeros((count, bodies, side, side), dtype=bool)
    for body in range(bodies):
        own = boxes(rng, count, side)
        own |= boxes(rng, count, side) & (rng.random((count, 1, 1)) < 0.3)
        masks[:, body] = own
        if body:
            other = masks[np.arange(count), rng.integers(0, body, count)]
            kinds = (own, other, _shrunk(other), widened(other), other & own, other | own, own & ~other)
            kind = rng.choice(len(kinds), count, p=[0.2, 0.25, 0.15, 0.1, 0.1, 0.1, 0.1])
            masks[:, body] = np.stack(kinds)[kind, np.arange(count)]
    shuffled = rng.permuted(np.broadcast_to(np.arange(bodies), (count, bodies)), axis=1)
    return masks[np.arange(count)[:, None], shuffled]


def boxes(rng: np.random.Generator, count: int, side: int) -> Masks:
    """(count, side, side) a box of squares each."""
    low, high = np.sort(rng.integers(0, side, (2, count, 2)), axis=0)
    steps = np.arange(side)
    across, down = ((steps >= low[:, i, None]) & (steps <= high[:, i, None]) for i in range(2))
    return np.asarray(across[:, :, None] & down[:, None, :])


def widened(squares: Masks) -> Masks:
    """The squares (..., U, V) and those that share a corner with one."""
    wide = np.pad(squares, [(0, 0)] * (squares.ndim - 2) + [(1, 1), (1, 1)])
    across = wide[..., 1:-1, :] | wide[..., 2:, :] | wide[..., :-2, :]
    return np.asarray(across[..., 1:-1] | across[..., 2:] | across[..., :-2])


def _shrunk(squares: Masks) -> Masks:
    return ~widened(~squares)


def one_piece(blocks: Masks) -> bool:
    """Whether the squares or blocks hang together by their sides, and there are some."""
    from scipy.ndimage import label

    return int(label(blocks)[1]) == 1


def codes(grids: Grids, x: int, y: int) -> NDArray[np.int8]:
    """(B,) the exact relation of body ``x`` to body ``y`` as an index into ROC20.

    -1 where one of the two is not there.
    """
    mine, theirs = grids == x, grids == y
    image_x, image_y = mine.any(axis=-1), theirs.any(axis=-1)
    common = image_x & image_y
    nearer = mine.argmax(axis=-1) - theirs.argmax(axis=-1)
    bits = [
        common.any(axis=(1, 2)),
        (image_x & ~image_y).any(axis=(1, 2)),
        (image_y & ~image_x).any(axis=(1, 2)),
        (widened(image_x) & image_y).any(axis=(1, 2)),
        (widened(image_x) & ~image_y).any(axis=(1, 2)) | _on_border(image_x, image_y),
        (widened(image_y) & ~image_x).any(axis=(1, 2)) | _on_border(image_y, image_x),
        (common & (nearer < 0)).any(axis=(1, 2)),
        (common & (nearer > 0)).any(axis=(1, 2)),
    ]
    there = image_x.any(axis=(1, 2)) & image_y.any(axis=(1, 2))
    return np.where(there, _TABLE[sum(bit.astype(int) << i for i, bit in enumerate(bits))], -1).astype(np.int8)


def _on_border(inner: Masks, outer: Masks) -> Masks:
    """(B,) whether a square of ``inner`` lies on the grid's border: what is beyond it is outside of all images."""
    edge = np.ones(inner.shape[1:], dtype=bool)
    edge[1:-1, 1:-1] = False
    return np.asarray((inner & edge).any(axis=(1, 2)) & outer.any(axis=(1, 2)))


def _relation(bits: int) -> Roc:
    overlap, x_out, y_out, touch, x_near_edge, y_near_edge, x_first, y_first = (bool(bits >> i & 1) for i in range(8))
    if not overlap:
        return roc("EC" if touch else "DC", "nobody")
    fronts: dict[tuple[bool, bool], Front] = {(True, False): "x", (False, True): "y"}
    term: Rcc8
    if x_out == y_out:
        term = "PO" if x_out else "EQ"
    elif y_out:
        term = "TPP" if x_near_edge else "NTPP"
    else:
        term = "TPPi" if y_near_edge else "NTPPi"
    return roc(term, fronts.get((x_first, y_first), "both"))


_TABLE = np.array([ROC20.index(_relation(bits)) for bits in range(256)], dtype=np.int8)
