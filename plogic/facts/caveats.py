"""What the worlds of an interpretation do not weigh, or had to assume."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from plogic.facts.document import Interpretation


UNWEIGHED = "it would stand in the place of what it conflicts with, but others are better, and no more are weighed"
"""Why a rival is in no world, in words."""


def caveats(document: Interpretation) -> list[str]:
    """A sentence for each accepted hypothesis some of whose rivals are in no world, and for smoothing not asked for."""
    names = {h["id"]: f"{h.get('label') or h['type']} {h['id']}" for h in document["hypotheses"]}
    cut = [
        f"{names.get(name, name)} has {number} more rival{'s' * (number > 1)}, less likely than those weighed or too "
        "many, in no world: probabilities are among what is weighed"
        for name, number in document.get("unweighed", {}).items()
    ]
    return [*cut, *(step["why"] for step in document.get("trace", []) if step["event"] == "smooth")]
