"""Marks on a raster picture, drawn with OpenCV: circles and squares, small signs, text that finds a free place.

``Pencil(picture, scale)`` takes places in the coordinates of the original image, whose pixel centres are integers, and
draws on ``picture``, which is ``scale`` times larger. Every mark has a dark casing, so that it is seen on light and on
dark ground.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

Colour = tuple[int, int, int]
Box = tuple[float, float, float, float]
"""Left, top, right, bottom in pixels of the drawn picture."""
Place = Sequence[float]
DARK, WHITE = (26, 23, 20), (255, 255, 255)
SHIFT = 4
"""OpenCV's fixed point: coordinates in sixteenths of a pixel."""
RING = 56
"""Points of a ring; divisible by its four sides and by its dashes."""
DASH, GAP = 9.0, 7.0
"""Of a dashed line, in pixels of the drawn picture."""
FONT = cv2.FONT_HERSHEY_DUPLEX
SIGNS: dict[str, tuple[tuple[tuple[int, int], ...], ...]] = {
    "patch": (((-4, -4), (4, -4), (4, 4), (-4, 4), (-4, -4)),),
    "l_junction": (((-3, -4), (-3, 4), (4, 4)),),
    "y_junction": (((0, 5), (0, 0), (-4, -4)), ((0, 0), (4, -4))),
    "arrow_junction": (((0, 5), (0, -5)), ((-4, -1), (0, -5), (4, -1))),
    "t_junction": (((-4, -4), (4, -4)), ((0, -4), (0, 5))),
    "corner": (((-4, 4), (-4, -4), (4, -4)),),
    "apex": (((-5, 4), (0, -4), (5, 4)),),
    "x_junction": (((-4, -4), (4, 4)), ((4, -4), (-4, 4))),
    "multi_junction": (((-5, 0), (5, 0)), ((0, -5), (0, 5)), ((-3, -3), (3, 3))),
}
OTHER = (
    (((0, -5), (5, 0), (0, 5), (-5, 0), (0, -5)),),
    (((0, -5), (5, 4), (-5, 4), (0, -5)),),
    (((0, 5), (5, -4), (-5, -4), (0, 5)),),
    (((-4, -4), (4, -4), (-4, 4), (4, 4), (-4, -4)),),
    (((-5, -2), (5, -2)), ((-5, 3), (5, 3))),
    (((-3, -5), (-3, 5)), ((3, -5), (3, 5)), ((-3, 0), (3, 0))),
    (((-4, -4), (4, -4), (-4, 4), (4, 4)),),
    (((-5, -4), (-2, 4), (0, -2), (2, 4), (5, -4)),),
)
"""Signs of types that we do not know by name."""
TINTS: tuple[Colour, ...] = (WHITE, (122, 226, 255), (255, 231, 155), (209, 179, 255))
"""White, yellow, cyan and pink: once every sign is used, they are used again in the next colour."""


