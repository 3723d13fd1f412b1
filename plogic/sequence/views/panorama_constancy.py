"""Constancy over a panorama: what its looks left unexplained, beside the bodies that stand in Δp."""

from __future__ import annotations

from typing import TYPE_CHECKING

from plogic.sequence.constancy.decide import unknown_objects
from plogic.sequence.constancy.hiding import Body, hiding

if TYPE_CHECKING:
    from collections.abc import Sequence

    from plogic.sequence.constancy.result import Constancy
    from plogic.sequence.views.panorama import Look, Panorama


def constancy_of(panorama: Panorama, looks: Sequence[Look]) -> Constancy:
    """What is unknown, noise or undecided of all ``looks`` so far; the opaque objects of Δp hide what they hide in each (D4)."""
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
