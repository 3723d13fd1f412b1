"""``overlay``: the picture of the paper's figure 5, what was detected and what each accepted hypothesis expects.

Small images are drawn at twice their scale. Circles stand where features are Expected (D7), squares where they are
not; filled when Detected (D8), dashed when not, so the four cases of §4.2 look different: A filled circle, B dashed
square, C dashed circle, D filled square. One colour per hypothesis (Okabe and Ito's palette, told apart by colour-blind
eyes); a strip below explains the marks. Outlines and creases are dashed where another accepted object or their own
hides them.

Where an accepted type is learned, or Γ has more than ``MANY`` appearances, hundreds of marks would bury the objects:
edges, names with probabilities and, hatched, where features are missed are all; the legend has the counts, and the
rivals. With ``marks`` ``all`` the same four cases are drawn as dots: a filled dot found, a hollow one missed, a small
square unexpected, nothing where neither; appearances that nothing claims, thousands in a photo, are left out. Of the
sides of edges a found one is a stroke along its edge with a tick towards its side, and a missed one, of which no angle
is known, a small cross.
"""

from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from functools import partial
from typing import cast

import cv2
import numpy as np
from numpy.typing import NDArray

from geometry.camera_row import CameraRow
from plogic.face.shown.against import missed_on, silhouette
from plogic.face.shown.edges import edges_of
from plogic.face.shown.ground import Ground, draw_ground
from plogic.face.shown.options import Marks
from plogic.face.shown.pencil import Box, Colour, Pencil, Place, beside, free_place
from plogic.facts.document import FeatureRow, HypothesisRow, Interpretation
from plogic.facts.interpretation import found_and_usual
from plogic.run.document import best_rivals

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
BUSY, PALE = 200, 0.4
"""More marks than so many are drawn with this share of their opacity, so that the objects are seen through them."""
DOUBT = 0.05
"""Probability from which a rival is told."""
CASES = (
    ("A", "expected, detected", True, True),
    ("C", "expected, missed", True, False),
    ("B", "neither", False, False),
    ("D", "detected, not expected", False, True),
)
GREY: Colour = (170, 170, 170)
Draw = Callable[[Pencil, Place], None]
Entry = tuple[str, Draw]
"""A text of the legend and what draws the mark before it."""


def overlay(document: Interpretation, image: NDArray[np.uint8] | None, marks: Marks = "few") -> NDArray[np.uint8]:
    """Return the interpretation drawn over its image.

    Args:
        document: an ``interpretation/1`` document.
        image: (H, W, 3) BGR, or None for a plain ground; stretched to the camera's size if it is another.
        marks: of features: ``few``, where they are not hundreds; ``all``; or ``none``.

    Returns:
        (s H + legend, s W, 3) BGR, s = 2 below ``LARGE`` and else 1; the legend is as high as its lines need.
    """
    pencil = pencil_on(document["camera"], image)
    picture = pencil.picture
    accepted = [h for h in document.get("hypotheses", []) if h["status"] == "accepted"]
    ground = draw_ground(pencil, document, {h["id"]: colour_of(i) for i, h in enumerate(accepted)})
    if marks == "none" or crowded(document):
        return np.concatenate([picture, _draw_photo(pencil, accepted, document, marks, ground)])
    dashed = _draw_edges(pencil, accepted, document)
    kinds = sorted({a["type"] for a in document.get("appearances", [])})
    full = [(f, i) for i, h in enumerate(accepted) for f in h.get("features", []) if f.get("case")]
    with _seen_through(pencil, len(full) + len(document.get("appearances", []))):
        _draw_marks(pencil, full)
        for a in document.get("appearances", []):
            pencil.sign(a["uv"], a["type"], kinds)
    _draw_names(pencil, accepted, [a["uv"] for a in document.get("appearances", [])])
    entries = [*_case_entries(accepted, None), *((_name(h), swatch(colour_of(i))) for i, h in enumerate(accepted))]
    entries += [*_edge_entries(accepted, dashed=dashed), *_ground_entries(ground)]
    entries += [(k.replace("_", " "), partial(Pencil.sign, kind=k, kinds=kinds)) for k in kinds]
    return np.concatenate([picture, legend(picture.shape[1], entries)])


def pencil_on(camera: CameraRow, image: NDArray[np.uint8] | None) -> Pencil:
    """A pencil on the image, or on a plain ground, at the camera's size times s."""
    ground = np.full((int(camera["height"]), int(camera["width"]), 3), 205, np.uint8) if image is None else image
    scale = 1 if int(camera["width"]) >= LARGE else 2
    size = (int(camera["width"]) * scale, int(camera["height"]) * scale)
    return Pencil(np.asarray(cv2.resize(ground, size, interpolation=cv2.INTER_CUBIC), np.uint8), scale)


