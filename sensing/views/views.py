"""What the outline, the creases and the colours of a painted mesh look like from all around.

A view is seen from ``FROM`` diameters away, in units of the diameter, x right, y down, from the middle of its box. It
has ``FEATURES`` features at most: places on its outline with the direction inward, places on inner edges with the
direction across, places inside with the colour there, and places outside, with the colour of the rim beside them.

* ``Views``: those of one type, as arrays; ``views_of(paint, number)``
"""

from typing import NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from geometry.arrays import Floats, Indices, Ints
from geometry.cones import even_directions
from geometry.frames import look_at
from sensing.pixels.drawn import Drawn, Paint
from sensing.pixels.photo import DULLED, SAMPLES, lab_of, nearest, palette_of

FROM, WIDE = 6.0, 160
"""Diameters away, and pixels that the diameter is drawn with."""
RIM = 20
"""Pixels around it."""
OUTLINE, INNER, INSIDE, OUTSIDE = range(4)
"""Kinds of features."""
MOST = 56, 32, 40, 32
"""Features of each kind at most."""
FEATURES = sum(MOST)
NOTHING = -1
"""The kind of what fills up."""
COLOURS = 6
"""Of a type's palette."""
BESIDE = 6
"""Neighbours of a view on the sphere."""


class Views(NamedTuple):
    """V views with F features: ``at`` (V, F, 2) diameters; ``kind`` (V, F); ``angle`` (V, F) rad, across an edge.

    ``colour`` (V, F) of the palette; ``turn`` (V, 3, 3) camera from object; ``beside`` (V, ``BESIDE``) the views next
    to each; ``palette`` (k, 3) Lab, and the ``share`` (k,) of the surface that has each.
    """

    at: NDArray[np.float32]
    kind: NDArray[np.int8]
    angle: NDArray[np.float32]
    colour: NDArray[np.int16]
    turn: Floats
    beside: Indices
    palette: NDArray[np.float32]
    share: Floats


