"""How right a side of an edge looks: by its own colours, and by how bright it is against what is beyond the edge.

* ``colours_off(mine, its)``: how far the colours are off, as a share of what is right at most; 1 and more is not right
* ``contrasts_of(looks)``: how bright the edges of an image are against each other, which is what clutter is like
* ``looks_fit(mine, its)``: how much likelier such looks are of what is right than of what merely may be
"""

import numpy as np
from numpy.typing import NDArray

from geometry.arrays import Floats
from kb.clouds.words import COLOURS, SIDE

OFF = 40.0
"""Bytes by which the four colours may be off, together."""
NEAREST, LESS = 1.6, 1.25
"""How much likelier colours that are not off at all are of what is right, and how much less those that are all the way
off (development scenes)."""
NEUTRAL = (NEAREST - 1.0) / LESS
"""Off by so much, colours are as likely of what is right as of what merely may be."""
BRIGHT, EDGES = 6.0, 25.0
"""Standard deviations of contrast, bytes: of what is right besides how it varied when it was learned, and of the edges
of objects."""
USUAL, FEW = 45.0, 30.0
"""Standard deviation of contrast, bytes, of edges in images of which nothing is known; and how many such edges are
counted with an image's own."""
SMOOTH, LEAST = 5.0, 1e-3
"""Bytes by which the contrasts of an image's edges are smoothed, and the least density of them that is believed,
1/byte."""
WILD = 0.1
"""Share of what is right whose contrast is as that of any edge."""


def colours_off(mine: NDArray[np.float32], its: NDArray[np.uint8], *, coloured: bool) -> NDArray[np.float32]:
    """(N,) of appearances' looks (N, 6) and data's (N, 5).

    What says nothing either way where there are no colours to compare.
    """
    if not coloured:
        return np.full(len(its), NEUTRAL, np.float32)
    apart = its[:, :COLOURS].astype(np.float32) - mine[:, :COLOURS]
    return np.asarray(np.sqrt(np.einsum("ij,ij->i", apart, apart)) / np.float32(OFF))


def contrasts_of(looks: NDArray[np.uint8]) -> Floats:
    """(256,) density of each contrast, 1/byte, among an image's sides of looks (A, 5): what clutter there is like."""
    contrast = np.arange(256.0)
    prior = np.exp(-0.5 * ((contrast - 128.0) / USUAL) ** 2)
    own = np.exp(-0.5 * ((contrast[:, None] - contrast) / SMOOTH) ** 2)
    own /= own.sum(axis=0)
    seen = own @ np.bincount(looks[:, SIDE - 1], minlength=256) + FEW * prior / prior.sum()
    return np.asarray(np.maximum(seen / seen.sum(), LEAST))


def looks_fit(mine: NDArray[np.float32], its: NDArray[np.uint8], off: NDArray[np.float32], contrasts: Floats) -> Floats:
    """(N,) of those whose colours are ``off`` (N,) by less than 1, in an image of such ``contrasts`` (256,).

    What varied when it was learned as much as the edges of objects do has no mean of its own.
    """
    contrast = its[:, SIDE - 1].astype(float)
    spread = np.minimum(np.hypot(mine[:, SIDE].astype(float), BRIGHT), EDGES)
    middle = 128.0 + (mine[:, SIDE - 1] - 128.0) * (1.0 - (spread / EDGES) ** 2)
    own = np.exp(-0.5 * ((contrast - middle) / spread) ** 2) / (np.sqrt(2.0 * np.pi) * spread)
    return np.asarray((NEAREST - LESS * off) * ((1.0 - WILD) * own / contrasts[its[:, SIDE - 1]] + WILD))
