"""The hypothesis: one object type at one pose, from its proposal to the document.

Vocabulary, each with an example value:

* ``Hypothesis``: one element of Δh, ``Hypothesis("t2", camera_from_object, opaque=True, id="h1", ...)``
* ``FeatureFact``: one feature of it as the geometry sees it, ``FeatureFact(id="roof/apex", type="apex", ...)``
* ``PartFact``: one node of its part-whole tree, ``PartFact("roof", parent="", kind="object", type="roof")``

A hypothesis grows on its way. Matching gives it the arrays over its features (D7, D8), the cycle its evidence, its ev
and its verdict (§5.4, §7), and Δh its id, its group and its features as facts, one by one: these go into
``interpretation.json`` and come back.

``expected`` is D7 as one function. The generated program states it once more, as rules
(``plogic.scene.text.rules.EXPECTED``), tested equal.
"""

from __future__ import annotations

from copy import copy
from dataclasses import dataclass, field, fields
from functools import cached_property
from typing import TYPE_CHECKING, Any, Literal, NamedTuple, Protocol, overload

import numpy as np

from geometry.frames import transform_points
from plogic.measures.crowding import shares
from plogic.measures.explanatory import Support, tally

if TYPE_CHECKING:
    from collections.abc import Iterable

    from numpy.typing import NDArray

    Flags = NDArray[np.bool_]
    from kb.clouds.cloud import ObjectType
    from plogic.facts.pixel_table import PixelTable


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


@overload
def expected(seen: _OneSeen, opaque: bool) -> bool: ...  # noqa: FBT001 - a truth value of D7
@overload
def expected(seen: _OneSeen, opaque: bool, hidden: Flags) -> Flags: ...  # noqa: FBT001
@overload
def expected(seen: Seen | Hypothesis, opaque: bool, hidden: Flags | bool = False) -> Flags: ...  # noqa: FBT001, FBT002


def expected(seen: Any, opaque: bool, hidden: Any = False) -> Any:  # noqa: FBT001, FBT002
    """Return whether a feature is Expected in one world, or in several (D7).

    Truth values, or arrays of them that broadcast.

    It projects into the image (``in_image``); the viewpoint is in one of its lobes (``in_lobe``); and it is not Behind
    any opaque object of the world, neither its own host (``self_hidden``, where the host is ``opaque``) nor another
    that is present and no rival (``hidden``).
    """
    return seen.in_image & seen.in_lobe & ((seen.self_hidden & opaque | hidden) ^ True)


Status = Literal["open", "accepted", "rival", "unweighed", "rejected"]


@dataclass(frozen=True)
class FeatureFact:
    """One feature of a posed hypothesis, seen from the camera (D7, D8).

    ``id`` is the path of the feature in its type's tree, unique within a hypothesis. ``at`` is in metres in the camera
    frame, ``uv`` its projection in pixels. ``in_image``, ``in_lobe`` and ``self_hidden`` (Behind its own host) are what
    geometry says of the hypothesis alone; ``hidden_by`` names the *other* hypotheses whose surface the line of sight
    meets first, transparent ones and rivals included (the rules sort these out). ``match`` is the appearance that the
    hypothesis' one fixed assignment gives it, with its ``residual`` in pixels and ``density``, N(u; û, Σ) per pixel².
    ``hit_rate`` is h_F; ``learned_rate``: of a learned type how often the feature was found, from there, when the type
    was learned, None of others. ``stands_for`` > 1: it sums up so many features in the image that are neither expected
    nor detected in any world (case B), and ``dv`` is their sum; 0: it is a part of a compound that another part stands
    for, and its ``dv`` is 0 (``plogic.cycle.lumped``).
    """

    id: str
    type: str
    at: tuple[float, float, float]
    uv: tuple[float, float]
    dv: float
    in_image: bool
    in_lobe: bool
    self_hidden: bool
    hidden_by: tuple[str, ...] = ()
    match: str | None = None
    residual: float | None = None
    density: float = 0.0
    hit_rate: float = 0.8
    stands_for: int = 1
    learned_rate: float | None = None


@dataclass(frozen=True)
class PartFact:
    """One node of the part-whole tree: ``PartFact("roof", parent="", kind="object")``.

    The parent of the maximal object's parts is ''.
    """

    id: str
    parent: str
    kind: Literal["object", "feature"]
    type: str


