"""Data that an interpretation leaves unexplained, which constancy is about, and the bodies of what it accepts."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from geometry.frames import compose
from plogic.scene.worlds.causes import NOISE
from plogic.sequence.views.panorama import Body

if TYPE_CHECKING:
    from kb.clouds.cloud import KnowledgeBase
    from plogic.facts.document import Interpretation
    from plogic.sequence.constancy.sight_lines import View


def unexplained_of(document: Interpretation) -> tuple[str, ...]:
    """Return the ids of the appearances that nothing accepted causes in the most probable world, in the order of Γ.

    A cause is a feature, "h1/roof/apex", of a hypothesis whose status is accepted; anything else leaves its datum
    unexplained.
    """
    accepted = {h["id"] for h in document["hypotheses"] if h["status"] == "accepted"}
    causes = document["worlds"][0]["causes"] if document["worlds"] else {}
    return tuple(
        a["id"] for a in document["appearances"] if causes.get(a["id"], NOISE).split("/", 1)[0] not in accepted
    )


def bodies_of(kb: KnowledgeBase, view: View, document: Interpretation) -> list[Body]:
    """Return the opaque bodies of what an ``interpretation/1`` of the view accepts.

    A type that the KB has not, or without a mesh, hides nothing.
    """
    known = {kind.name: kind for kind in kb.types}
    bodies = []
    for row in document["hypotheses"]:
        kind = known.get(row["type"])
        if row["status"] == "accepted" and kind is not None and kind.surface is not None and kind.opaque:
            bodies.append(Body(kind.surface.rays, compose(view.world_from_camera, np.array(row["T_camera_object"]))))
    return bodies
