"""``panorama/1``: a sequence of views as a document, each with its interpretation, and Δp, what stands in the world after all of them."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final, NamedTuple

import numpy as np

from geometry.frames import compose, inverse, transform_points
from geometry.visibility.rays import RayMesh, behind
from plogic.facts.stopped import SEARCH, stopped_in
from plogic.scene.readings.unfinished import OPEN, marks
from plogic.sequence.constancy.decide import unknown_objects
from plogic.sequence.constancy.result import Constancy, constancy_document

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from geometry.arrays import Floats, Mask
    from plogic.facts.document import WorldRow
    from plogic.sequence import document
    from plogic.sequence.constancy.weights import Hidden
    from plogic.sequence.document import AheadRow, Joined, ObjectRow, StandingRow, ViewRow
    from plogic.sequence.views.panorama import Known, Look, Panorama
    from plogic.sequence.views.view import View


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
    views = [look.view for look in looks]
    bodies = []
    for known in panorama.known:
        kind = known.standing.object_type
        if kind.opaque and kind.surface is not None:
            bodies.append(Body(kind.surface.rays, known.standing.world_from_object))
    unexplained = {look.view.id: look.unexplained for look in looks}
    return unknown_objects(
        views, unexplained, panorama.perceiver.kb.rates, hiding(views, {view.id: bodies for view in views})
    )


FORMAT: Final = "panorama/1"


def panorama_document(
    panorama: Panorama, looks: Sequence[tuple[str, Look]], foreseen: Sequence[AheadRow] = ()
) -> document.Panorama:
    """The document of a sequence: ``looks`` with their frames' names, and what is ``foreseen`` where nothing was seen yet."""
    kb, joined = panorama.perceiver.kb, _worlds(panorama)
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


def _worlds(panorama: Panorama) -> Joined:
    """The possible worlds of the last views together: Δh by name, an object's own or one of its rivals', which are rivals, and which are present."""
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
    """The same where the search of some view was stopped: what was not found there may stand in the place of anything."""
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
