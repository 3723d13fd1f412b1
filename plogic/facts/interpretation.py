"""``interpretation.json``: one image's Δ, self-contained, so that no KB or image has to be at hand to ask it anything.

``document_of`` writes what the cycle and the worlds came to; ``situation_of`` reads the typed situation back; the two
are inverse on everything that decides a probability (tested). A file is held to the shape of
``plogic.facts.document`` and then to ``plogic.facts.sanity``; each tells all of its mistakes.
"""

import json
from collections.abc import Iterator, Mapping, Sequence
from math import isnan, nan
from pathlib import Path
from typing import TYPE_CHECKING, Final, cast

import numpy as np

from geometry.errors import Mistake
from geometry.files.documents import Document, parsed_json, read_json
from geometry.files.plain_files import name_of
from geometry.printable import shown
from plogic.base.errors import InterpretationError
from plogic.facts.carried_rows import TypeRow
from plogic.facts.document import (
    Case,
    FeatureRow,
    HypothesisFacts,
    HypothesisRow,
    Interpretation,
    LearnedKey,
    LookedRow,
    StandsKey,
)
from plogic.facts.fact_rows import EvidenceRow, Fact, RelatedRow, StateRow
from plogic.facts.hypothesis import FeatureFact, Hypothesis, PartFact
from plogic.facts.pixel_table import table_of
from plogic.facts.sanity import faults
from plogic.facts.situation import (
    OTHERS,
    AppearanceFact,
    EvidenceFact,
    LookFact,
    PairFact,
    Situation,
    TypeFact,
    stopped_in,
)
from plogic.facts.spatial import gravity_facts, gravity_of, overlap_document, space_of
from plogic.facts.stances import support_of

if TYPE_CHECKING:
    from geometry.visibility.roc import Roc

FORMAT: Final = "interpretation/1"
LARGEST = 256 * 2**20
"""Bytes of an interpretation that is read."""
HOLDS = "it should hold what a picture shows"
OF_SEVERAL = ", of one view: a panorama/1 has one for each, views[i].interpretation; ask that, as a file of its own"


def facts_of(situation: Situation) -> list[Fact]:
    """The facts between hypotheses, in a fixed order."""
    facts: list[Fact] = [overlap_document(pair, situation.space) for pair in sorted(situation.overlaps)]
    facts += [{"fact": "rival", "args": list(pair)} for pair in sorted(situation.rivals)]
    facts += [{"fact": "exclusive", "args": list(pair)} for pair in sorted(situation.exclusive)]
    facts += gravity_facts(situation.gravity)
    facts += [{"fact": "relation", **_related(r)} for r in situation.relations]
    facts += [{"fact": "part_relation", **_related(r), "parts": list(r.parts)} for r in situation.part_relations]
    facts += [evidence_row(e) for e in situation.evidence]
    facts += [
        {"fact": "behind", "args": [f"{h.id}/{f.id}", other]}
        for h in situation.hypotheses
        for f in h.features
        for other in f.hidden_by
    ]
    return facts


def situation_of(document: Interpretation) -> Situation:
    """The typed situation of an interpretation, written here or read by ``interpretation_in``."""
    facts = document["facts"]
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
        support=support_of(document),
        relations=tuple(_relation(f) for f in facts if f["fact"] == "relation"),
        part_relations=tuple(
            _relation(f, (f["parts"][0], f["parts"][1])) for f in facts if f["fact"] == "part_relation"
        ),
        evidence=tuple(_evidence(f) for f in facts if f["fact"] == "evidence"),
        priors=dict(document["priors"]),
        dv=dict(document["measures"]["dv"]),
        dv_over=document["measures"].get("dv_over", "types"),
        rank=dict(document["measures"]["rank"]),
        types={name: type_of(row) for name, row in document.get("types", {}).items()},
        rules=document["rules"],
        stopped=stopped_in(document),
    )


def evidence_row(e: EvidenceFact) -> EvidenceRow:
    """As in ``facts`` of the document."""
    states: list[StateRow] = [{"probability": p, "relations": list(relations)} for p, relations in e.states]
    pairs = [list(pair) for pair in e.pairs]
    return {"fact": "evidence", "pairs": pairs, "withheld": list(e.withheld), "states": states}


def _evidence(row: EvidenceRow) -> EvidenceFact:
    states = tuple((float(s["probability"]), cast("tuple[Roc, ...]", tuple(s["relations"]))) for s in row["states"])
    return EvidenceFact(tuple((x, y) for x, y in row["pairs"]), states, tuple(row["withheld"]))


