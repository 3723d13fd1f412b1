"""Δp, the panorama (§1): what was interpreted over a sequence of views, kept in the world's frame.

What leaves the view stays, with its probability and its age; what comes back into view is looked at where it is
remembered, before any search.
The world is taken to stand still: what is expected in a view and plainly not there is gone, and is forgotten.

As a document, ``panorama/1``, it is a sequence of views, each with its interpretation, and what stands in the world
after all of them.

* ``Known``: one object of Δp, ``Known("p1", standing, 0.99, last_seen="v3", age=2)``
* ``Panorama``: Δp over the views so far
"""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Final, NamedTuple

import numpy as np

from geometry.frames import compose, inverse, transform_points
from geometry.visibility.rays import RayMesh, behind
from plogic.base.clock import Stopwatch
from plogic.cycle.judging import FEWEST
from plogic.cycle.perception import Seed
from plogic.facts.situation import SEARCH, stopped_in
from plogic.match.gamma.data import data_of
from plogic.match.judged.evidence import evidence, hit_rates
from plogic.match.judged.rivals import claims, hidden_among
from plogic.scene.readings.unfinished import OPEN, marks
from plogic.sequence.constancy.decide import unknown_objects
from plogic.sequence.constancy.result import Constancy, constancy_document
from plogic.sequence.views.joint import Joint, Member, joint, laid_together
from plogic.sequence.views.standing import Seen, Standing, seen_alone, standing_of

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from numpy.typing import NDArray

    from geometry.arrays import Floats, Mask
    from plogic.cycle.delta import Options
    from plogic.cycle.state import Cycle
    from plogic.facts.document import Interpretation, WorldRow
    from plogic.facts.hypothesis import Hypothesis
    from plogic.run.perceive import Perceiver
    from plogic.scene.worlds.ranked_worlds import Ranking
    from plogic.sequence import document
    from plogic.sequence.constancy.sight_lines import View
    from plogic.sequence.constancy.weights import Hidden
    from plogic.sequence.document import AheadRow, ExpectedRow, Joined, ObjectRow, StandingRow, ViewRow


WINDOW = 6
"""Views that are judged together, the newest; what is known of an object from older ones is its probability."""
MOST = 12
"""Hypotheses that are judged together."""
BELIEVED = 0.5
"""Least probability of what is in Δp."""
POSSIBLE = 0.01
"""Least probability of a rival that is carried on to the next view."""
GONE = -5.0
"""Log-likelihood ratio in one view, of an object that is expected there, below which it is gone: 150 to 1 against
it."""


@dataclass(frozen=True, eq=False)
class Known:
    """One object of Δp.

    ``age``: views since it was last in view; ``by_view``: which hypothesis of a view's interpretation it was.
    """

    id: str
    standing: Standing
    probability: float
    last_seen: str
    age: int = 0
    by_view: Mapping[str, str] = field(default_factory=dict)


@dataclass(frozen=True, eq=False)
class Look:
    """What one view came to: the interpretation document, expectations of Δp, losses, ids of unexplained data."""

    view: View
    interpretation: Interpretation
    predicted: tuple[ExpectedRow, ...]
    gone: tuple[str, ...]
    unexplained: tuple[str, ...]


