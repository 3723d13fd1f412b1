"""What an interpretation says of support: its planes, and by its queries who stands on what, in the posterior reading.

* ``Said``: the planes, the most probable first, and probabilities of ``stands_on/2``, ``rests_on/2``, ``free/1``
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

from benchmarks.photos.answers import planes_of

if TYPE_CHECKING:
    from collections.abc import Mapping

    from benchmarks.support.arranged import Kind
    from geometry.bodies.resting import Plane
    from plogic.facts.document import Interpretation

GOALS = "stands_on(H, X)", "rests_on(H, X)", "free(H)"


class Said(NamedTuple):
    """``planes`` by name, the most probable first; probabilities by what stands, and by what stands on what."""

    planes: Mapping[str, Plane]
    stands: Mapping[tuple[str, str], float]
    rests: Mapping[tuple[str, str], float]
    free: Mapping[str, float]

    def stood(self, name: str) -> tuple[float, str | None]:
        """How probably a hypothesis stands on a plane, and on which; that on which it does most probably."""
        return max(((self.stands.get((name, plane), 0.0), plane) for plane in self.planes), default=(0.0, None))

    def stacked(self, name: str) -> tuple[float, str | None]:
        """How probably it rests on another hypothesis, and on which."""
        own = [(p, lower) for (upper, lower), p in self.rests.items() if upper == name and lower != "ground"]
        return max(own, default=(0.0, None))

    def kind(self, name: str) -> tuple[Kind, str | None]:
        """What is most probable of a hypothesis, and on what it stands."""
        chances: dict[Kind, tuple[float, str | None]] = {
            "standing": self.stood(name),
            "stacked": self.stacked(name),
            "free": (self.free.get(name, 0.0), None),
        }
        best = max(chances, key=lambda kind: chances[kind][0])
        return best, chances[best][1]


def said_of(document: Interpretation) -> Said | None:
    """What a document says; None where it says nothing of support."""
    from plogic.face.python.interpretation import Interpretation as Asked
    from plogic.face.python.sessions import Session

    if "support_planes" not in document:
        return None
    with Session(Asked(document)) as session:
        stands, rests, free = (
            {tuple(map(str, row.bindings.values())): row.probability for row in session.ask(goal).rows}
            for goal in GOALS
        )
    return Said(planes_of(document), _pairs(stands), _pairs(rests), {name[0]: p for name, p in free.items()})


def _pairs(told: Mapping[tuple[str, ...], float]) -> dict[tuple[str, str], float]:
    return {(some[0], some[1]): p for some, p in told.items()}
