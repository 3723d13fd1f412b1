"""A hypothesis that is seen in another image: nobody knows where it would stand in this one."""

from collections.abc import Sequence
from typing import Any, cast

from plogic.base.errors import InputError
from plogic.facts.document import Interpretation
from plogic.facts.interpretation import evidence_row, read_interpretation
from plogic.sequence.unposed.reading import evidence, withheld


def without_poses(document: Interpretation, named: Sequence[str]) -> Interpretation:
    """The document without the poses of those that are ``named``: ``h2``, or ``other.json:h2`` of another image.

    Raises InputError, InterpretationError.
    """
    ids = {h["id"] for h in document["hypotheses"]}
    there = [text for text in named if ":" in text and text not in ids]
    here = [text for text in named if text not in there]
    document = withheld(document, here) if here else document
    for text in there:
        file, _, name = text.rpartition(":")
        document = with_elsewhere(document, read_interpretation(file), name)[0]
    return document


def with_elsewhere(document: Interpretation, other: Interpretation, name: str) -> tuple[Interpretation, str]:
    """The document with a hypothesis of another one, and its name there: the first ``h7`` that is free.

    It is as probable as its own image makes it: what it is matched to is taken along as data of this Γ. How it stands
    to what is accepted here is told by evidence, which knows nothing of it but what it would hide.

    Raises InputError where the other has no such hypothesis, or was perceived with another knowledge base.
    """
    rows = {h["id"]: h for h in other["hypotheses"] if h["status"] != "rejected"}
    if name not in rows:
        raise InputError(
            f"{name}: should be among the other image's {', '.join(rows) or 'hypotheses, of which it has none'}"
        )
    if document.get("kb") != other.get("kb"):
        raise InputError("the other image was perceived with another knowledge base")
    taken = {h["id"] for h in document["hypotheses"]}
    new = next(f"h{i}" for i in range(1, len(taken) + 2) if f"h{i}" not in taken)
    with_it = _added(document, other, name, new)
    return {**with_it, "facts": [*with_it["facts"], evidence_row(evidence(with_it, [new], elsewhere=True))]}, new


def _added(document: Interpretation, other: Interpretation, name: str, new: str) -> Interpretation:
    """Its row and its data under names of their own, and what Σo says of its type."""
    row = next(h for h in other["hypotheses"] if h["id"] == name)
    matched = {f["match"] for f in row["features"] if f["match"] is not None}
    own = {a: f"{new}_{a}" for a in matched}
    features = [{**f, "match": own.get(f["match"] or ""), "hidden_by": []} for f in row["features"]]
    added = {**row, "id": new, "group": f"{new}_instance", "features": features}
    if "pixels_beside" in row:  # nobody of the other image is before it here
        alone = [told for told in row["pixels_beside"] if not told["present"]]
        added |= {"pixels_beside": alone, "pixels_left_out": []}
    data = [{**a, "id": own[a["id"]]} for a in other["appearances"] if a["id"] in own]
    changed: dict[str, Any] = {
        "hypotheses": [*document["hypotheses"], added],
        "appearances": [*document["appearances"], *data],
        "types": {**other.get("types", {}), **document.get("types", {})},
        "priors": {**other["priors"], **document["priors"]},
        "measures": {
            **document["measures"],
            "dv": {**other["measures"]["dv"], **document["measures"]["dv"]},
            "rank": {**other["measures"]["rank"], **document["measures"]["rank"]},
        },
        "assets": {
            **document.get("assets", {}),
            "meshes": {**other.get("assets", {}).get("meshes", {}), **document.get("assets", {}).get("meshes", {})},
        },
    }
    return cast("Interpretation", {**document, **changed})
