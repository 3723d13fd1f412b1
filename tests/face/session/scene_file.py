"""A situation as the least ``interpretation/1`` document that ``situation_of`` reads back."""

from __future__ import annotations

from typing import Any

from situations import towers

from plogic.facts.interpretation import FORMAT, facts_of, hypothesis_document


def towers_document() -> dict[str, Any]:
    """The two towers of §8: t1 hides what is missed of t2; the distorted t2 shares volume with it."""
    situation = towers()
    hypotheses = [hypothesis_document(h, {f.id: (True, True, None) for f in h.features}) for h in situation.hypotheses]
    return {
        "format": FORMAT,
        "reading": situation.reading,
        "reconsider": situation.reconsider,
        "smoothing": situation.smoothing,
        "hypotheses": [{**h, "status": "accepted"} for h in hypotheses],
        "appearances": [
            {"id": a.id, "type": a.type, "uv": list(a.uv), "clutter": a.clutter} for a in situation.appearances
        ],
        "facts": facts_of(situation),
        "priors": situation.priors,
        "measures": {"dv": situation.dv, "rank": situation.rank},
        "rules": situation.rules,
    }