def _related(r: PairFact) -> RelatedRow:
    row: RelatedRow = {"relation": r.relation, "args": [r.x, r.y]}
    return {**row, "roc": r.roc} if r.roc else row


def _relation(fact: RelatedRow, parts: tuple[str, str] = ("", "")) -> PairFact:
    """Documents of before ROC-20 tell the coarse relation alone."""
    x, y = fact["args"]
    return PairFact(fact["relation"], x, y, fact.get("roc", ""), parts)


def _pairs(facts: Sequence[Fact], name: str) -> frozenset[tuple[str, str]]:
    return frozenset((f["args"][0], f["args"][1]) for f in facts if f["fact"] != "evidence" and f["fact"] == name)


def type_of(row: TypeRow) -> TypeFact:
    """Return how the type is seen; its tree, and the features without lobes, are told with its hypotheses."""
    features = tuple((str(f[0]), str(f[1])) for f in row["features"])
    looks = (
        LookFact(features[int(f)][0], row["looks"][int(look)], (x, y, z), half, low, high)
        for f, look, x, y, z, half, low, high, _ in row["lobes"]
    )
    facets, faces = (tuple(map(tuple, polygons)) for polygons in (row.get("facets", ()), row.get("faces", ())))
    return TypeFact(features, looks=tuple(looks), facets=facets, faces=faces)


def _at_odds(document: Interpretation) -> Iterator[Mistake]:
    """What one part of a document says against another."""
    for name, row in document.get("types", {}).items():
        for i, (feature, look, *_) in enumerate(row["lobes"]):
            if not (feature < len(row["features"]) and look < len(row["looks"])):
                yield Mistake(("types", name, "lobes", i), f"there is no feature {feature} with look {look}")
    for i, h in enumerate(document["hypotheses"]):
        nowhere = [(j, f) for j, f in enumerate(h["features"]) if f["uv"] is None]
        wrong = [j for j, f in nowhere if f["in_image"] or f["match"] is not None or f.get("case") is not None]
        yield from (
            Mistake(("hypotheses", i, "features", j, "uv"), "is null, of a feature that is in the image, or matched")
            for j in wrong
        )
    measures = document["measures"]
    posed = [h for h in document["hypotheses"] if h["status"] != "rejected"]
    types = {f["type"] for h in posed for f in h["features"]} | measures.get("dv_types", {}).keys()
    for name in sorted(types - measures["dv"].keys() - {OTHERS}):
        yield Mistake(("measures", "dv"), f"the feature type {name!r} is missing")
    accepted = {h["id"] for h in posed}
    for i, world in enumerate(document.get("worlds", [])):
        for name in sorted(set(world["present"]) - accepted):
            yield Mistake(("worlds", i, "present"), f"{name!r} should be a hypothesis that is not rejected")


def _hypothesis(h: HypothesisRow) -> Hypothesis:
    return Hypothesis(
        id=h["id"],
        type=h["type"],
        camera_from_object=np.array(h["T_camera_object"], np.float64),
        opaque=h["opaque"],
        group=h["group"],
        features=tuple(_feature(f) for f in h["features"]),
        parts=tuple(PartFact(p["id"], p["parent"], p["kind"], p["type"]) for p in h["parts"]),
        pixels=h.get("pixels"),
        pixel_table=table_of(h["pixels_beside"], h.get("pixels_left_out", ())) if "pixels_beside" in h else None,
        pose_probability=h.get("pose_probability"),
    )


def _feature(f: FeatureRow) -> FeatureFact:
    x, y, z = f["at"]
    u, v = f["uv"] or (nan, nan)
    return FeatureFact(
        id=f["id"],
        type=f["type"],
        at=(x, y, z),
        uv=(u, v),
        dv=f["dv"],
        in_image=f["in_image"],
        in_lobe=f["in_lobe"],
        self_hidden=f["self_hidden"],
        hidden_by=tuple(f["hidden_by"]),
        match=f["match"],
        residual=f["residual"],
        density=f["density"],
        hit_rate=f["hit_rate"],
        stands_for=f.get("stands_for", 1),
        learned_rate=f.get("learned_rate"),
    )


def found_and_usual(rows: Sequence[FeatureRow | LookedRow]) -> tuple[int, int, int] | None:
    """``beside_usual`` of a document's features."""
    some = [f for f in rows if "learned_rate" in f and f.get("stands_for", 1) == 1 and f.get("expected")]
    return beside_usual([(f["learned_rate"], bool(f.get("detected"))) for f in some])


