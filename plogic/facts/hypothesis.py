"""One hypothesis: an object type at a pose, with what geometry, the data and the judgement say of it (D7, D8, §5).

Vocabulary: ``Hypothesis``, from its proposal on.
"""

from __future__ import annotations

from dataclasses import dataclass, fields
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from geometry.frames import transform_points
from plogic.measures.crowding import shares
from plogic.measures.explanatory import Support, tally

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from kb.clouds.cloud import ObjectType


@dataclass(frozen=True)
class Hypothesis:
    """One object type at one pose. Its arrays are read-only.

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
    """

    object_type: ObjectType
    camera_from_object: NDArray[np.float64]
    at: NDArray[np.float64]
    uv: NDArray[np.float64]
    in_image: NDArray[np.bool_]
    in_lobe: NDArray[np.bool_]
    self_hidden: NDArray[np.bool_]
    right: NDArray[np.bool_]
    matches: NDArray[np.intp]
    residual: NDArray[np.float64]
    hit: NDArray[np.float64] | None = None
    turn: NDArray[np.float64] | None = None
    sigma: NDArray[np.float64] | None = None
    likeness: NDArray[np.float64] | None = None
    sided: NDArray[np.bool_] | None = None
    across: NDArray[np.float64] | None = None
    axes: NDArray[np.float64] | None = None

    def __post_init__(self) -> None:
        for name in _FIELDS:
            value = getattr(self, name)
            if isinstance(value, np.ndarray):
                value.setflags(write=False)

    @cached_property
    def candidate(self) -> NDArray[np.bool_]:
        """(F,) Expected where no other object hides it (D7)."""
        hidden = self.self_hidden if self.object_type.opaque else np.zeros_like(self.self_hidden)
        return self.in_image & self.in_lobe & ~hidden

    @cached_property
    def counted(self) -> NDArray[np.float64]:
        """(F,) for how much of an independent observation each feature counts: of a learned type, shares of what crowds the expected ones."""
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
        """(F,) which features stand for a maximal one (A1): all but those parts of a learned compound that another part stands for.

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
        """The four cases over the features in the image, a compound once (A1); ``hidden`` (F,): what accepted opaque objects hide (strict D7)."""
        expected = self.candidate & ~hidden if hidden is not None else self.candidate
        names, kind = self.object_type.kind_codes
        inside = self.in_image & self.stands
        return tally(names, kind[self.object_type.whole[inside]], expected[inside], self.detected[inside])


_FIELDS = tuple(field.name for field in fields(Hypothesis))
