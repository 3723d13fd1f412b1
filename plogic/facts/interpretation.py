"""``interpretation.json``: one image's Δ, self-contained, so that no KB or image has to be at hand to ask it anything.

``document_of`` writes what the cycle and the worlds came to; ``situation_of`` reads the typed situation back; the two
are inverse on everything that decides a probability (tested).
"""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Any, get_args

import numpy as np

from geometry.files.plain_files import JsonError, json_of
from plogic.base.errors import InterpretationError, SituationError
from plogic.facts.gravity import gravity_facts, gravity_of
from plogic.facts.hypothesis import FeatureFact, Hypothesis, PartFact
from plogic.facts.sanity import check
from plogic.facts.situation import AppearanceFact, PairFact, Reading, Reconsider, Situation
from plogic.facts.spatial import overlap_document, space_of
from plogic.facts.stopped import stopped_in

if TYPE_CHECKING:
    from collections.abc import Mapping
    from pathlib import Path

FORMAT = "interpretation/1"
LARGEST = 256 * 2**20
"""Bytes of an interpretation that is read."""

Document = dict[str, Any]


def facts_of(situation: Situation) -> list[Document]:
    """The facts between hypotheses, in a fixed order."""
    pairs = [("overlap", situation.overlaps), ("rival", situation.rivals), ("exclusive", situation.exclusive)]
    facts: list[Document] = [{"fact": name, "args": list(pair)} for name, found in pairs for pair in sorted(found)]
    facts = [overlap_document(fact, situation.space) if fact["fact"] == "overlap" else fact for fact in facts]
    facts += gravity_facts(situation.gravity)
    facts += [{"fact": "relation"} | _relation_document(r) for r in situation.relations]
    facts += [
        {"fact": "part_relation"} | _relation_document(r) | {"parts": list(r.parts)} for r in situation.part_relations
    ]
    for h in situation.hypotheses:
        facts += [{"fact": "behind", "args": [f"{h.id}/{f.id}", other]} for f in h.features for other in f.hidden_by]
    return facts


def situation_of(document: Mapping[str, Any]) -> Situation:
    """The typed situation of an interpretation. Raises InterpretationError, one line, where it is none."""
    if document.get("format") != FORMAT:
        raise InterpretationError(f"format: {document.get('format')!r} should be {FORMAT!r}")
    try:
        return _situation(document)
    except (KeyError, TypeError, ValueError, AttributeError, IndexError) as error:
        what = f"the key {error} is missing" if isinstance(error, KeyError) else str(error)
        raise InterpretationError(f"not a complete {FORMAT}: {what}") from error


def _situation(document: Mapping[str, Any]) -> Situation:
    facts = document["facts"]
    for key, allowed in (("reading", get_args(Reading)), ("reconsider", get_args(Reconsider))):
        if document[key] not in allowed:
            raise InterpretationError(f"{key}: {document[key]!r:.60} should be one of {', '.join(allowed)}")
    return Situation(
        reading=document["reading"],
        reconsider=document["reconsider"],
        smoothing=float(document["smoothing"]),
        hypotheses=tuple(_hypothesis(h) for h in document["hypotheses"] if h["status"] != "rejected"),
        appearances=tuple(
            AppearanceFact(a["id"], a["type"], (float(a["uv"][0]), float(a["uv"][1])), float(a["clutter"]))
            for a in document["appearances"]
        ),
        overlaps=_pairs(facts, "overlap"),
        rivals=_pairs(facts, "rival"),
        exclusive=_pairs(facts, "exclusive"),
        space=space_of(document.get("space"), facts),
        gravity=gravity_of(document.get("gravity"), facts),
        relations=tuple(_relation(f) for f in facts if f["fact"] == "relation"),
        part_relations=tuple(_relation(f) for f in facts if f["fact"] == "part_relation"),
        priors=dict(document["priors"]),
        dv=dict(document["measures"]["dv"]),
        rank=dict(document["measures"]["rank"]),
        rules=document["rules"],
        stopped=stopped_in(document),
    )


def _relation_document(r: PairFact) -> Document:
    return {"relation": r.relation, "args": [r.x, r.y]} | ({"roc": r.roc} if r.roc else {})


def _relation(fact: Mapping[str, Any]) -> PairFact:
    """Documents of before ROC-20 tell the coarse relation alone."""
    x, y = fact["args"]
    of_x, of_y = fact.get("parts", ("", ""))
    return PairFact(fact["relation"], x, y, fact.get("roc", ""), (of_x, of_y))


def _pairs(facts: list[Document], name: str) -> frozenset[tuple[str, str]]:
    return frozenset((f["args"][0], f["args"][1]) for f in facts if f["fact"] == name)


def _hypothesis(h: Mapping[str, Any]) -> Hypothesis:
    return Hypothesis(
        id=h["id"],
        type=h["type"],
        camera_from_object=np.array(h["T_camera_object"], np.float64),
        opaque=bool(h["opaque"]),
        group=h["group"],
        features=tuple(_feature(f) for f in h["features"]),
        parts=tuple(PartFact(p["id"], p["parent"], p["kind"], p["type"]) for p in h["parts"]),
    )


def _feature(f: Mapping[str, Any]) -> FeatureFact:
    known = {name: f[name] for name in FeatureFact.__dataclass_fields__ if name != "stands_for"}
    known["stands_for"] = int(f.get("stands_for", 1))
    known |= {"at": tuple(f["at"]), "uv": tuple(f["uv"]), "hidden_by": tuple(f["hidden_by"])}
    return FeatureFact(**known)


def hypothesis_document(h: Hypothesis, cases: Mapping[str, tuple[bool, bool, str | None]]) -> Document:
    """One hypothesis as in the file; ``cases`` gives (expected, detected, case) of each feature in Δi."""
    row: Document = {
        "id": h.id,
        "type": h.type,
        "opaque": h.opaque,
        "group": h.group,
        "features": [dict(vars(feature)) for feature in h.features],
        "parts": [dict(vars(part)) for part in h.parts],
        "T_camera_object": h.camera_from_object.tolist(),
    }
    for feature in row["features"]:
        expected, detected, case = cases[feature["id"]]
        feature |= {"expected": expected, "detected": detected, "case": case}
        feature |= {key: list(feature[key]) for key in ("at", "uv", "hidden_by")}
        if feature["stands_for"] == 1:
            del feature["stands_for"]
    return row


def text_of(document: Mapping[str, Any]) -> str:
    """The file's text: the same document gives the same bytes."""
    return json.dumps(document, ensure_ascii=False, allow_nan=False, separators=(",", ":")) + "\n"


def read_interpretation(path: Path | str) -> Document:
    """Read ``interpretation.json``; '-' is stdin. Raises InterpretationError, one line."""
    name = "<stdin>" if str(path) == "-" else str(path)
    return interpretation_in(parsed(path), name)


def interpretation_in(document: object, name: str, formats: str = "{}") -> Document:
    """What was read as one; ``name`` tells its file, ``formats`` which formats it could have been. Raises InterpretationError, one line."""
    if not isinstance(document, dict) or document.get("format") != FORMAT:
        raise InterpretationError(f"{name}: format: should be {formats.format(repr(FORMAT))}")
    try:
        check(situation_of(document))
    except (InterpretationError, SituationError) as error:
        raise InterpretationError(f"{name}: {error}") from None
    return document


def parsed(path: Path | str) -> object:
    """The JSON of a file; '-' is stdin. Raises InterpretationError, one line."""
    try:
        return json_of(path, LARGEST, "it should hold what a picture shows", finite=True)
    except JsonError as error:
        raise InterpretationError(str(error)) from None