def beside_usual(expected: Sequence[tuple[float, bool]]) -> tuple[int, int, int] | None:
    """Features of a learned type that are found and that are expected, and how many of these were found in learning.

    ``expected``: of each the rate of learning, and whether it is found. Most visual words come and go from picture to
    picture: without the third number the first two say little. None of a type written by hand.
    """
    usual = round(sum(rate for rate, _ in expected))
    return (sum(found for _, found in expected), len(expected), usual) if expected else None


def hypothesis_document(h: Hypothesis, cases: Mapping[str, tuple[bool, bool, Case | None]]) -> HypothesisFacts:
    """One hypothesis as in the file, without its verdict.

    ``cases`` gives (expected, detected, case) of each feature in Δi.
    """
    return {
        "id": h.id,
        "type": h.type,
        "opaque": h.opaque,
        "group": h.group,
        "features": [_feature_document(f, *cases[f.id]) for f in h.features],
        "parts": [{"id": p.id, "parent": p.parent, "kind": p.kind, "type": p.type} for p in h.parts],
        "T_camera_object": h.camera_from_object.tolist(),
    }


def _feature_document(f: FeatureFact, expected: bool, detected: bool, case: Case | None) -> FeatureRow:  # noqa: FBT001 - a row of a table
    some: StandsKey = {} if f.stands_for == 1 else {"stands_for": f.stands_for}
    often: LearnedKey = {} if f.learned_rate is None else {"learned_rate": f.learned_rate}
    return {
        "id": f.id,
        "type": f.type,
        "at": list(f.at),
        "uv": None if isnan(f.uv[0]) else list(f.uv),
        "dv": f.dv,
        "in_image": f.in_image,
        "in_lobe": f.in_lobe,
        "self_hidden": f.self_hidden,
        "hidden_by": list(f.hidden_by),
        "match": f.match,
        "residual": f.residual,
        "density": f.density,
        "hit_rate": f.hit_rate,
        **some,
        **often,
        "expected": expected,
        "detected": detected,
        "case": case,
    }


def text_of(document: Mapping[str, object]) -> str:
    """The file's text: the same document gives the same bytes."""
    return shown(json.dumps(document, ensure_ascii=False, allow_nan=False, separators=(",", ":"))) + "\n"


def read_interpretation(path: Path | str) -> Interpretation:
    """Read ``interpretation.json``; '-' is stdin. Raises InterpretationError, a line a mistake."""
    return interpretation_in(parsed(path))


def interpretation_of_text(text: str) -> Interpretation:
    """As ``read_interpretation``, of what came over stdin."""
    return interpretation_in(parsed_json(text, name_of("-"), HOLDS, InterpretationError, finite=True))


def interpretation_in(document: Document, formats: str = "{}") -> Interpretation:
    """The interpretation that was read; ``formats`` tells which formats it could have been.

    Raises InterpretationError, a line a mistake.
    """
    data = document.data
    if not isinstance(data, dict) or data.get("format") != FORMAT:
        hint = OF_SEVERAL if isinstance(data, dict) and data.get("format") == "panorama/1" else ""
        wrong = [Mistake(("format",), f"should be {formats.format(repr(FORMAT))}{hint}")]
        raise InterpretationError(*document.told(wrong))
    interpretation = cast("Interpretation", data)
    wrong = document.against(Interpretation) or list(_at_odds(interpretation))
    if wrong:
        raise InterpretationError(*document.told(wrong))
    at_odds = [_numbered(fault, data) for fault in faults(situation_of(interpretation))]
    if at_odds:
        where = document.where(at_odds)
        raise InterpretationError(*(f"{place}: {fault.what}" for place, fault in zip(where, at_odds, strict=True)))
    return interpretation


def _numbered(fault: Mistake, document: object) -> Mistake:
    """A fault at its place in a document: of a row that is named by its id, the last one that has it."""
    keys: list[str | int] = []
    for step in fault.place:
        if isinstance(document, list):
            step = max(i for i, row in enumerate(document) if row["id"] == step)  # noqa: PLW2901 - the name's number
        elif not isinstance(document, dict) or step not in document:
            break
        keys.append(step)
        document = document[step]  # type: ignore[index]
    return fault._replace(place=tuple(keys))


def parsed(path: Path | str) -> Document:
    """The JSON of a file; '-' is stdin. Raises InterpretationError, one line."""
    return read_json(path, LARGEST, HOLDS, InterpretationError, finite=True)
