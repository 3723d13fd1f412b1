"""``overlay``: the picture of the paper's figure 5, what was detected and what each accepted hypothesis expects.

Small images are drawn at twice their scale. Circles stand where features are Expected (D7), squares where they are
not; filled when Detected (D8), dashed when not, so the four cases of §4.2 look different: A filled circle, B dashed
square, C dashed circle, D filled square. One colour per hypothesis (Okabe and Ito's palette, told apart by colour-blind
eyes); a strip below explains the marks.

Where an accepted type is learnt, or Γ has more than ``MANY`` appearances, the same four cases are drawn as dots: a
filled dot found, a hollow one missed, a small square unexpected, nothing where neither; and appearances that nothing
claims, thousands in a photo, are left out.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import cv2
import numpy as np

from plogic.pencil import Box, Colour, Pencil, free_place

if TYPE_CHECKING:
    from numpy.typing import NDArray

PALETTE = ("#E69F00", "#56B4E9", "#009E73", "#CC79A7", "#F0E442", "#D55E00", "#0072B2")
"""Okabe and Ito's colours without black, as the page uses them."""
LARGE = 1000
"""Images at least so wide (pixels) keep their size; smaller ones are drawn twice as large."""
LINE = 34
"""Height of one line of the legend, in pixels of the result."""
NOTABLE = 6
"""At most so many features of one hypothesis are named: the rarest of its types, then cases D and C."""
MANY = 500
"""Appearances of a photo: of more than so many, none is drawn that nothing claims, and all marks are dots."""
CASES = (
    ("A", "expected, detected", True, True),
    ("C", "expected, missed", True, False),
    ("B", "neither", False, False),
    ("D", "detected, not expected", False, True),
)
GREY: Colour = (170, 170, 170)


def overlay(document: dict[str, Any], image: NDArray[np.uint8] | None) -> NDArray[np.uint8]:
    """Return the interpretation drawn over its image.

    Args:
        document: an ``interpretation/1`` document.
        image: (H, W, 3) BGR, or None for a plain ground; stretched to the camera's size if it is another.

    Returns:
        (s H + legend, s W, 3) BGR, s = 2 below ``LARGE`` and else 1; the legend is as high as its lines need.
    """
    camera = document["camera"]
    ground = np.full((int(camera["height"]), int(camera["width"]), 3), 205, np.uint8) if image is None else image
    scale = 1 if int(camera["width"]) >= LARGE else 2
    size = (int(camera["width"]) * scale, int(camera["height"]) * scale)
    picture = np.asarray(cv2.resize(ground, size, interpolation=cv2.INTER_CUBIC), np.uint8)
    pencil = Pencil(picture, scale)
    accepted = [h for h in document.get("hypotheses", []) if h["status"] == "accepted"]
    if crowded(document):
        draw_dots(pencil, accepted)
        return np.concatenate([picture, _legend(picture.shape[1], accepted, [], dots=True)])
    _draw_hypotheses(pencil, accepted)
    kinds = sorted({a["type"] for a in document.get("appearances", [])})
    for a in document.get("appearances", []):
        pencil.sign(a["uv"], a["type"], kinds)
    _draw_names(pencil, accepted, [a["uv"] for a in document.get("appearances", [])])
    return np.concatenate([picture, _legend(picture.shape[1], accepted, kinds, dots=False)])


def crowded(document: dict[str, Any]) -> bool:
    """Whether full marks would cover the picture: an accepted type is learnt, or Γ is a photo's."""
    accepted = [h for h in document.get("hypotheses", []) if h["status"] == "accepted"]
    return len(document.get("appearances", [])) > MANY or any(f.get("stands_for", 1) > 1 for h in accepted for f in h.get("features", []))


def draw_dots(pencil: Pencil, accepted: list[dict[str, Any]]) -> None:
    """Outlines, then a dot for each feature by its case, then the names with their probabilities."""
    for i, h in enumerate(accepted):
        for ring in h.get("outline", []):
            pencil.polygon(ring, colour_of(i), width=2)
    for wanted in ("D", "C", "A"):
        for i, h in enumerate(accepted):
            for f in h.get("features", []):
                if f.get("case") == wanted:
                    pencil.dot(f["uv"], colour_of(i), circle=bool(f["expected"]), filled=wanted == "A")
    taken: list[Box] = []
    for i, h in enumerate(accepted):
        _write_name(pencil, h, i, taken, f"{_name(h)}{_chance(h)}")


def bgr(colour: str) -> Colour:
    """Return '#rrggbb' as OpenCV's (blue, green, red)."""
    red, green, blue = (int(colour[i : i + 2], 16) for i in (1, 3, 5))
    return blue, green, red


def colour_of(index: int) -> Colour:
    """Return the colour of the accepted hypothesis of that index."""
    return bgr(PALETTE[index % len(PALETTE)])