def sign_of(kind: str, kinds: Sequence[str]) -> tuple[tuple[tuple[tuple[int, int], ...], ...], Colour]:
    """The strokes and the colour of a type's sign, its own among ``len(OTHER) * len(TINTS)`` unknown ones."""
    if kind in SIGNS:
        return SIGNS[kind], WHITE
    number = [name for name in kinds if name not in SIGNS].index(kind)
    return OTHER[number % len(OTHER)], TINTS[number // len(OTHER) % len(TINTS)]


@dataclass(frozen=True)
class Pencil:
    """Draws on ``picture`` (H, W, 3) BGR in place; ``scale`` is the picture's size over the original image's."""

    picture: NDArray[np.uint8]
    scale: float

    def at(self, uv: Place) -> tuple[float, float]:
        """Return the place in the drawn picture of an image point (integer = pixel centre in both)."""
        return (float(uv[0]) + 0.5) * self.scale - 0.5, (float(uv[1]) + 0.5) * self.scale - 0.5

    def stroke(self, line: Sequence[Place], colour: Colour, width: int, *, dashed: bool) -> None:
        """Draw a line through image points: whole, or in dashes."""
        points = np.array([self.at(p) for p in line])
        for piece in _dashed(points) if dashed else [points]:
            for paint, wide in ((DARK, width + (1 if dashed else width)), (colour, width)):
                self._line(piece, paint, wide)

    def dot(self, uv: Place, colour: Colour, *, circle: bool, filled: bool) -> None:
        """Draw the small mark of one of many features: a disc, a ring, or (no circle) a small square."""
        ring = _circle(3.4) if circle else _square(3)
        centre = np.array(self.at(uv))
        if filled:
            for paint, grow in ((DARK, 1.3), (colour, 1.0)):
                fixed = np.round((centre + grow * ring) * (1 << SHIFT)).astype(np.int32).reshape(-1, 1, 2)
                cv2.fillPoly(self.picture, [fixed], paint, cv2.LINE_AA, SHIFT)
        else:
            for paint, width in ((DARK, 3), (colour, 1)):
                self._line(centre + ring, paint, width)

    def side(self, uv: Place, angle: float, colour: Colour) -> None:
        """Draw the small mark of the side of an edge.

        A stroke along the edge and a tick at ``angle``, across it towards the side.
        """
        across = np.array([np.cos(angle), np.sin(angle)])
        along = np.array([-across[1], across[0]])
        centre, strokes = np.array(self.at(uv)), (np.stack([-5 * along, 5 * along]), np.stack([0 * across, 6 * across]))
        self._strokes([centre + stroke for stroke in strokes], colour, 4, 2)

    def cross(self, uv: Place, colour: Colour) -> None:
        """Draw the small mark of a side that was missed."""
        centre, arm = np.array(self.at(uv)), np.array([2.5, 2.5])
        self._strokes([centre + np.stack([-arm, arm]), centre + np.stack([-arm, arm]) * [1, -1]], colour, 3, 1)

    def foot(self, uv: Place, colour: Colour) -> None:
        """Draw the small mark of a place that something stands on: a cross in a flat ring."""
        centre = np.array(self.at(uv))
        ring = _circle(7) * [1.0, 0.45]
        arms = [np.array([[-4.0, 0.0], [4.0, 0.0]]), np.array([[0.0, -3.0], [0.0, 3.0]])]
        self._strokes([centre + part for part in (ring, *arms)], colour, 3, 1)

    def feature(self, uv: Place, colour: Colour, *, circle: bool, filled: bool) -> None:
        """Draw the mark of one feature: circle or square, filled or dashed. What is neither stays small."""
        centre, faint = np.array(self.at(uv)), not circle and not filled
        ring = _circle(10) if circle else _square(7 if faint else 9)
        if filled:
            self._tint(centre, ring, colour)
        for paint, width in ((DARK, 4 if faint else 6), (colour, 2 if faint else 3)):
            for piece in [ring] if filled else _dashes(ring, 7 if circle else 4):
                self._line(centre + piece, paint, width)

    def sign(self, uv: Place, kind: str, kinds: list[str]) -> None:
        """Draw the small sign of an appearance, by its type's place in ``kinds`` where we do not know its name."""
        centre, (strokes, colour) = np.array(self.at(uv)), sign_of(kind, kinds)
        for paint, width in ((DARK, 4), (colour, 2)):
            for stroke in strokes:
                self._line(centre + np.array(stroke, float), paint, width)

    def hatch(self, places: NDArray[np.bool_], colour: Colour) -> None:
        """Hatch the places (H, W) of the original image: lines from lower left to upper right, 10 pixels apart."""
        rows, columns = self.picture.shape[:2]
        wide = cv2.resize(places.astype(np.uint8), (columns, rows), interpolation=cv2.INTER_NEAREST) > 0
        across = np.add.outer(np.arange(rows), np.arange(columns)) % 10
        for paint, here in ((DARK, across < 4), (colour, (across > 0) & (across < 3))):
            self.picture[wide & here] = paint

    def mark_box(self, uv: Place) -> Box:
        """Return the box of a mark there."""
        x, y = self.at(uv)
        return x - 12, y - 12, x + 12, y + 12

    def size(self, text: str, size: float) -> tuple[float, float]:
        """Return width and height of a text in drawn pixels."""
        (width, height), _ = cv2.getTextSize(_plain(text), FONT, size, 1)
        return float(width), float(height)

    def text(self, text: str, box: Box, size: float, colour: Colour) -> None:
        """Write a text into its box, light on a dark casing (its own shape, grown: thicker letters are wider)."""
        mask = np.zeros(self.picture.shape[:2], np.uint8)
        origin = round(box[0]), round(box[3])
        cv2.putText(mask, _plain(text), origin, FONT, size, 255, 1, cv2.LINE_AA)
        x, y, wide, high = cv2.boundingRect(mask)
        here = slice(max(0, y - 2), y + high + 2), slice(max(0, x - 2), x + wide + 2)  # the casing is 2 pixels larger
        casing = cv2.dilate(mask[here], cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (5, 5)))
        for cover, paint in ((casing, DARK), (mask[here], colour)):
            share = cover[..., None] / np.float32(255)
            self.picture[here] = np.round(self.picture[here] * (1 - share) + np.array(paint, np.float32) * share)

    def _strokes(self, strokes: Sequence[NDArray[np.float64]], colour: Colour, casing: int, width: int) -> None:
        for paint, wide in ((DARK, casing), (colour, width)):
            for stroke in strokes:
                self._line(stroke, paint, wide)

    def _line(self, points: NDArray[np.float64], colour: Colour, width: int, *, closed: bool = False) -> None:
        fixed = np.round(points * (1 << SHIFT)).astype(np.int32).reshape(-1, 1, 2)
        cv2.polylines(self.picture, [fixed], closed, colour, width, cv2.LINE_AA, SHIFT)

    def _tint(self, centre: NDArray[np.float64], ring: NDArray[np.float64], colour: Colour) -> None:
        """Fill half transparently, so that the image and the sign stay visible."""
        x, y = (max(0, int(c) - 14) for c in centre)
        window = self.picture[y : y + 30, x : x + 30]
        if window.size:
            layer = window.copy()
            fixed = np.round((centre - [x, y] + ring) * (1 << SHIFT)).astype(np.int32).reshape(-1, 1, 2)
            cv2.fillPoly(layer, [fixed], colour, cv2.LINE_AA, SHIFT)
            window[:] = cv2.addWeighted(layer, 0.55, window, 0.45, 0)