def views_of(paint: Paint, number: int) -> Views:
    """So many views, evenly from all around."""
    turns = np.stack([look_at(way, np.zeros(3))[:3, :3] for way in even_directions(number)])
    size, focal = WIDE + 2 * RIM, WIDE * FROM
    K = np.array([[focal, 0.0, size / 2 - 0.5], [0.0, focal, size / 2 - 0.5], [0.0, 0.0, 1.0]])
    seen = []
    for turn in turns:
        pose = np.eye(4)
        pose[:3, :3] = turn
        pose[:3, 3] = np.array([0.0, 0.0, FROM * paint.diameter]) - turn @ paint.middle
        seen.append(_features(paint.drawn(pose, K, (size, size)), paint.diameter))
    inside = np.concatenate([lab[kind == INSIDE] for _, kind, _, lab in seen])
    palette = palette_of((inside * DULLED)[:: max(1, len(inside) // SAMPLES)], COLOURS)
    share = np.bincount(nearest(inside * DULLED, palette), minlength=len(palette)) / len(inside)
    at, kind = np.zeros((number, FEATURES, 2), np.float32), np.full((number, FEATURES), NOTHING, np.int8)
    angle, colour = np.zeros((number, FEATURES), np.float32), np.zeros((number, FEATURES), np.int16)
    for v, (places, kinds, angles, lab) in enumerate(seen):
        n = len(places)
        at[v, :n], kind[v, :n], angle[v, :n] = places, kinds, angles
        colour[v, :n] = nearest(lab * DULLED, palette)
    ways = turns[:, 2]
    beside = np.argsort(-(ways @ ways.T), axis=1, kind="stable")[:, 1 : BESIDE + 1]
    return Views(at, kind, angle, colour, turns, beside, palette / DULLED, share)


def _features(drawn: Drawn, diameter: float) -> tuple[Floats, Ints, Floats, NDArray[np.float32]]:
    """Places (N, 2), kinds (N,), angles (N,), colours (N, 3) Lab of one view."""
    whole = drawn.mask.astype(np.uint8)
    mask = np.asarray(cv2.morphologyEx(whole, cv2.MORPH_CLOSE, np.ones((3, 3), np.uint8)), np.uint8)
    smooth = np.asarray(cv2.GaussianBlur(mask.astype(np.float32), (0, 0), 2.0), np.float32)
    share = cv2.GaussianBlur(drawn.mask.astype(np.float32), (0, 0), 2.0)[..., None] + 1e-6
    lab = lab_of(cv2.GaussianBlur(drawn.colour, (0, 0), 2.0) / share)
    rim, inward = _outline(mask, smooth)
    within = np.clip(np.rint(rim + 5.0 * inward).astype(int), 0, len(mask) - 1)
    beyond = rim - 8.0 * inward
    out = np.clip(np.rint(beyond).astype(int), 0, len(mask) - 1)
    some = _evenly(len(rim), MOST[OUTSIDE])
    some = some[smooth[out[some, 1], out[some, 0]] < 0.2]
    inner, across = _inner(drawn, mask, diameter)
    body = _spread(mask)
    parts = [
        (rim, OUTLINE, np.arctan2(inward[:, 1], inward[:, 0]), lab[within[:, 1], within[:, 0]]),
        (inner, INNER, across, lab[inner[:, 1], inner[:, 0]]),
        (body, INSIDE, np.zeros(len(body)), lab[body[:, 1], body[:, 0]]),
        (beyond[some], OUTSIDE, np.zeros(len(some)), lab[within[some, 1], within[some, 0]]),
    ]
    places = (np.concatenate([part[0] for part in parts]) - (len(mask) / 2 - 0.5)) / WIDE
    kinds = np.concatenate([np.full(len(part[0]), part[1]) for part in parts])
    return places, kinds, np.concatenate([part[2] for part in parts]), np.concatenate([part[3] for part in parts])


def _outline(mask: NDArray[np.uint8], smooth: NDArray[np.float32]) -> tuple[Ints, Floats]:
    """(N, 2) pixels evenly along the outlines, holes' as well, and (N, 2) unit vectors inward."""
    curves = cv2.findContours(mask, cv2.RETR_CCOMP, cv2.CHAIN_APPROX_NONE)[0]
    every = np.concatenate([curve[:, 0] for curve in curves if len(curve) > 25] or [np.zeros((0, 2), np.int32)])
    rim = every[_evenly(len(every), MOST[OUTLINE])]
    slope = np.stack([cv2.Sobel(smooth, cv2.CV_32F, *way)[rim[:, 1], rim[:, 0]] for way in ((1, 0), (0, 1))], axis=1)
    return rim, slope / np.maximum(np.linalg.norm(slope, axis=1, keepdims=True), 1e-9)


STRONG = 0.04
"""Least change a pixel of an inner edge: of 80 grey levels, of the unit normal, of a sixth of a diameter in depth."""
CELL = 8
"""Pixels; of each cell the strongest place is an inner edge's."""


def _inner(drawn: Drawn, mask: NDArray[np.uint8], diameter: float) -> tuple[Ints, Floats]:
    """(N, 2) pixels where colour, facing or depth change most within the outline, and (N,) rad across."""
    there = drawn.mask
    share = cv2.GaussianBlur(there.astype(np.float32), (0, 0), 1.5)[..., None] + 1e-6
    far = np.where(there, drawn.depth, drawn.depth[there].max(initial=0.0)).astype(np.float32)
    layers = np.concatenate(
        [
            cv2.GaussianBlur(drawn.colour, (0, 0), 1.5) / share / 80.0,
            cv2.GaussianBlur(drawn.normal.astype(np.float32), (0, 0), 1.5),
            cv2.GaussianBlur(far, (0, 0), 1.5)[..., None] * (6.0 / diameter),
        ],
        axis=2,
    )
    a, b = (
        np.dstack([cv2.Sobel(layers[..., k], cv2.CV_32F, *way) / 8.0 for k in range(7)]) for way in ((1, 0), (0, 1))
    )
    xx, yy, xy = (a * a).sum(axis=2), (b * b).sum(axis=2), (a * b).sum(axis=2)
    inside = cv2.erode(mask, np.ones((11, 11), np.uint8), borderValue=0) > 0
    steep = np.where(inside, np.sqrt(xx + yy), 0.0)
    cells = (
        steep.reshape(len(mask) // CELL, CELL, len(mask) // CELL, CELL).transpose(0, 2, 1, 3).reshape(-1, CELL * CELL)
    )
    best, value = cells.argmax(axis=1), cells.max(axis=1)
    order = np.argsort(-value, kind="stable")[: MOST[INNER]]
    order = order[value[order] > STRONG]
    row, column = np.divmod(order, len(mask) // CELL)
    y, x = row * CELL + best[order] // CELL, column * CELL + best[order] % CELL
    return np.column_stack([x, y]), 0.5 * np.arctan2(2.0 * xy[y, x], (xx - yy)[y, x])


def _spread(mask: NDArray[np.uint8]) -> Ints:
    """(N, 2) pixels evenly inside."""
    body = cv2.erode(mask, np.ones((7, 7), np.uint8), borderValue=0)
    body = body if body.sum() > 50 else mask
    step = max(1, round(float(np.sqrt(body.sum() / MOST[INSIDE]))))
    y, x = np.nonzero(body[step // 2 :: step, step // 2 :: step])
    return np.column_stack([x, y])[_evenly(len(x), MOST[INSIDE])] * step + step // 2


def _evenly(number: int, most: int) -> Ints:
    """Which of so many, at most ``most``."""
    return np.linspace(0, number - 1, min(number, most)).astype(int)