@dataclass(frozen=True, eq=False)
class Hypothesis:
    """One object type at one pose; ``camera_from_object`` (4, 4) metres. Its arrays are read-only.

    ``known_type`` is the type as Σo describes it: None in a hypothesis that comes from a document, which has no arrays.
    F are the features of the maximal object, the type's ``seen_features`` in their order; A are the data.

    * ``at`` (F, 3) metres, camera frame; ``uv`` (F, 2) pixels; ``in_image``, ``in_lobe``, ``self_hidden`` (F,).
    * ``right`` (F, A): the data of a type whose lobe holds the viewpoint.
    * ``matches`` (F,): datum index, or −1; ``residual`` (F,) pixels, NaN where unmatched.
    * Of a learned type, None of others: ``hit`` (F,) the measured rate of the lobes that hold the viewpoint; ``turn``
      (F,) the screen angle that they make expect; ``sigma`` (F,) the noise of places, pixels; ``sided`` (F,) which
      features are sides of edges; ``across`` (F, 2) unit vectors on the screen across those edges, NaN of other
      features: what is off along them is not ``residual``.
    * ``likeness`` (F,): of a learned type how much rarer what looks like the match is than clutter of its type; of
      others, where angles of data count, how much likelier the match's angle is than any; else None.
    * ``axes`` (F, 3): where angles of data count, the x axes of the features' frames, camera frame, unit: what an angle
      is of.

    ``pixels``: how well the photo fits, at the pose that was moved to where it fits best (``sensing.pixels``), the
    logarithm of a likelihood, about; None where there is no photo, or no paint. ``pixel_table``: the same by who stands
    before it, as the posterior is told; None where there is no ``pixels``. ``pose_probability``: P(its pose is right,
    given that it is present), by the photo; None where that is not known. ``spread`` (6, 6): how exactly its pixels
    tell its pose, the covariance of its turn about its middle (rad) and of the middle (m), camera frame. ``stance``:
    what standing where others do, or nowhere, adds to its log-odds given all other proposals (§9.9); 0 where nobody
    said that things rest. ``released`` (4, 4): of what was looked for on a plane, where its pixels alone, or its
    matches, lead it from there: that it stands there still is for it; None of what was found without a plane.

    ``worth`` is the log-likelihood ratio against clutter, ``surplus`` what is left of it besides what any pose has.
    ``ev`` is that of the hypothesis alone, ``ev_reconsidered`` that beside Δi; None where it is 0/0 or was not asked.
    ``hidden`` (F,): what accepted opaque objects hide of it, where it was judged beside any.

    ``group`` names the instance that it and its rivals of the same type compete for (one alternative, §8).
    ``features`` and ``parts`` are facts. Two hypotheses are equal where their facts are.
    """

    type: str
    camera_from_object: NDArray[np.float64]
    opaque: bool
    id: str = ""
    group: str = ""
    features: tuple[FeatureFact, ...] = ()
    parts: tuple[PartFact, ...] = ()
    status: Status = "open"
    why: str = ""
    worth: float = 0.0
    surplus: float = 0.0
    ev: float | None = None
    ev_reconsidered: float | None = None
    hidden: NDArray[np.bool_] | None = field(default=None, repr=False)
    known_type: ObjectType | None = field(default=None, repr=False)
    at: NDArray[np.float64] = field(default_factory=lambda: np.zeros((0, 3)), repr=False)
    uv: NDArray[np.float64] = field(default_factory=lambda: np.zeros((0, 2)), repr=False)
    in_image: NDArray[np.bool_] = field(default_factory=lambda: np.zeros(0, bool), repr=False)
    in_lobe: NDArray[np.bool_] = field(default_factory=lambda: np.zeros(0, bool), repr=False)
    self_hidden: NDArray[np.bool_] = field(default_factory=lambda: np.zeros(0, bool), repr=False)
    right: NDArray[np.bool_] = field(default_factory=lambda: np.zeros((0, 0), bool), repr=False)
    matches: NDArray[np.intp] = field(default_factory=lambda: np.zeros(0, np.intp), repr=False)
    residual: NDArray[np.float64] = field(default_factory=lambda: np.zeros(0), repr=False)
    hit: NDArray[np.float64] | None = field(default=None, repr=False)
    turn: NDArray[np.float64] | None = field(default=None, repr=False)
    sigma: NDArray[np.float64] | None = field(default=None, repr=False)
    likeness: NDArray[np.float64] | None = field(default=None, repr=False)
    sided: NDArray[np.bool_] | None = field(default=None, repr=False)
    across: NDArray[np.float64] | None = field(default=None, repr=False)
    axes: NDArray[np.float64] | None = field(default=None, repr=False)
    pixels: float | None = field(default=None, repr=False)
    spread: NDArray[np.float64] | None = field(default=None, repr=False)
    stance: float = 0.0
    released: NDArray[np.float64] | None = field(default=None, repr=False)
    pixel_table: PixelTable | None = None
    pose_probability: float | None = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "camera_from_object", np.asarray(self.camera_from_object, np.float64))
        for name in ARRAYS:
            array = getattr(self, name)
            if array is not None:
                array.setflags(write=False)

    def __eq__(self, other: object) -> bool:
        return self._facts() == other._facts() if isinstance(other, Hypothesis) else NotImplemented

    def __hash__(self) -> int:
        return hash(self._facts())

    def _facts(self) -> tuple[object, ...]:
        pose = tuple(self.camera_from_object.ravel().tolist())
        return self.id, self.type, pose, self.opaque, self.group, self.features, self.parts, self.pixel_table

    @property
    def object_type(self) -> ObjectType:
        """The type as Σo describes it. Raises LookupError of a hypothesis that comes from a document."""
        if self.known_type is None:
            raise LookupError(f"hypothesis {self.id}: a document does not hold the whole type {self.type}")
        return self.known_type

    def told(self, **said: object) -> Hypothesis:
        """The same hypothesis with another id, verdict or facts: nothing that its arrays give changes."""
        result = copy(self)
        for name, value in said.items():
            if isinstance(value, np.ndarray):
                value.setflags(write=False)
            object.__setattr__(result, name, value)
        return result

    def verdict(self) -> dict[str, object]:
        """What was judged of it: another hypothesis can be ``told`` the same."""
        return {name: getattr(self, name) for name in VERDICT}

    def beyond(self) -> dict[str, object]:
        """What is known of it beyond Γ: another hypothesis of its pose can be ``told`` the same."""
        return {name: getattr(self, name) for name in ("pixels", "spread", "stance", "released")}

    def expects(self, feature: FeatureFact) -> bool:
        """Return whether the feature is Expected where no other object of the world hides it (D7)."""
        return expected(feature, self.opaque)

    @cached_property
    def candidate(self) -> NDArray[np.bool_]:
        """(F,) Expected where no other object hides it (D7)."""
        return expected(self, self.opaque)

    def expected(self, hidden: NDArray[np.bool_] | None = None) -> NDArray[np.bool_]:
        """(F,) Expected where opaque objects of the world hide the ``hidden`` features (F,) (D7).

        None: where there are none.
        """
        return self.candidate if hidden is None else expected(self, self.opaque, hidden)

    @cached_property
    def counted(self) -> NDArray[np.float64]:
        """(F,) for how much of an independent observation each feature counts.

        Of a learned type, shares of what crowds the expected ones.
        """
        result = np.ones(len(self.uv))
        if self.turn is not None and self.candidate.any():
            sided = np.zeros(len(self.uv), bool) if self.sided is None else self.sided
            result[self.candidate] = shares(self.uv[self.candidate], self.turn[self.candidate], sided[self.candidate])
        return result

    @property
    def middle(self) -> NDArray[np.float64]:
        """(3,) middle of the object, camera frame: of its surface, or of its features where it has none."""
        surface = self.object_type.surface
        if surface is None:
            return np.asarray((self.at.min(axis=0) + self.at.max(axis=0)) / 2.0)
        return transform_points(self.camera_from_object, surface.centre[None])[0]

    @property
    def detected(self) -> NDArray[np.bool_]:
        """(F,) D8."""
        return self.matches >= 0

    @cached_property
    def stands(self) -> NDArray[np.bool_]:
        """(F,) which features stand for a maximal one (A1).

        All but those parts of a compound that another part stands for.

        A compound looks like any of its parts and takes one appearance, so it is where its surest part is: one in the
        image, that is expected and detected, else expected, else detected; of several the one with the greatest hit
        rate, the first of equals.
        """
        whole = self.object_type.whole
        result = np.ones(len(self.uv), bool)
        if len(whole) == len(self.object_type.features):
            return result
        parts = np.flatnonzero(np.bincount(whole)[whole] > 1)
        surest = (4 * self.in_image + 2 * self.candidate + self.detected)[parts]
        hit = np.zeros(len(parts)) if self.hit is None else self.hit[parts]
        parts = parts[np.lexsort((-hit, -surest, whole[parts]))]
        result[parts[1:]] = whole[parts[1:]] != whole[parts[:-1]]
        return result

    def support(self, hidden: NDArray[np.bool_] | None = None) -> Support:
        """The four cases over the features in the image, a compound once (A1).

        ``hidden`` (F,): what accepted opaque objects hide (strict D7).
        """
        names, kind = self.object_type.kind_codes
        inside = self.in_image & self.stands
        return tally(names, kind[self.object_type.whole[inside]], self.expected(hidden)[inside], self.detected[inside])


ARRAYS = tuple(row.name for row in fields(Hypothesis) if "NDArray" in str(row.type))
"""The fields that are arrays."""
VERDICT = "worth", "surplus", "ev", "ev_reconsidered", "status", "why"
"""The fields that say what was judged."""


def feature_nodes(parts: Iterable[PartFact], features: Iterable[tuple[str, str]]) -> dict[str, str]:
    """The type of every Feature node, by its path: of ``features``, and of compounds' parts that those stand for."""
    told = dict(features)
    return told | {p.id: p.type for p in parts if p.kind == "feature" and p.id not in told}


def part_facts(object_type: ObjectType) -> tuple[PartFact, ...]:
    """A fact for every part and feature below the maximal object, in the tree's order."""
    return tuple(
        PartFact(name, node.above, node.kind, node.type)
        for name, node in object_type.tree.nodes.items()
        if node.above is not None and node.kind != "appearance"
    )