class Panorama:
    """Δp.

    ``look`` at one view after the other; ``known`` is what is believed, ``rivals`` what might be there instead.
    """

    def __init__(self, perceiver: Perceiver, options: Options) -> None:
        self.perceiver, self.options = perceiver, options
        self.seen: list[Seen] = []
        self.known: list[Known] = []
        self.rivals: list[Standing] = []
        self.ranking: Ranking | None = None
        self.joint: Joint | None = None
        self.usual: dict[str, int] = {}
        self.named = 0

    def look(self, view: View, image: NDArray[np.uint8] | None = None, clock: Stopwatch | None = None) -> Look:
        """Interpret a view with what is remembered, and remember what comes of it; ``clock``: its own stages.

        Raises BeliefError as a single image does.
        """
        clock = clock or Stopwatch()
        with clock.stage("expect"):
            expected = self.expected(view)
        seeds = [Seed(known.standing.index, known.standing.before(view)) for known, _ in expected]
        data, cycle = self.perceiver.cycle(view.gamma, self.options, clock, seeds, self.usual)
        interpretation = self.perceiver.document(view.gamma, data, cycle, self.options, image, clock)
        seen = Seen(view, data)
        with clock.stage("together"):
            gone = self._forget(expected, cycle, seen)
            self.seen = [*self.seen, seen][-WINDOW:]
            self._remember(cycle, view, [known.id for known, _ in expected])
        taken = {i for belief in cycle.accepted for i in claims(belief)}
        left = tuple(name for i, name in enumerate(seen.data.ids) if i not in taken)
        if not any(step.event == "no search" for step in cycle.trace.steps):
            self._searched(left, seen)
        return Look(view, interpretation, self._foreseen(expected), gone, left)

    def _searched(self, left: Sequence[str], seen: Seen) -> None:
        """Note how many data of each type a search left unexplained: the most of any view."""
        kind = dict(zip(seen.data.ids, seen.data.types, strict=True))
        here = Counter(kind[name] for name in left)
        self.usual = {name: max(here[name], self.usual.get(name, 0)) for name in sorted({*here, *self.usual})}

    def predicted(self, view: View) -> tuple[ExpectedRow, ...]:
        """What anticipated motion leads to expect.

        Of each object of Δp that should be seen from there, as ``panorama/1`` says it.
        """
        return self._foreseen(self.expected(view))

    def _foreseen(self, expected: Sequence[tuple[Known, Hypothesis]]) -> tuple[ExpectedRow, ...]:
        return tuple(_told(known, posed, self.perceiver) for known, posed in expected)

    def expected(self, view: View) -> list[tuple[Known, Hypothesis]]:
        """What of Δp should be seen from here, the surest first.

        Of which ``FEWEST`` features or more are expected (D7). Γ is not looked at.
        """
        blank = Seen(view, data_of((), view.gamma.camera, self.perceiver.width))
        posed = [(known, seen_alone(known.standing, blank, self.perceiver.kb)) for known in self.known]
        return [
            (known, one)
            for known, one in sorted(posed, key=lambda pair: -pair[0].probability)
            if one.expected(hidden_among(one, [other for _, other in posed])).sum() >= FEWEST
        ]

    def _forget(self, expected: Sequence[tuple[Known, Hypothesis]], cycle: Cycle, seen: Seen) -> tuple[str, ...]:
        """Drop from Δp what is expected here, was not found, and is plainly not there. Its ids."""
        there = [standing_of(b, seen.view, self.perceiver.models) for b in cycle.accepted]
        lost = [k for k, _ in expected if not any(k.standing.same(some, seen.view) for some in there)]
        gone = tuple(known.id for known in lost if self._speaks(known, cycle, seen) < GONE)
        self.known = [known for known in self.known if known.id not in gone]
        return gone

    def _speaks(self, known: Known, cycle: Cycle, seen: Seen) -> float:
        """The log-likelihood ratio of one object in one view, where what was accepted there hides what it hides."""
        posed = seen_alone(known.standing, seen, self.perceiver.kb)
        return evidence(posed, seen.data, self.perceiver.kb, hidden_among(posed, cycle.accepted)).ratio

    def _remember(self, cycle: Cycle, view: View, in_view: Sequence[str]) -> None:
        """Judge what is known and what is new in all views together, and keep what is probable."""
        beliefs = (*cycle.accepted, *cycle.considered)
        fresh = [Member(standing_of(b, view, self.perceiver.models), len(self.seen) - 1, b) for b in beliefs]
        known = [member for some in self.known for member in self._before(some.standing)]
        rivals = [member for some in self.rivals for member in self._before(some)]
        standing = laid_together((*known, *fresh, *rivals), self.seen, view, self.perceiver.kb)
        standing = [some for some in standing if self._shown(some)][:MOST]
        self.joint, self.ranking = None, None
        chances: list[tuple[Standing, float]] = []
        if standing:
            self.joint, self.ranking = joint(self.seen, standing, self.perceiver, self.options)
            chances = [(some, self.ranking.marginals[f"h{i}"]) for i, some in enumerate(self.joint.standing, 1)]
        self.rivals = [some for some, chance in chances if POSSIBLE <= chance < BELIEVED]
        self._update([pair for pair in chances if pair[1] >= BELIEVED], cycle, view, in_view)

    def _before(self, some: Standing) -> list[Member]:
        """What is remembered as the views of the window before this one show it."""
        before = self.seen[:-1]
        return [Member(some, v, seen_alone(some, one, self.perceiver.kb)) for v, one in enumerate(before)]

    def _shown(self, some: Standing) -> bool:
        """Whether some view of the window shows anything of it."""
        return any(seen_alone(some, seen, self.perceiver.kb).candidate.any() for seen in self.seen)

    def _update(
        self, believed: Sequence[tuple[Standing, float]], cycle: Cycle, view: View, in_view: Sequence[str]
    ) -> None:
        """Δp after a view: what is believed, under its old name if any, and what no view of the window shows."""
        kept = [known for known in self.known if not self._shown(known.standing)]
        others = [known for known in self.known if self._shown(known.standing)]
        there = [standing_of(b, view, self.perceiver.models) for b in cycle.accepted]
        for some, chance in believed:
            old = next((known for known in others if some.same(known.standing, view)), None)
            here = old is None or old.id in in_view
            if old is None:
                self.named += 1
                old = Known(f"p{self.named}", some, chance, view.id)
            others = [known for known in others if known is not old]
            kept.append(_aged(old, some, chance, there, view, here=here))
        aged = [known if known.last_seen == view.id else replace(known, age=known.age + 1) for known in kept]
        self.known = sorted(aged, key=lambda known: int(known.id[1:]))