def _draw_hypotheses(pencil: Pencil, accepted: list[dict[str, Any]]) -> None:
    for i, h in enumerate(accepted):
        for ring in h.get("outline", []):
            pencil.polygon(ring, colour_of(i))
    for wanted in ("B", "D", "A", "C"):  # what speaks loudest is drawn last
        for i, h in enumerate(accepted):
            for f in h.get("features", []):
                if f.get("case") == wanted:
                    pencil.feature(f["uv"], colour_of(i), circle=bool(f["expected"]), filled=bool(f["detected"]))


def _draw_names(pencil: Pencil, accepted: list[dict[str, Any]], signs: list[list[float]]) -> None:
    """Write the hypotheses' names, then the notable features', each only where it covers no other name and no mark."""
    taken: list[Box] = []
    for i, h in enumerate(accepted):
        _write_name(pencil, h, i, taken)
    taken += [
        pencil.mark_box(f["uv"]) for h in accepted for f in h.get("features", []) if f.get("case") in ("A", "C", "D")
    ]
    taken += [pencil.mark_box(uv) for uv in signs]
    for i, h in enumerate(accepted):
        for f in _notable(h.get("features", [])):
            _write(pencil, f["id"].rsplit("/", 1)[-1], tuple(f["uv"]), colour_of(i), (taken, 0.55, False))


def _write_name(pencil: Pencil, h: dict[str, Any], i: int, taken: list[Box], text: str = "") -> None:
    points = [p for ring in h.get("outline", []) for p in ring] or [f["uv"] for f in h.get("features", [])]
    if points:
        us, v = [p[0] for p in points], min(p[1] for p in points)
        _write(pencil, text or _name(h), ((min(us) + max(us)) / 2, v), colour_of(i), (taken, 0.75, True))


def _name(h: dict[str, Any]) -> str:
    return f"{h.get('label') or h['type']} {h['id']}"


def _write(
    pencil: Pencil, text: str, near: tuple[float, ...], colour: Colour, how: tuple[list[Box], float, bool]
) -> None:
    taken, size, needed = how
    box = free_place(pencil.size(text, size), (near[0], near[1]), taken, pencil, needed=needed)
    if box is not None:
        taken.append(box)
        pencil.text(text, box, size, colour)


def _notable(features: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """Return the few features worth a name: of a type that occurs once, then what wants explaining (cases D and C)."""
    types = [f["type"] for f in features]
    order = {"D": 1, "C": 2}
    keyed = [
        (0 if types.count(f["type"]) == 1 and f.get("case") == "A" else order.get(f.get("case") or "", 9), f["id"], f)
        for f in features
    ]
    return [f for rank, _, f in sorted(keyed, key=lambda k: k[:2]) if rank < 9][:NOTABLE]


def _chance(h: dict[str, Any]) -> str:
    p = h.get("probability")
    return "" if p is None else f" {'>0.999' if 0.9995 < p < 1 else f'{p:.3f}'}"


def _legend(width: int, accepted: list[dict[str, Any]], kinds: list[str], *, dots: bool) -> NDArray[np.uint8]:
    """Return the strip (lines, width, 3) that explains colours, cases and signs; it wraps."""
    features = [f for h in accepted for f in h.get("features", [])]
    counts = {letter: sum(f.get("stands_for", 1) for f in features if f.get("case") == letter) for letter, *_ in CASES}
    entries: list[tuple[str, Any]] = [
        (f"{letter} {name}: {counts[letter]}", (circle, filled) if not dots else (circle, filled, letter, "dot"))
        for letter, name, circle, filled in CASES
    ]
    entries += [(f"{_name(h)}{_chance(h) if dots else ''}", colour_of(i)) for i, h in enumerate(accepted)]
    entries += [(k.replace("_", " "), k) for k in kinds]
    strip = np.full((LINE * (3 + len(entries)), width, 3), 34, np.uint8)
    pencil, x, y = Pencil(strip, 1), 14.0, 12 + LINE / 2
    for text, key in entries:
        advance = pencil.size(text, 0.55)[0] + 62
        if x + advance > width and x > 14:
            x, y = 14.0, y + LINE
        _entry(pencil, (x + 10, y), text, key, kinds)
        x += advance
    return strip[: int(y + LINE / 2 + 12)]


def _entry(pencil: Pencil, place: tuple[float, float], text: str, key: Any, kinds: list[str]) -> None:  # noqa: ANN401 - one of three keys
    x, y = place
    if isinstance(key, str):
        pencil.sign(place, key, kinds)
    elif len(key) == 4:
        if key[2] != "B":
            pencil.dot(place, GREY, circle=key[0], filled=key[2] == "A")
    elif len(key) == 2:
        pencil.feature(place, GREY, circle=key[0], filled=key[1])
    else:
        cv2.rectangle(pencil.picture, (int(x) - 8, int(y) - 8), (int(x) + 8, int(y) + 8), key, -1)
    width, height = pencil.size(text, 0.55)
    pencil.text(text, (x + 18, y - height / 2, x + 18 + width, y + height / 2), 0.55, (235, 235, 235))
