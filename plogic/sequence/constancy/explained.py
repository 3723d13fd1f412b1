"""What an interpretation leaves unexplained: the data that constancy is about."""

from __future__ import annotations

from typing import TYPE_CHECKING

from plogic.scene.worlds.causes import NOISE

if TYPE_CHECKING:
    from plogic.facts.document import Interpretation


def unexplained_of(document: Interpretation) -> tuple[str, ...]:
    """Ids, in the order of Γ, of the appearances of an ``interpretation/1`` that nothing accepted causes in its most probable world.

    A cause is a feature, "h1/roof/apex", of a hypothesis whose status is accepted; anything else leaves its datum
    unexplained.
    """
    accepted = {h["id"] for h in document["hypotheses"] if h["status"] == "accepted"}
    causes = document["worlds"][0]["causes"] if document["worlds"] else {}
    return tuple(
        a["id"] for a in document["appearances"] if causes.get(a["id"], NOISE).split("/", 1)[0] not in accepted
    )