def _aged(old: Known, standing: Standing, chance: float, there: Sequence[Standing], view: View, *, here: bool) -> Known:
    """The same object after one more view, in which it was found or was expected (``here``), or which did not show it.

    ``there``: Δi of that view.
    """
    names = [f"h{i}" for i, some in enumerate(there, 1) if standing.same(some, view)]
    by_view = {**old.by_view, **({view.id: names[0]} if names else {})}
    if names or here:
        return Known(old.id, standing, chance, view.id, 0, by_view)
    return replace(old, standing=standing, probability=chance, by_view=by_view)


def _told(known: Known, posed: Hypothesis, perceiver: Perceiver) -> ExpectedRow:
    """What anticipated motion leads to expect of one object, as ``panorama/1`` says it."""
    expected = posed.candidate
    return {
        "id": known.id,
        "type": known.standing.object_type.name,
        "T_camera_object": posed.camera_from_object.tolist(),
        "expected_features": int(expected.sum()),
        "expected_detections": float(hit_rates(posed, perceiver.kb)[expected].sum()),
    }


class Body(NamedTuple):
    """An opaque surface where it stands: ``world_from_object`` (4, 4)."""

    rays: RayMesh
    world_from_object: Floats


def hiding(views: Sequence[View], bodies: Mapping[str, Sequence[Body]]) -> Hidden:
    """The callback that ``unknown_objects`` takes: which places (N, 3) m, world, some body hides from a view.

    ``bodies`` by the view's id.
    """
    camera_from_world = {view.id: inverse(view.world_from_camera) for view in views}

    def hidden(view: str, world: Floats) -> Mask:
        frame = camera_from_world[view]
        points = transform_points(frame, world)
        masks = [behind(points, body.rays, compose(frame, body.world_from_object)) for body in bodies.get(view, ())]
        return np.any(np.array(masks, bool).reshape(len(masks), len(world)), axis=0)

    return hidden


def constancy_of(panorama: Panorama, looks: Sequence[Look]) -> Constancy:
    """What is unknown, noise or undecided of all ``looks`` so far.

    The opaque objects of Δp hide what they hide in each (D4).
    """
    views, standing = [look.view for look in looks], [known.standing for known in panorama.known]
    bodies = [
        Body(surface.rays, some.world_from_object)
        for some in standing
        if some.object_type.opaque and (surface := some.object_type.surface) is not None
    ]
    unexplained = {look.view.id: look.unexplained for look in looks}
    return unknown_objects(
        views, unexplained, panorama.perceiver.kb.rates, hiding(views, {view.id: bodies for view in views})
    )


