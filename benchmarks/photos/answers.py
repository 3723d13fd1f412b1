"""What is made of a photo: what is accepted and what the document claims.

* ``Shown``: a photo with its truth; ``Looked``: what perception came to; ``Answer``: the same, judged
"""

from __future__ import annotations

from time import perf_counter
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from benchmarks.photos.score import Posed
from benchmarks.photos.told import forecasts, type_of
from geometry.bodies.resting import Plane

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping

    from benchmarks.photos.told import Forecast
    from geometry.arrays import Bytes
    from geometry.camera import Camera
    from kb.clouds.cloud import KnowledgeBase
    from plogic.cycle.state import Cycle
    from plogic.facts.document import Interpretation
    from plogic.facts.hypothesis import Hypothesis
    from plogic.match.judged.type_models import TypeModel
    from plogic.run.bop.dataset import Dataset
    from plogic.run.bop.models import Model

VISIBLE = 0.1
"""What is less visible is not asked for."""


class Shown(NamedTuple):
    """A photo (H, W, 3), and what is there: asked for, too hidden to be asked for, and there without a pose."""

    name: str
    image: Bytes
    camera: Camera
    truths: tuple[Posed, ...]
    hidden: tuple[Posed, ...] = ()
    unposed: tuple[int, ...] = ()

    @property
    def neither(self) -> frozenset[int]:
        """Types that are there, of which what is accepted is neither right nor false."""
        return frozenset(self.unposed) | {some.obj_id for some in self.hidden}


class Answer(NamedTuple):
    """What was accepted, in how many seconds, and what the document claims with what came of it.

    ``first``: of each type the candidate that its pixels speak for most, accepted or not; ``plane``: the most probable
    of ``support_planes``.
    """

    shown: Shown
    ours: tuple[Posed, ...]
    seconds: float
    told: tuple[Forecast, ...]
    first: tuple[Posed, ...] = ()
    plane: Plane | None = None

    def said(self, names: Mapping[int, str]) -> str:
        """A line of progress."""
        found = ", ".join(names[some.obj_id] for some in self.ours) or "nothing"
        return f"photo {self.shown.name}: {found} in {self.seconds:.1f} s"


class Looked(NamedTuple):
    """The document of a photo, the cycle that it came from, and in how many seconds."""

    document: Interpretation
    cycle: Cycle
    seconds: float


def photos_of(dataset: Dataset) -> Iterator[Shown]:
    """The photos of a BOP dataset; ``present.json`` beside a scene names what is there without a pose."""
    from plogic.run.bop.json_files import numbered

    for scene_id, im_id in dataset.listed()[0]:
        scene = dataset.scene(scene_id)
        frame = scene.frame(im_id)
        truths: tuple[list[Posed], list[Posed]] = [], []
        for truth in scene.truths(im_id) or ():
            hidden = truth.visible is not None and truth.visible < VISIBLE
            truths[hidden].append(Posed(truth.obj_id, truth.camera_from_object))
        beside = scene.folder / "present.json"
        unposed = tuple(numbered(beside).get(im_id, ())) if beside.exists() else ()
        yield Shown(f"{scene_id}/{im_id}", frame.image, frame.camera, tuple(truths[0]), tuple(truths[1]), unposed)


def planes_of(document: Interpretation) -> dict[str, Plane]:
    """The planes that a document tells, by name, the most probable first."""
    return {
        row["name"]: Plane(np.array(row["plane"]["normal"]), -float(row["plane"]["offset"]))
        for row in sorted(document.get("support_planes", ()), key=lambda row: -row["probability"])
    }


class Looker:
    """A knowledge base that is asked what photos show, its types known by BOP numbers.

    Raises InputError where no detector reports a type of it.
    """

    def __init__(self, kb: KnowledgeBase, numbers: Mapping[str, int]) -> None:
        from plogic.run.perceive import perceiver_of

        self.kb, self.numbers = kb, {kind.name: numbers[kind.name] for kind in kb.types if kind.name in numbers}
        self._perceiver = perceiver_of(kb)

    def looked(self, shown: Shown) -> Looked:
        """Perceive a photo; seconds are those until it is known what is accepted."""
        from plogic.base.clock import Stopwatch
        from plogic.cycle.delta import Options
        from plogic.run.sources import detected

        options, clock = Options(reading="posterior"), Stopwatch()
        start = perf_counter()
        gamma = detected(shown.image, shown.camera, self.kb, clock)
        found = self._perceiver.cycle(gamma, options, clock, image=shown.image)
        seconds = perf_counter() - start
        return Looked(self._perceiver.document(gamma, *found, options, shown.image, clock), found[1], seconds)

    def answer(self, shown: Shown, models: Mapping[int, Model]) -> Answer:
        """Perceive a photo, and what came of it."""
        document, cycle, seconds = self.looked(shown)
        told = forecasts(document, self.numbers, shown, models)
        mine, plane = tuple(self.accepted(document).values()), next(iter(planes_of(document).values()), None)
        return Answer(shown, mine, seconds, tuple(told), self._first(cycle), plane)

    @property
    def models(self) -> Mapping[str, TypeModel]:
        """Its types made ready."""
        return self._perceiver.models

    def _first(self, cycle: Cycle) -> tuple[Posed, ...]:
        best: dict[str, Hypothesis] = {}
        for posed in sorted(
            (*cycle.accepted, *cycle.considered, *cycle.rejected),
            key=lambda h: -(-np.inf if h.pixels is None else h.pixels),
        ):
            best.setdefault(posed.type, posed)
        return tuple(Posed(self.numbers[t], h.camera_from_object) for t, h in best.items() if t in self.numbers)

    def accepted(self, document: Interpretation) -> dict[str, Posed]:
        """The accepted objects of types that have a number, by the names of their hypotheses."""
        rows = [(type_of(h), h) for h in document["hypotheses"] if h["status"] == "accepted"]
        return {h["id"]: Posed(self.numbers[t], np.array(h["T_camera_object"])) for t, h in rows if t in self.numbers}
