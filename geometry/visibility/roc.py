"""ROC-20, the twenty occlusion relations (§3.7; Randell, Witkowski, Shanahan 2001), by name.

Their converses and coarsenings.

A relation is the RCC-8 term of the image of x to the image of y, times who is in front on the common interior:

| in front there        | RCC-8 of image(x) to image(y)  | names                                                 |
|-----------------------|--------------------------------|-------------------------------------------------------|
| nobody: there is none | DC, EC                         | non_occludes_dc, _ec                                  |
| x                     | PO, TPP, NTPP                  | partially_occludes_po, _tpp, _ntpp                    |
| x                     | EQ, TPPi, NTPPi                | totally_occludes_eq, _tppi, _ntppi                    |
| y                     | PO, TPPi, NTPPi                | partially_occluded_by_po, _tppi, _ntppi               |
| y                     | EQ, TPP, NTPP                  | totally_occluded_by_eq, _tpp, _ntpp                   |
| each somewhere        | PO, EQ, TPP, TPPi, NTPP, NTPPi | mutually_occludes_po, _eq, _tpp, _tppi, _ntpp, _ntppi |

``Roc``, the name: ``"partially_occludes_tpp"`` (x in front, its image a tangential proper part of y's).
"""

from typing import Literal, get_args

Rcc8 = Literal["DC", "EC", "PO", "TPP", "NTPP", "EQ", "TPPi", "NTPPi"]
CoarseRelation = Literal[
    "non_occludes",
    "partially_occludes",
    "partially_occluded_by",
    "totally_occludes",
    "totally_occluded_by",
    "mutually_occludes",
]
Roc = Literal[
    "non_occludes_dc",
    "non_occludes_ec",
    "partially_occludes_po",
    "partially_occludes_tpp",
    "partially_occludes_ntpp",
    "partially_occluded_by_po",
    "partially_occluded_by_tppi",
    "partially_occluded_by_ntppi",
    "totally_occludes_eq",
    "totally_occludes_tppi",
    "totally_occludes_ntppi",
    "totally_occluded_by_eq",
    "totally_occluded_by_tpp",
    "totally_occluded_by_ntpp",
    "mutually_occludes_po",
    "mutually_occludes_eq",
    "mutually_occludes_tpp",
    "mutually_occludes_tppi",
    "mutually_occludes_ntpp",
    "mutually_occludes_ntppi",
]
Los14 = Literal["C", "JC", "PH", "PHI", "JH", "JHI", "H", "HI", "EH", "EHI", "JF", "JFI", "F", "FI"]
Front = Literal["nobody", "x", "y", "both"]

RCC8: tuple[Rcc8, ...] = get_args(Rcc8)
"""The eight, jointly exhaustive and pairwise disjoint."""
ROC20: tuple[Roc, ...] = get_args(Roc)
"""The twenty, jointly exhaustive and pairwise disjoint."""
COARSE: tuple[CoarseRelation, ...] = get_args(CoarseRelation)
_RCC_CONVERSE: dict[Rcc8, Rcc8] = {"TPP": "TPPi", "NTPP": "NTPPi", "TPPi": "TPP", "NTPPi": "NTPP"}
_COVERED: dict[Front, tuple[Rcc8, ...]] = {"x": ("EQ", "TPPi", "NTPPi"), "y": ("EQ", "TPP", "NTPP")}
"""Who is in front → the terms at which the hinder image is covered."""
_WORDS: dict[Front, tuple[CoarseRelation, CoarseRelation]] = {
    "nobody": ("non_occludes", "non_occludes"),
    "x": ("partially_occludes", "totally_occludes"),
    "y": ("partially_occluded_by", "totally_occluded_by"),
    "both": ("mutually_occludes", "mutually_occludes"),
}
_MIRRORED: dict[Front, Front] = {"x": "y", "y": "x", "nobody": "nobody", "both": "both"}


def rcc_converse(term: Rcc8) -> Rcc8:
    """The RCC-8 relation of (b, a) where ``term`` is that of (a, b)."""
    return _RCC_CONVERSE.get(term, term)


def roc(rcc: Rcc8, front: Front) -> Roc:
    """The relation of x to y: ``rcc`` of their images.

    ``front`` is 'nobody' for DC and EC, and else who is first somewhere on the common interior.

    Raises KeyError for a term that does not go with who is in front.
    """
    return _NAMED[rcc, front]


def parts_of(relation: Roc) -> tuple[Rcc8, Front]:
    """The RCC-8 term of the images, and who is in front."""
    return _MEANT[relation]


def converse(relation: Roc) -> Roc:
    """The relation of (y, x) where ``relation`` is that of (x, y)."""
    rcc, front = _MEANT[relation]
    return _NAMED[rcc_converse(rcc), _MIRRORED[front]]


def coarse(relation: Roc) -> CoarseRelation:
    """Which of the six coarse relations it is a case of."""
    return _word(*_MEANT[relation])


def coarse_converse(relation: CoarseRelation) -> CoarseRelation:
    """The coarse relation of (y, x) where ``relation`` is that of (x, y)."""
    front, words = next((front, words) for front, words in _WORDS.items() if relation in words)
    return _WORDS[_MIRRORED[front]][words.index(relation)]


def los14(relation: Roc) -> Los14 | None:
    """Galton's line-of-sight relation, which knows only convex bodies: None where it is mutual.

    C clears, JC just clears; PH partially hides, JH just hides, H hides, EH exactly hides; JF just in front of, F in
    front of; I their inverses.
    """
    return _LOS.get(relation)


def _all() -> dict[tuple[Rcc8, Front], Roc]:
    """Every pair that there is, with its name.

    No image is in front of another without a common interior, and none shares one without an order.
    """
    apart: tuple[Rcc8, ...] = ("DC", "EC")
    overlapping: tuple[Rcc8, ...] = ("PO", "TPP", "NTPP", "EQ", "TPPi", "NTPPi")
    ordered: tuple[Front, ...] = ("x", "y", "both")
    pairs: list[tuple[Rcc8, Front]] = [(rcc, "nobody") for rcc in apart] + [
        (rcc, front) for front in ordered for rcc in overlapping
    ]
    named: dict[str, Roc] = {name: name for name in ROC20}
    return {(rcc, front): named[f"{_word(rcc, front)}_{rcc.lower()}"] for rcc, front in pairs}


def _word(rcc: Rcc8, front: Front) -> CoarseRelation:
    return _WORDS[front][rcc in _COVERED.get(front, ())]


_NAMED = _all()
_MEANT = {name: pair for pair, name in _NAMED.items()}
_LOS: dict[Roc, Los14] = {
    "non_occludes_dc": "C",
    "non_occludes_ec": "JC",
    "partially_occludes_po": "PH",
    "partially_occluded_by_po": "PHI",
    "totally_occludes_tppi": "JH",
    "totally_occluded_by_tpp": "JHI",
    "totally_occludes_ntppi": "H",
    "totally_occluded_by_ntpp": "HI",
    "totally_occludes_eq": "EH",
    "totally_occluded_by_eq": "EHI",
    "partially_occludes_tpp": "JF",
    "partially_occluded_by_tppi": "JFI",
    "partially_occludes_ntpp": "F",
    "partially_occluded_by_ntppi": "FI",
}
