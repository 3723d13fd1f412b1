"""``plogic explain INTERPRETATION --missing TYPE``: how far a type came that was not found.

From what the interpretation holds: its appearances, the trace, and the hypotheses that were tried. With the knowledge
base also which data look like the type, which expected features the best pose lacked, and the cause, sought as for an
empty answer, but however long that takes.
"""

import json
from collections import Counter
from collections.abc import Iterator
from typing import Any

import numpy as np

from geometry.files.remembered import cache_folder
from kb.clouds.cloud import KnowledgeBase, ObjectType
from kb.clouds.word_names import is_word
from kb.files.read import read_kb
from kb.shown.cautions import remedy
from plogic.base.errors import InputError
from plogic.face.shown.figures import chance
from plogic.facts.caveats import UNWEIGHED
from plogic.facts.document import Interpretation, RejectedRow
from plogic.match.gamma.data import data_of
from plogic.match.judged.expectation import pose_of
from plogic.run.silence.causes import counted, looks_like, tried, why_missing
from plogic.run.sources import kb_of
from sensing.appearance import Gamma
from sensing.files.gamma_files import gamma_from_dict

NAMED = 8
"""Missed features that a line names."""


def missing_command(source: str, name: str, kb_folder: str | None, *, as_json: bool) -> str:
    """The lines, or one ``missing/1`` document.

    Raises:
        InputError: a program, an interpretation of another knowledge base, or no such type.
    """
    from plogic.face.python.asking import opened
    from plogic.face.python.interpretation import Interpretation as Asked

    asked = opened(source)
    if not isinstance(asked, Asked):
        raise InputError(f"{source}: --missing is of an interpretation, not of a program")
    told = missing_document(asked.document, name, None if kb_folder is None else kb_of(kb_folder), source)
    return json.dumps(told) if as_json else "\n".join(_lines(told, source)) + "\n"


def missing_document(document: Interpretation, name: str, kb: KnowledgeBase | None, source: str) -> dict[str, Any]:
    """What is known of it; ``cause`` and what else takes a knowledge base are None where there is none."""
    kind = None if kb is None else _kind(document, kb, name, source)
    steps = [step for step in document.get("trace", []) if step["type"] == name]
    rows = [h for h in document["hypotheses"] if h["type"] == name]
    if kind is None and not steps and not rows:
        known = sorted({step["type"] for step in document.get("trace", []) if step["type"] is not None})
        raise InputError(f"{name}: no such type in {source}; it tells of: {', '.join(known[:20]) or 'none'}")
    gamma = _gamma(document, source)
    best = next(iter(tried(document, name)), None)
    here = Counter(a["type"] for a in document["appearances"])
    return {
        "format": "missing/1",
        "type": name,
        "in_delta": [
            {"id": h["id"], "status": h["status"], "probability": h.get("probability"), "why": h.get("why", "")}
            for h in rows
            if h["status"] != "rejected"
        ],
        "appearances": here.total(),
        "look_like_it": None if kind is None else dict(sorted(looks_like(here, kind).items())),
        "visual_words": None if kind is None else sum(map(is_word, set(kind.lobes.types))),
        "rank": next((step["why"] for step in steps if step["event"] == "rank"), None),
        "rejected": sum(step["event"] == "reject" for step in steps),
        "best": None if best is None else _best(best, kind, kb, gamma),
        "causes": None if kind is None or kb is None else _causes(document, gamma, kb, kind, rows),
    }


def _causes(document: Interpretation, gamma: Gamma, kb: KnowledgeBase, kind: ObjectType, rows: list[Any]) -> list[str]:
    """Why it is missing; nothing of what is accepted, a rival, or a rival too many: their reasons are told."""
    if any(h["status"] != "rejected" or h.get("why") == UNWEIGHED for h in rows):
        return []
    if not kind.features:
        return [f"{kind.name}: has no features, so it is never found: {remedy(kind)}"]
    return why_missing(document, gamma, kb, kind)


def _kind(document: Interpretation, kb: KnowledgeBase, name: str, source: str) -> ObjectType:
    made_with = document["kb"]["digest"] if "kb" in document else kb.digest
    kind = next((kind for kind in kb.types if kind.name == name), None)
    if kind is None:
        raise InputError(
            f"{name}: no such object type; there are: {', '.join(k.name for k in kb.types[:20]) or 'none'}"
        )
    if made_with != kb.digest and not _same_but_rules(document, kb):
        what = f"files of {kb.folder} beside rules.pl have changed since, or it was made with another {document['kb']['name']}"
        raise InputError(f"{source}: {what}: perceive again")
    return kind