def free_place(
    size: tuple[float, float], near: tuple[float, float], taken: list[Box], pencil: Pencil, *, needed: bool
) -> Box | None:
    """Return a box of that size close to an image point, inside the picture, that meets none of the taken boxes.

    Places above, beside and below are tried, then further away; None if there is no room. ``needed`` looks further.
    """
    (width, height), (x, y) = size, pencil.at(near)
    rows, columns = pencil.picture.shape[:2]
    for away in range(0, 400 if needed else 30, 10):
        for dx, dy in ((0, -1), (1, 0), (-1, 0), (0, 1), (1, -1), (-1, -1)):
            left = min(max(4.0, x - width / 2 + dx * (width / 2 + 18 + away)), columns - width - 4)
            top = min(max(4.0, y - height / 2 + dy * (height / 2 + 20 + away)), rows - height - 8)
            box = (left, top, left + width, top + height)
            if not any(meet(box, other) for other in taken):
                return box
    return None


def beside(size: tuple[float, float], own: Box, taken: list[Box], cover: NDArray[np.float64]) -> Box | None:
    """Return the box of that size about an object's box, in the picture, that covers least and is near.

    It meets none of the ``taken`` boxes; ``cover`` (H + 1, W + 1) is the integral of what should not be covered, 1 a
    pixel; None if there is no room.
    """
    (width, height), (left, top, right, bottom) = size, own
    rows, columns = (n - 1 for n in cover.shape)
    best: tuple[float, Box] | None = None
    for away in range(6, 200, 12):
        above, below = top - away - height, bottom + away
        places = [(x, y) for y in (above, below) for x in ((left + right - width) / 2, left, right - width)]
        beside = np.linspace(top, bottom - height, 4)
        places += [(x, y) for x in (right + away, left - away - width) for y in beside]
        for x, y in places:
            x, y = min(max(4.0, x), columns - width - 4), min(max(4.0, y), rows - height - 8)  # noqa: PLW2901
            box = (x, y, x + width, y + height)
            if any(meet(box, other) for other in taken) or x < 0 or y < 0:
                continue
            a, b, c, d = (int(side) for side in box)
            covered = float(cover[d, c] - cover[b, c] - cover[d, a] + cover[b, a]) / max(1.0, width * height)
            if best is None or away + 300.0 * covered < best[0] - 1e-9:
                best = away + 300.0 * covered, box
    return None if best is None else best[1]


def meet(a: Box, b: Box, margin: float = 3.0) -> bool:
    """Tell whether two boxes are closer than the margin."""
    return a[0] < b[2] + margin and b[0] < a[2] + margin and a[1] < b[3] + margin and b[1] < a[3] + margin


def _circle(radius: float) -> NDArray[np.float64]:
    angle = np.linspace(0, 2 * np.pi, RING + 1)
    return np.stack([np.cos(angle), np.sin(angle)], -1) * radius


def _square(half: float) -> NDArray[np.float64]:
    t = np.linspace(-1, 1, RING // 4 + 1)
    side = np.stack([t, np.full_like(t, -1.0)], -1)[:-1]
    turn = np.array([[0.0, 1.0], [-1.0, 0.0]])
    sides = [side @ np.linalg.matrix_power(turn, k) for k in range(4)]
    return np.concatenate([*sides, side[:1]]) * half


def _dashes(ring: NDArray[np.float64], count: int) -> list[NDArray[np.float64]]:
    """Return so many short pieces of a closed ring, each centred on a point of it; a square's four are its corners."""
    half = 3 if count == 4 else 2
    return [ring[np.arange(k - half, k + half + 1) % RING] for k in range(0, RING, RING // count)]


def _dashed(points: NDArray[np.float64]) -> list[NDArray[np.float64]]:
    """Return the pieces of a line that its dashes cover, the first from its start."""
    reach = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))])
    pieces = []
    for start in np.arange(0.0, reach[-1], DASH + GAP):
        inner = points[(reach > start) & (reach < start + DASH)]
        ends = [[np.interp(x, reach, axis) for axis in points.T] for x in (start, min(start + DASH, reach[-1]))]
        pieces.append(np.array([ends[0], *inner, ends[1]]))
    return pieces


def _plain(text: str) -> str:
    """Return the text in what OpenCV's fonts hold: other characters become question marks."""
    return text.encode("ascii", "replace").decode()