FORMAT: Final = "panorama/1"


def panorama_document(
    panorama: Panorama, looks: Sequence[tuple[str, Look]], foreseen: Sequence[AheadRow] = ()
) -> document.Panorama:
    """The document of a sequence.

    ``looks`` with their frames' names, and what is ``foreseen`` where nothing was seen yet.
    """
    kb, joined = panorama.perceiver.kb, worlds_of(panorama)
    last = looks[-1][1].view.id if looks else ""
    objects = [_object(known, last) for known in panorama.known]
    if any(stopped_in(look.interpretation) == SEARCH for _, look in looks):
        joined, objects = _open(joined), [{**row, "interval": list(OPEN)} for row in objects]
    return {
        "format": FORMAT,
        "kb": {"name": kb.name, "digest": kb.digest},
        "reading": panorama.options.reading,
        "views": [_view(frame, look) for frame, look in looks],
        "objects": objects,
        **constancy_document(constancy_of(panorama, [look for _, look in looks])),
        **joined,
        "ahead": list(foreseen),
    }


def _view(frame: str, look: Look) -> ViewRow:
    return {
        "id": look.view.id,
        "frame": frame,
        "T_world_camera": look.view.world_from_camera.tolist(),
        "predicted": list(look.predicted),
        "gone": list(look.gone),
        "unexplained": list(look.unexplained),
        "interpretation": look.interpretation,
    }


def _object(known: Known, last: str) -> ObjectRow:
    return {
        "id": known.id,
        "type": known.standing.object_type.name,
        "T_world_object": known.standing.world_from_object.tolist(),
        "probability": known.probability,
        "age": known.age,
        "last_seen": known.last_seen,
        "in_view": known.last_seen == last,
        "hypotheses": dict(known.by_view),
    }


def worlds_of(panorama: Panorama) -> Joined:
    """The possible worlds of the last views together.

    Δh by name, an object's own or one of its rivals', which are rivals, and which are present.
    """
    if panorama.joint is None or panorama.ranking is None:
        return {"hypotheses": [], "rivals": [], "worlds": [], "unlisted_mass": [0.0, 0.0]}
    standing = {f"h{i}": some for i, some in enumerate(panorama.joint.standing, 1)}
    known = {id(k.standing): k.id for k in panorama.known}
    rivals = [h for h, some in standing.items() if id(some) not in known]
    name = {h: known.get(id(some)) or f"r{rivals.index(h) + 1}" for h, some in standing.items()}
    chance = panorama.ranking.marginals
    rows: list[StandingRow] = [
        {
            "id": name[h],
            "type": some.object_type.name,
            "opaque": some.object_type.opaque,
            "T_world_object": some.world_from_object.tolist(),
            "probability": chance[h],
        }
        for h, some in standing.items()
    ]
    pairs = sorted([name[a], name[b]] for a, b in panorama.joint.situation.rivals)
    worlds: list[WorldRow] = [
        {"probability": w.probability, "present": [name[h] for h in w.present]} for w in panorama.ranking.worlds
    ]
    return {"hypotheses": rows, "rivals": pairs, "worlds": worlds, "unlisted_mass": list(panorama.ranking.unlisted)}


def _open(joined: Joined) -> Joined:
    """The same where the search of some view was stopped.

    What was not found there may stand in the place of anything.
    """
    return {
        **joined,
        "hypotheses": [{**row, "interval": list(OPEN)} for row in joined["hypotheses"]],
        "worlds": [{**row, "interval": list(OPEN)} for row in joined["worlds"]],
        "unlisted_mass": list(OPEN),
        **marks(SEARCH),
    }


def ahead(panorama: Panorama, view: View) -> AheadRow:
    """What will be seen from where a view stands, as far as Δp knows; its Γ is not looked at."""
    return {"T_world_camera": view.world_from_camera.tolist(), "predicted": list(panorama.predicted(view))}
