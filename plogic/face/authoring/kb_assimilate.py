"""``plogic kb assimilate``: an unknown object of a panorama becomes a draft of a type in the knowledge base."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Any

from plogic.base.errors import InputError
from plogic.face.authoring.kb_types import check_own, check_places, write_types
from plogic.run.sources import kb_of

if TYPE_CHECKING:
    from collections.abc import Sequence

    from kb.clouds.cloud import KnowledgeBase, ObjectType
    from kb.intake.new_type import NewType
    from plogic.sequence.constancy.result import SeenFeature


def assimilate_command(panorama: str, unknown: str, kb_folder: str, name: str, *, as_json: bool) -> str:
    """Write the type's folder, whole or not at all, and never over another; the text says what the draft has and what it has not.

    Raises InputError, IntakeError, KBError, SensingError.
    """
    from kb.intake.new_type import check_name
    from plogic.sequence.constancy.panorama_reading import unknown_of

    kb = kb_of(kb_folder)
    folder = check_own(kb_folder)
    check_name(name)
    check_places(folder, [name])
    features = unknown_of(panorama, unknown)
    _check_features(features, kb, panorama, unknown)
    new = draft_files(name, features, kb, f"{unknown} of {panorama}")
    write_types(folder, [new])
    where = folder / "objects" / name
    if as_json:
        return json.dumps(
            {"format": "kb_assimilate/1", "kb": str(folder), "type": new.document | {"notes": list(new.notes)}}
        )
    return "\n".join([*new.lines, *(f"  note: {note}" for note in new.notes), f"wrote {where}"])


def _check_features(features: Sequence[SeenFeature], kb: KnowledgeBase, panorama: str, unknown: str) -> None:
    """Raise InputError where no pose could be taken from the draft, or the KB has not its appearance types."""
    from kb.shown.cautions import FIXING_A_POSE

    if len(features) < FIXING_A_POSE:
        raise InputError(
            f"{panorama}: {unknown} has {len(features)} features, and a pose is taken from {FIXING_A_POSE}: look at it again from elsewhere"
        )
    strange = sorted({feature.type for feature in features} - set(kb.appearance_types))
    if strange:
        raise InputError(
            f"{panorama}: {', '.join(strange)[:200]}: no appearance types of {kb.name}; add them to kb.yaml"
        )


def draft_files(name: str, features: Sequence[SeenFeature], kb: KnowledgeBase, origin: str) -> NewType:
    """The draft's files, and what is told of it."""
    from kb.files.write import obj_text, object_text
    from kb.intake.new_type import EDITOR_LINE, NewType
    from plogic.sequence.constancy.result import draft_type

    kind = draft_type(name, features, kb.f_ref)
    comment = "".join(sign if " " <= sign <= "~" else "?" for sign in origin)
    lines = [f"# A draft, made from {comment[:200]}: features where they were seen, lobes from where they were."]
    lines += (
        ["# The body is the convex hull of the features, made smaller until it hides nothing that was seen."]
        if kind.surface
        else []
    )
    text = EDITOR_LINE + "\n".join(lines) + "\n" + object_text(kind, "mesh.obj" if kind.surface else None)
    files = {"object.yaml": text.encode()} | ({"mesh.obj": obj_text(kind.surface).encode()} if kind.surface else {})
    document = _document(kind)
    return NewType(name, files, document, tuple(_lines(document)), tuple(_notes(document)))


def _document(kind: ObjectType) -> dict[str, Any]:
    import numpy as np

    at = np.array([feature.at for feature in kind.features])
    types = sorted({feature.type for feature in kind.features})
    return {
        "type": kind.name,
        "features": len(kind.features),
        "feature_types": {name: sum(feature.type == name for feature in kind.features) for name in types},
        "extent_m": np.ptp(at, axis=0).tolist(),
        "mesh": "hull" if kind.surface is not None else None,
        "opaque": kind.opaque,
    }


def _lines(document: dict[str, Any]) -> list[str]:
    sides = " x ".join(f"{side:.4g}" for side in document["extent_m"])
    counts = ", ".join(f"{count} {name}" for name, count in document["feature_types"].items())
    return [f"{document['type']}: a draft of {document['features']} features, {sides} m", f"  {counts}"]


def _notes(document: dict[str, Any]) -> list[str]:
    body = "the mesh is a hull of the features: a draft; replace it with the real one" if document["mesh"] else NO_BODY
    return [body, "it has features only where it was looked at; symmetries and parts are for you to say"]


NO_BODY = "there is no mesh, so that it hides nothing and may share space with others: its features span no volume that leaves all seen that was"