def _draw_photo(
    pencil: Pencil, accepted: list[HypothesisRow], document: Interpretation, marks: Marks, ground: Ground | None
) -> NDArray[np.uint8]:
    """Draw where features are missed, edges, dots where they are few or asked for, and names; return the legend."""
    size = int(document["camera"]["width"]), int(document["camera"]["height"])
    missed = [missed_on(h, size) for h in accepted]
    for i, places in enumerate(missed):
        pencil.hatch(places, colour_of(i))
    dashed = _draw_edges(pencil, accepted, document)
    sides = sides_of(document)
    dotted = marks == "all" or (marks == "few" and _few(accepted))
    if dotted:
        draw_dots(pencil, accepted, sides)
    _draw_labels(pencil, accepted, size)
    entries = [*_case_entries(accepted, sides)] if dotted else []
    entries += [(f"{_name(h)}{_chance(h)}{_found(h)}", swatch(colour_of(i))) for i, h in enumerate(accepted)]
    entries += [
        (f"rival of {name}: {_name(rival)}{_chance(rival)}", _nothing)
        for name, rival in best_rivals(document).items()
        if rival["probability"] >= DOUBT
    ]
    hatched: Entry = "less than a third found of what was in learning", _hatched
    entries += [hatched] * any(map(np.any, missed))
    return legend(
        pencil.picture.shape[1], [*entries, *_edge_entries(accepted, dashed=dashed), *_ground_entries(ground)]
    )


def _few(accepted: list[HypothesisRow]) -> bool:
    """Whether the features are few, and none is learned: a learned type has hundreds on a few pixels."""
    rows = [f for h in accepted for f in h.get("features", []) if f.get("case") in ("A", "C", "D")]
    return len(rows) <= BUSY and not any("learned_rate" in f for f in rows)


def _found(h: HypothesisRow) -> str:
    """How many features are found, and how many of them were when the type was learned."""
    counts = found_and_usual(h.get("features", []))
    return "" if counts is None else f": {counts[0]} of {counts[1]} features found, {counts[2]} in learning"


def _draw_labels(pencil: Pencil, accepted: list[HypothesisRow], size: tuple[int, int]) -> None:
    """Write each name with its probability beside its object, where it covers no name and little of any object."""
    rows, columns = pencil.picture.shape[:2]
    shapes = np.any([np.zeros(size[::-1], bool), *(silhouette(h, size) for h in accepted)], axis=0)
    cover = cv2.integral(cv2.resize(shapes.astype(np.uint8), (columns, rows), interpolation=cv2.INTER_NEAREST))
    taken: list[Box] = []
    for i, h in enumerate(accepted):
        places = np.array([pencil.at(p) for p in _places(h)]).reshape(-1, 2)
        text = f"{_name(h)}{_chance(h)}"
        if len(places):
            (left, top), (right, bottom) = places.min(axis=0), places.max(axis=0)
            box = beside(pencil.size(text, 0.75), (left, top, right, bottom), taken, np.asarray(cover, np.float64))
            if box is not None:
                taken.append(box)
                pencil.text(text, box, 0.75, colour_of(i))


def _places(h: HypothesisRow) -> list[list[float]]:
    """Places of the outline, or of the features of what has none."""
    return [p for ring in h.get("outline", []) for p in ring] or [uv for f in h.get("features", []) if (uv := f["uv"])]


def crowded(document: Interpretation) -> bool:
    """Whether full marks would cover the picture: an accepted type is learned, or Γ is a photo's."""
    accepted = [h for h in document.get("hypotheses", []) if h["status"] == "accepted"]
    return len(document.get("appearances", [])) > MANY or any(
        f.get("stands_for", 1) > 1 for h in accepted for f in h.get("features", [])
    )


@dataclass(frozen=True)
class Sides:
    """The sides of edges of a document.

    The ``angle`` of each appearance that is one, by its id, and their ``types``.
    """

    angle: dict[str, float]
    types: frozenset[str]

    def case(self, feature: FeatureRow) -> str | None:
        """Case A or C of a feature that is the side of an edge, as its match or else its type tells.

        None of any other.
        """
        match = feature.get("match")
        own = feature["type"] in self.types if match is None else match in self.angle
        return feature["case"] if own and feature.get("case") in ("A", "C") else None


