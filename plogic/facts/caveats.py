"""What the worlds of an interpretation do not weigh, had to assume, or contradict."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from plogic.facts.document import Interpretation


UNWEIGHED = "it would stand in the place of what it conflicts with, but others are better, and no more are weighed"
"""Why a rival is in no world, in words."""


def caveats(document: Interpretation) -> list[str]:
    """A sentence for each accepted hypothesis some of whose rivals are in no world, and for smoothing not asked for.

    And one where the accepted objects contradict the camera.
    """
    told, rows = document.get("unweighed", {}), document.get("hypotheses", [])
    names = {h["id"]: f"{h.get('label') or h['type']} {h['id']}" for h in rows if h.get("id") in told}
    cut = [
        f"{names.get(name, name)} has {number} more rival{'s' * (number > 1)}, less likely than those weighed or too "
        "many, in no world: probabilities are among what is weighed"
        for name, number in told.items()
    ]
    smoothed = [step["why"] for step in document.get("trace", []) if step["event"] == "smooth"]
    return [*cut, *smoothed, *([document["camera_doubt"]["why"]] if "camera_doubt" in document else [])]
