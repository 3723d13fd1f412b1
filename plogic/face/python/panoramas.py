"""``Panorama``: several views of one place, interpreted one after the other, and what they say together."""

import warnings
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from geometry.camera import Camera
from plogic.base.errors import InputError
from plogic.cycle.delta import Options
from plogic.face.python.interpretation import Interpretation
from plogic.face.python.knowledge import KnowledgeBase
from plogic.face.python.perceiving import checked, gamma_and_image, loaded
from plogic.face.python.pictures import Image
from plogic.face.session.blocks import Block, Column, Result, Rows, Table
from plogic.face.session.results import World, Worlds
from plogic.face.shown.figures import chance
from plogic.facts.interpretation import text_of
from plogic.facts.situation import Reading, Reconsider
from sensing import appearance
from sensing.files.whole_files import write_whole

if TYPE_CHECKING:
    from plogic.sequence import document as rows


@dataclass(frozen=True, eq=False)
class PlacedObject:
    """An object of the world: ``T_world_object`` (4, 4) maps points of its frame to the world's, metres.

    ``age``: views since the one that should show it last, ``last_seen``; ``hypotheses``: which one it was of a view's
    interpretation, ``{"v1": "h2"}``.
    """

    id: str
    type: str
    T_world_object: NDArray[np.float64]
    probability: float
    age: int
    last_seen: str
    hypotheses: dict[str, str]


@dataclass(frozen=True, repr=False)
class PlacedObjects(Rows[PlacedObject]):
    """What stands in the world after the views so far, by name."""

    objects: tuple[PlacedObject, ...]

    @property
    def rows(self) -> tuple[PlacedObject, ...]:
        """The objects."""
        return self.objects

    def blocks(self) -> tuple[Block, ...]:
        """One table; places are those of the origins of the objects' frames."""
        right = ("probability", "x, m", "y, m", "z, m")
        columns = (Column("object"), *(Column(name, right=True) for name in right), Column("last seen"))
        cells = tuple(
            (f"{o.type} {o.id}", chance(o.probability), *(f"{v:.3f}" for v in o.T_world_object[:3, 3]), o.last_seen)
            for o in self.objects
        )
        return (Table("objects in the world", columns, cells),)


def _pose(given: ArrayLike) -> NDArray[np.float64]:
    """Numbers as an array; whether they are a pose is looked at elsewhere. Raises InputError where they are none."""
    try:
        return np.asarray(given, np.float64)
    except (TypeError, ValueError) as error:
        raise InputError("T_world_camera: should be 4x4 numbers, m") from error


class Panorama(Result):
    """Several views of one place that stands still, from cameras whose poses are known.

    >>> place = Panorama("mykb")
    >>> for photo, pose in zip(photos, poses): place.look(photo, camera, pose)
    >>> place.objects
    """

    def __init__(
        self,
        kb: KnowledgeBase | str | Path,
        *,
        reading: Reading = "score",
        reconsider: Reconsider = "to_B",
        generator: str = "index",
    ) -> None:
        """Begin without a view; ``kb`` and the options are those of ``perceive``.

        Raises:
            Error: where any of these cannot be used.
        """
        from plogic.sequence.views.panorama import Look
        from plogic.sequence.views.panorama import Panorama as Memory

        checked(reading, reconsider, "types")
        self.kb = loaded(kb)
        self._memory = Memory(self.kb.perceiver(generator), Options(reading, reconsider))
        self._looks: list[tuple[str, Look]] = []

    def look(
        self,
        source: Image | appearance.Gamma,
        camera: Camera | str | Path | None = None,
        T_world_camera: ArrayLike | None = None,
    ) -> Interpretation:
        """Interpret one more view beside those before it, and return it alone.

        Args:
            source: an image or Γ, as ``perceive`` takes them.
            camera: an image's camera; Γ has its own.
            T_world_camera: (4, 4), m, maps the camera's coordinates to the world's; without it the camera's own pose.

        Raises:
            Error: where any of these cannot be used, or the pose is not known; the views before it stay.
        """
        from plogic.sequence.constancy.sight_lines import View

        gamma, image = gamma_and_image(source, self.kb, camera)
        pose = gamma.camera.world_from_camera if T_world_camera is None else _pose(T_world_camera)
        if T_world_camera is None and pose is not None and self._has_been(pose):
            what = "taken to be from the place of an earlier view: where the camera moved, give T_world_camera"
            warnings.warn(what, stacklevel=2)
        if pose is None:
            raise InputError(
                "T_world_camera: is not given, and the camera tells none: where the view is from is not known"
            )
        placed = replace(gamma, camera=replace(gamma.camera, world_from_camera=pose))
        number = len(self._looks) + 1
        look = self._memory.look(View(f"v{number}", placed, pose), image)
        self._looks.append((str(source) if isinstance(source, str | Path) else f"view {number}", look))
        return Interpretation(look.interpretation, image=image)

    def _has_been(self, pose: NDArray[np.float64]) -> bool:
        return any(np.array_equal(pose, look.view.world_from_camera) for _, look in self._looks)

    @property
    def document(self) -> "rows.Panorama":
        """The ``panorama/1`` document of the views so far, as ``plogic perceive`` of several views writes it."""
        from plogic.sequence.views.panorama import panorama_document

        return panorama_document(self._memory, self._looks)

    @property
    def views(self) -> tuple[Interpretation, ...]:
        """The views so far, each by itself."""
        return tuple(Interpretation(look.interpretation) for _, look in self._looks)

    @property
    def objects(self) -> PlacedObjects:
        """What stands in the world."""
        return PlacedObjects(
            tuple(
                PlacedObject(
                    known.id,
                    known.standing.object_type.name,
                    known.standing.world_from_object,
                    known.probability,
                    known.age,
                    known.last_seen,
                    dict(known.by_view),
                )
                for known in self._memory.known
            )
        )

    @property
    def worlds(self) -> Worlds:
        """The possible worlds of the last views together."""
        from plogic.sequence.views.panorama import worlds_of

        document = worlds_of(self._memory)
        listed = tuple(
            World(w["probability"], tuple(w["present"]), None, (w["probability"], w["probability"]))
            for w in document["worlds"]
        )
        low, high = document["unlisted_mass"]
        return Worlds(listed, (low, high), (), {row["id"]: row["type"] for row in document["hypotheses"]})

    def save(self, path: str | Path) -> Path:
        """Write a ``panorama.json``, whole or not at all, and return its path."""
        write_whole(Path(path), text_of(self.document).encode())
        return Path(path)

    def blocks(self) -> tuple[Block, ...]:
        """The objects and the worlds."""
        return (*self.objects.blocks(), *self.worlds.blocks())