def sides_of(document: Interpretation) -> Sides:
    """Of SIFT's appearances those that have an angle and no scale."""
    rows = [
        a for a in document.get("appearances", []) if a.get("detector") == "sift" and "angle" in a and "scale" not in a
    ]
    return Sides({a["id"]: a["angle"] for a in rows}, frozenset(a["type"] for a in rows))


def spot(feature: FeatureRow) -> list[float]:
    """The place of a feature with a case, which is in the image."""
    return cast("list[float]", feature["uv"])


def draw_dots(pencil: Pencil, accepted: list[HypothesisRow], sides: Sides) -> None:
    """A mark for each feature by its case, pale where they are hundreds."""
    marks = [
        (f, i)
        for wanted in ("D", "C", "A")
        for i, h in enumerate(accepted)
        for f in h.get("features", [])
        if f.get("case") == wanted
    ]
    with _seen_through(pencil, len(marks)):
        for f, i in marks:
            _draw_small(pencil, f, colour_of(i), sides)


def _draw_small(pencil: Pencil, f: FeatureRow, colour: Colour, sides: Sides) -> None:
    case, match = sides.case(f), f["match"]
    if case == "A" and match is not None:
        pencil.side(spot(f), sides.angle[match], colour)
    elif case == "C":
        pencil.cross(spot(f), colour)
    else:
        pencil.dot(spot(f), colour, circle=bool(f["expected"]), filled=f["case"] == "A")


def bgr(colour: str) -> Colour:
    """Return '#rrggbb' as OpenCV's (blue, green, red)."""
    red, green, blue = (int(colour[i : i + 2], 16) for i in (1, 3, 5))
    return blue, green, red


def colour_of(index: int) -> Colour:
    """Return the colour of the accepted hypothesis of that index."""
    return bgr(PALETTE[index % len(PALETTE)])


def _draw_edges(pencil: Pencil, accepted: list[HypothesisRow], document: Interpretation) -> bool:
    """Draw what is hidden first, then what is seen; tell whether anything is hidden."""
    edges = edges_of({**document, "hypotheses": [*accepted]})
    rows = [
        (bool(stroke.self_hidden or stroke.hidden_by), stroke, i)
        for i, h in enumerate(accepted)
        for stroke in edges.get(h["id"], [])
    ]
    for hidden, stroke, i in sorted(rows, key=lambda row: not row[0]):
        pencil.stroke(stroke.points, colour_of(i), 1 if stroke.inner else 2, dashed=hidden)
    return any(hidden for hidden, *_ in rows)


def _draw_marks(pencil: Pencil, marks: list[tuple[FeatureRow, int]]) -> None:
    for f, i in sorted(marks, key=lambda mark: "BDAC".index(mark[0]["case"] or "B")):  # what speaks loudest comes last
        pencil.feature(spot(f), colour_of(i), circle=bool(f["expected"]), filled=bool(f["detected"]))


@contextmanager
def _seen_through(pencil: Pencil, marks: int) -> Iterator[None]:
    """Draw so many marks pale where they are hundreds."""
    bare = pencil.picture.copy() if marks > BUSY else None
    yield
    if bare is not None:
        pencil.picture[:] = cv2.addWeighted(pencil.picture, PALE, bare, 1 - PALE, 0)


def _draw_names(pencil: Pencil, accepted: list[HypothesisRow], signs: list[list[float]]) -> None:
    """Write the hypotheses' names, then the notable features', each only where it covers no other name and no mark."""
    taken: list[Box] = []
    for i, h in enumerate(accepted):
        _write_name(pencil, h, i, taken)
    taken += [
        pencil.mark_box(spot(f)) for h in accepted for f in h.get("features", []) if f.get("case") in ("A", "C", "D")
    ]
    taken += [pencil.mark_box(uv) for uv in signs]
    for i, h in enumerate(accepted):
        for f in _notable(h.get("features", [])):
            _write(pencil, f["id"].rsplit("/", 1)[-1], tuple(spot(f)), colour_of(i), (taken, 0.55, False))


def _write_name(pencil: Pencil, h: HypothesisRow, i: int, taken: list[Box]) -> None:
    points = _places(h)
    if points:
        us, v = [p[0] for p in points], min(p[1] for p in points)
        _write(pencil, _name(h), ((min(us) + max(us)) / 2, v), colour_of(i), (taken, 0.75, True))


def _name(h: HypothesisRow) -> str:
    return f"{h.get('label') or h['type']} {h['id']}"


