"""What several views leave open, as a prospect in the world's frame.

And how a type is seen, straight from the knowledge base.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from plogic.sequence.next_view.expected import Body, Cloud, Prospect

if TYPE_CHECKING:
    from kb.clouds.cloud import KnowledgeBase, ObjectType
    from plogic.scene.worlds.ranked_worlds import Ranking
    from plogic.sequence.views.joint import Joint

SLACK = 0.004
"""Share of the diameter that the surface must be met before a feature to hide it, as where it is perceived."""


def cloud_of(kind: ObjectType, kb: KnowledgeBase) -> Cloud:
    """How a type is seen: all of its lobes."""
    features, surface, lobes = kind.seen_features, kind.surface, kind.lobes
    by_type = np.array([kb.rates.hit.get(feature.type, 0.8) for feature in features])
    points = np.array([feature.at for feature in features]).reshape(-1, 3) if surface is None else surface.vertices
    middle = (points.min(axis=0) + points.max(axis=0)) / 2.0
    return Cloud(
        kind.name,
        tuple(feature.name for feature in features),
        tuple(feature.type for feature in features),
        lobes,
        by_type[lobes.feature] if kind.learned is None else kind.learned.hit,
        None if surface is None else surface.rays,
        middle,
        float(np.linalg.norm(points - middle, axis=1).max()),
        0.0 if surface is None else SLACK * surface.diameter,
        kind.learned is not None,
    )


def prospect_of_views(found: Joint, ranking: Ranking, kb: KnowledgeBase) -> Prospect:
    """The listed worlds of what all views say together; the probabilities of what is listed are scaled to sum to 1."""
    kinds = {some.object_type.name: some.object_type for some in found.standing}
    clouds = {name: cloud_of(kind, kb) for name, kind in kinds.items()}
    rows = list(enumerate(found.standing, 1))
    bodies = tuple(
        Body(f"h{i}", clouds[s.object_type.name], s.world_from_object, s.object_type.opaque) for i, s in rows
    )
    place = {body.id: i for i, body in enumerate(bodies)}
    present = np.zeros((len(ranking.worlds), len(bodies)), bool)
    for w, world in enumerate(ranking.worlds):
        present[w, [place[name] for name in world.present]] = True
    mass = np.array([world.probability for world in ranking.worlds])
    rivals = frozenset(frozenset(pair) for pair in found.situation.rivals)
    return Prospect(bodies, present, mass / mass.sum(), rivals, kb.rates.clutter, kb.rates.match_tolerance, kb.f_ref)