def _same_but_rules(document: Interpretation, kb: KnowledgeBase) -> bool:
    """Whether it was made with this knowledge base under other rules, which are no cause that a type is missing."""
    if kb.folder is None:
        return False
    before = read_kb(kb.folder, cache_folder(""), document["rules"])
    return before.digest == document["kb"]["digest"]


def _gamma(document: Interpretation, source: str) -> Gamma:
    """Γ again, without the descriptors, which an interpretation does not hold."""
    if "camera" not in document:
        raise InputError(f"{source}: tells no camera: perceive again")
    rows = [{key: value for key, value in row.items() if key != "clutter"} for row in document["appearances"]]
    return gamma_from_dict({"format": "gamma/1", "camera": document["camera"], "appearances": rows}, source)


def _best(row: RejectedRow, kind: ObjectType | None, kb: KnowledgeBase | None, gamma: Gamma) -> dict[str, Any]:
    found, expected = counted(row)
    return {
        "id": row["id"],
        "T_camera_object": row["T_camera_object"],
        "distance": row["T_camera_object"][2][3],
        "detected": found,
        "expected": expected,
        "missed": None if kind is None or kb is None or kind.learned is not None else _missed(row, kind, kb, gamma),
        "why": row.get("why", ""),
    }


def _missed(row: RejectedRow, kind: ObjectType, kb: KnowledgeBase, gamma: Gamma) -> list[str]:
    """The features that are expected at its pose, and have no datum of a right type within the tolerance."""
    data = data_of(gamma.in_order().appearances, gamma.camera, 128)
    posed = pose_of(kind, np.array(row["T_camera_object"]), data, kb)
    off = np.linalg.norm(posed.uv[:, None] - gamma.in_order().uv[None], axis=2)
    near = ((off <= kb.rates.match_tolerance) & posed.right).any(axis=1)
    return [
        feature.name for feature, miss in zip(kind.seen_features, posed.expected(None) & ~near, strict=True) if miss
    ]


def _lines(told: dict[str, Any], source: str) -> Iterator[str]:
    """For people: the cause first."""
    name = told["type"]
    for h in told["in_delta"]:
        yield f"{h['id']} is a {name}: {h['status']}, probability {chance(h['probability'])}; {h['why']}"
    yield from told["causes"] or []
    if told["look_like_it"] is not None:
        counts = ", ".join(_counts(told["look_like_it"], told["visual_words"]))
        number = sum(told["look_like_it"].values())
        yield f"data: {number} of {told['appearances']} appearances look like features of it{f': {counts}' if counts else ''}"
    else:
        yield f"data: {told['appearances']} appearances; which of them look like {name}, and the cause, is told with --kb KB"
    yield f"attention: {told['rank'] or 'it was not attended to, for it has no features'}"
    yield from _poses(told, source)


def _counts(look_like_it: dict[str, int], words: int) -> Iterator[str]:
    """``10 corner``, ``412 of 620 visual words detected``: those that nobody knows by name in one."""
    yield from (f"{number} {sort}" for sort, number in look_like_it.items() if not is_word(sort))
    detected = sum(map(is_word, look_like_it))
    if words:
        yield f"{detected} of {words} visual words detected"


def _poses(told: dict[str, Any], source: str) -> Iterator[str]:
    """What was tried, and what the best lacked."""
    best, number = told["best"], told["rejected"]
    stands = [h["id"] for h in told["in_delta"] if h["status"] == "accepted"]
    held = [h["id"] for h in told["in_delta"] if h["status"] != "accepted"]
    there = [f"{', '.join(stands)} {'stand' if len(stands) > 1 else 'stands'} there"] * bool(stands)
    there += [f"{', '.join(held)} {'are' if len(held) > 1 else 'is'} held in other worlds"] * bool(held)
    before = f"{'; '.join(there)}; of others, " if there else ""
    if best is None:
        kept = f"{number} rejected, none of them among those that {source} holds" if number else ""
        yield f"poses: {before}{kept or 'none was kept for judgement'}"
        return
    came = f"{best['detected']} of {best['expected']} expected features detected"
    yield f"poses: {before}{number} rejected; the best{' of these' if there else ''}, {best['distance']:.2g} m away, has {came}"
    if best["missed"]:
        more = f" and {len(best['missed']) - NAMED} more" if len(best["missed"]) > NAMED else ""
        yield f"  missed: {', '.join(best['missed'][:NAMED])}{more}"
    claimed = best["expected"] - best["detected"] - len(best["missed"] or ())
    if best["missed"] is not None and claimed > 0:
        yield f"  {claimed} more have data near them that fit others, or that accepted objects claim"
    yield f"  why not: {best['why']}"