def _write(
    pencil: Pencil, text: str, near: tuple[float, ...], colour: Colour, how: tuple[list[Box], float, bool]
) -> None:
    taken, size, needed = how
    box = free_place(pencil.size(text, size), (near[0], near[1]), taken, pencil, needed=needed)
    if box is not None:
        taken.append(box)
        pencil.text(text, box, size, colour)


def _notable(features: list[FeatureRow]) -> list[FeatureRow]:
    """Return the few features worth a name: of a type that occurs once, then what wants explaining (cases D and C)."""
    types = [f["type"] for f in features]
    order = {"D": 1, "C": 2}
    keyed = [
        (0 if types.count(f["type"]) == 1 and f.get("case") == "A" else order.get(f.get("case") or "", 9), f["id"], f)
        for f in features
    ]
    return [f for rank, _, f in sorted(keyed, key=lambda k: k[:2]) if rank < 9][:NOTABLE]


def _chance(h: HypothesisRow) -> str:
    p = h.get("probability")
    return "" if p is None else f" {'>0.999' if 0.9995 < p < 1 else f'{p:.3f}'}"


def _edge_entries(accepted: list[HypothesisRow], *, dashed: bool) -> list[Entry]:
    rows: list[Entry] = [("edge", partial(sample, dashed=False)), ("hidden edge", partial(sample, dashed=True))]
    return [row for row, some in zip(rows, (bool(accepted), dashed), strict=True) if some]


def _ground_entries(ground: Ground | None) -> list[Entry]:
    if ground is None:
        return []
    return [(f"plane {ground.name}, a line each {ground.step:g} m; feet", partial(Pencil.foot, colour=GREY))]


def legend(width: int, entries: list[Entry]) -> NDArray[np.uint8]:
    """Return the strip (lines, width, 3) that explains colours, lines, cases and signs; it wraps."""
    strip = np.full((LINE * (3 + len(entries)), width, 3), 34, np.uint8)
    pencil, x, y = Pencil(strip, 1), 14.0, 12 + LINE / 2
    for text, draw in entries:
        wide, high = pencil.size(text, 0.55)
        if x + wide + 62 > width and x > 14:
            x, y = 14.0, y + LINE
        draw(pencil, (x + 10, y))
        pencil.text(text, (x + 28, y - high / 2, x + 28 + wide, y + high / 2), 0.55, (235, 235, 235))
        x += wide + 62
    return strip[: int(y + LINE / 2 + 12)]


def _case_entries(accepted: list[HypothesisRow], sides: Sides | None) -> list[Entry]:
    """The four cases with their counts, and how many of them are sides of edges where there are any."""
    features = [f for h in accepted for f in h.get("features", [])]
    counts: Counter[str | None] = Counter({letter: 0 for letter, *_ in CASES})
    for f in features:
        counts[f.get("case")] += f.get("stands_for", 1)
    entries: list[Entry] = []
    for letter, name, circle, filled in CASES:
        full = partial(Pencil.feature, colour=GREY, circle=circle, filled=filled)
        small = partial(Pencil.dot, colour=GREY, circle=circle, filled=letter == "A") if letter != "B" else _nothing
        apart = "" if sides is None or letter != "B" else ", not drawn"
        entries.append((f"{letter} {name}{apart}: {counts[letter]}", full if sides is None else small))
    along = Counter(sides.case(f) for f in features) if sides is not None else Counter()
    if along["A"] + along["C"]:
        entries.append((f"A, sides of edges: {along['A']}", partial(Pencil.side, angle=np.pi / 2, colour=GREY)))
        entries.append((f"C, sides of edges: {along['C']}", partial(Pencil.cross, colour=GREY)))
    return entries


def swatch(colour: Colour) -> Draw:
    """Draw a square of this colour."""

    def draw(pencil: Pencil, at: Place) -> None:
        x, y = int(at[0]), int(at[1])
        cv2.rectangle(pencil.picture, (x - 8, y - 8), (x + 8, y + 8), colour, -1)

    return draw


def sample(pencil: Pencil, at: Place, *, dashed: bool) -> None:
    """Draw a short grey line."""
    pencil.stroke([(at[0] - 12, at[1]), (at[0] + 12, at[1])], GREY, 2, dashed=dashed)


def _hatched(pencil: Pencil, at: Place) -> None:
    x, y = int(at[0]), int(at[1])
    places = np.zeros(pencil.picture.shape[:2], bool)
    places[y - 8 : y + 8, x - 8 : x + 8] = True
    pencil.hatch(places, GREY)


def _nothing(_pencil: Pencil, _at: Place) -> None:
    """Case B of a photo has no mark, nor has a rival."""
