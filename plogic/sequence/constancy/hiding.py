"""What the accepted objects' bodies hide (D4), for places in the world: a place that is hidden is not missed where it is not seen.

Vocabulary: ``Body``, ``Body(surface.rays, world_from_object)``.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from geometry.frames import compose, inverse, transform_points
from geometry.visibility.rays import behind

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from numpy.typing import NDArray

    from geometry.visibility.rays import RayMesh
    from kb.clouds.cloud import KnowledgeBase
    from plogic.facts.document import Interpretation
    from plogic.sequence.constancy.weights import Hidden
    from plogic.sequence.views.view import View

    Floats = NDArray[np.float64]


class Body(NamedTuple):
    """An opaque surface where it stands: ``world_from_object`` (4, 4)."""

    rays: RayMesh
    world_from_object: Floats


def hiding(views: Sequence[View], bodies: Mapping[str, Sequence[Body]]) -> Hidden:
    """The callback that ``unknown_objects`` takes: which places (N, 3) m, world, some body hides from a view; ``bodies`` by the view's id."""
    camera_from_world = {view.id: inverse(view.world_from_camera) for view in views}

    def hidden(view: str, world: Floats) -> NDArray[np.bool_]:
        frame = camera_from_world[view]
        points = transform_points(frame, world)
        masks = [behind(points, body.rays, compose(frame, body.world_from_object)) for body in bodies.get(view, ())]
        return np.any(np.array(masks, bool).reshape(len(masks), len(world)), axis=0)

    return hidden


def bodies_of(kb: KnowledgeBase, view: View, document: Interpretation) -> list[Body]:
    """The opaque bodies of what an ``interpretation/1`` of the view accepts; a type that the KB has not, or without a mesh, hides nothing."""
    known = {kind.name: kind for kind in kb.types}
    bodies = []
    for row in document["hypotheses"]:
        kind = known.get(row["type"])
        if row["status"] == "accepted" and kind is not None and kind.surface is not None and kind.opaque:
            bodies.append(Body(kind.surface.rays, compose(view.world_from_camera, np.array(row["T_camera_object"]))))
    return bodies
