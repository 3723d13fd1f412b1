"""One scene's folder to a record.

Where its objects truly stand, which of their features were detected, and what nobody caused.

A scene is a folder with ``truth.json`` and one of ``interpretation.json``, ``gamma.json``, or ``image.*`` with
``camera.json``.
"""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from geometry.errors import Mistake, told
from geometry.files.documents import read_json
from geometry.frames import is_rigid
from plogic.base.errors import InputError
from plogic.facts.document import TruthRow
from plogic.match.gamma.data import Data, data_of
from plogic.match.judged.expectation import hidden_by, matched, pose_of
from plogic.match.judged.rivals import same_place
from plogic.measures.distinctiveness import compatible

if TYPE_CHECKING:
    from collections.abc import Callable, Collection, Sequence

    from numpy.typing import NDArray

    from kb.clouds.cloud import KnowledgeBase
    from plogic.facts.document import Interpretation
    from plogic.facts.hypothesis import Hypothesis
    from sensing.appearance import Gamma

    Perceive = Callable[[Gamma], Interpretation]

LARGEST = 16 * 2**20
"""Bytes of a truth file."""
ROUNDED = 1e-4
"""What rounding may take from the entries of a rigid motion in a file."""
NULL = "; null is the label of what the KB does not know"


@dataclass(frozen=True)
class TrueObject:
    """One object: its type (None for what no knowledge base knows), its pose, and the visible share of its picture."""

    label: str | None
    camera_from_object: NDArray[np.float64]
    visible_fraction: float


@dataclass(frozen=True)
class Truth:
    """``complete``: whether every object of known type is listed; else those that are not may be there."""

    objects: tuple[TrueObject, ...]
    complete: bool


def read_truth(path: Path, known: Collection[str]) -> Truth:
    """Read a truth file; ``known``: the types that its labels may name.

    Raises:
        InputError: every mistake, a line each, with the file, the key, and what would be right.
    """
    document = read_json(path, LARGEST, "it should hold where objects stand", InputError, single=True)
    data, wrong = document.data, document.against(TruthRow)
    rows = [] if wrong else data["objects"]
    for i, row in enumerate(rows):
        if row["label"] is not None and row["label"] not in known:
            said = f"{row['label']!r:.60} is no type of the KB ({', '.join(sorted(known))})"
            wrong.append(Mistake(("objects", i, "label"), said))
        if not is_rigid(row["T_camera_object"], ROUNDED):
            said = "should be a rigid motion, 4 rows of 4 numbers, metres"
            wrong.append(Mistake(("objects", i, "T_camera_object"), said))
    if wrong:
        lines = (
            f"{line}{NULL if 'label' in m.place else ''}" for m, line in zip(wrong, document.told(wrong), strict=True)
        )
        raise InputError(told(list(lines)))
    return Truth(
        tuple(
            TrueObject(row["label"], np.array(row["T_camera_object"]), row.get("visible_fraction", 1.0)) for row in rows
        ),
        data.get("complete", True),
    )


@dataclass(frozen=True)
class Sighting:
    """One expected feature; ``near`` is what was observed, ``chance`` the probability of that by clutter alone."""

    feature_type: str
    near: bool
    chance: float


@dataclass(frozen=True)
class Slot:
    """One instance that is there, is not there, or (None) may be there.

    Its sightings are those of its pose, none where it is not there.
    """

    object_type: str
    present: bool | None
    sightings: tuple[Sighting, ...] = ()


@dataclass(frozen=True)
class Record:
    """One scene; ``clutter`` counts per appearance type what no object causes."""

    slots: tuple[Slot, ...]
    clutter: dict[str, int] | None


SOURCES = ("interpretation.json", "gamma.json", "image.png", "image.jpg", "image.jpeg")


@dataclass(frozen=True)
class Found:
    """What perception has: Γ, and the poses of its accepted hypotheses (None where nobody has interpreted Γ yet)."""

    gamma: Gamma
    accepted: tuple[tuple[str, NDArray[np.float64]], ...] | None


def record_of(folder: Path, kb: KnowledgeBase, perceive: Perceive) -> Record:
    """The record of a scene; ``perceive`` interprets a Γ, and is called only where the truth is not complete.

    Raises InputError, GammaError, ImageError, CameraError: the message names the file.
    """
    truth = read_truth(folder / "truth.json", _names(kb))
    found = found_in(folder, kb)
    data = data_of(found.gamma.appearances, found.gamma.camera)
    others = [] if truth.complete else _open(found, _known(truth), kb, perceive)
    return record_in(truth, data, kb, others)


def _known(truth: Truth) -> list[tuple[str, NDArray[np.float64]]]:
    """(type, pose) of the true objects that the knowledge base knows and of which something is to be seen."""
    return [(o.label, o.camera_from_object) for o in truth.objects if o.label is not None and o.visible_fraction > 0.0]


def found_in(folder: Path, kb: KnowledgeBase) -> Found:
    """Γ of a scene, from the first of ``SOURCES`` that the folder has."""
    path = next((folder / name for name in SOURCES if (folder / name).exists()), None)
    if path is None:
        raise InputError(
            f"{folder}: holds no picture and no Γ: one of {', '.join(SOURCES)} is needed beside truth.json"
        )
    return _interpreted(path, kb) if path.name == "interpretation.json" else Found(_gamma(path, folder, kb), None)


def _interpreted(path: Path, kb: KnowledgeBase) -> Found:
    from plogic.facts.interpretation import read_interpretation
    from sensing.files.gamma_files import gamma_from_dict

    document = read_interpretation(str(path))
    plain = [{key: value for key, value in a.items() if key != "clutter"} for a in document["appearances"]]
    source = {"format": "gamma/1", "camera": document.get("camera"), "appearances": plain}
    return Found(gamma_from_dict(source, str(path), kb.appearance_types), accepted_in(document))


def accepted_in(document: Interpretation) -> tuple[tuple[str, NDArray[np.float64]], ...]:
    """(type, pose) of Δi."""
    return tuple(
        (h["type"], np.array(h["T_camera_object"])) for h in document["hypotheses"] if h["status"] == "accepted"
    )


def _gamma(path: Path, folder: Path, kb: KnowledgeBase) -> Gamma:
    from geometry.files.camera_files import read_camera
    from sensing.detectors.detector import detect
    from sensing.files.gamma_files import read_gamma
    from sensing.files.images import read_image

    if path.name == "gamma.json":
        return read_gamma(path, kb.appearance_types)
    return detect(read_image(path), read_camera(folder / "camera.json"), kb.appearance_types)


def _names(kb: KnowledgeBase) -> set[str]:
    return {kind.name for kind in kb.types}


def _open(
    found: Found, true: Sequence[tuple[str, NDArray[np.float64]]], kb: KnowledgeBase, perceive: Perceive
) -> list[tuple[str, NDArray[np.float64]]]:
    """Accepted hypotheses at no true object's place: nobody knows whether they are right."""
    accepted = accepted_in(perceive(found.gamma)) if found.accepted is None else found.accepted
    return [
        (name, pose)
        for name, pose in accepted
        if name in _names(kb) and not any(name == label and same_place(kb.type(name), pose, at) for label, at in true)
    ]


def record_in(
    truth: Truth, data: Data, kb: KnowledgeBase, others: Sequence[tuple[str, NDArray[np.float64]]] = ()
) -> Record:
    """The record of one Γ; ``others``: (type, pose) of what was accepted where nobody knows what stands."""
    true = _known(truth)
    posed = [pose_of(kb.type(name), pose, data, kb) for name, pose in true]
    looked = [_looked(one, posed, data, kb) for one in posed]
    slots = [_slot(one, hidden, data, kb, present=True) for one, hidden in looked]
    for name, pose in others:
        one, hidden = _looked(pose_of(kb.type(name), pose, data, kb), posed, data, kb)
        slots.append(_slot(one, hidden, data, kb, present=None))
    if not truth.complete:
        return Record(tuple(slots), None)
    there = {name for name, _ in true}
    slots += [Slot(kind.name, present=False) for kind in kb.types if kind.name not in there]
    return Record(tuple(slots), _clutter(looked, data, kb))


def _looked(
    one: Hypothesis, posed: Sequence[Hypothesis], data: Data, kb: KnowledgeBase
) -> tuple[Hypothesis, NDArray[np.bool_]]:
    """A posed type with its matching (D8), and which of its features true objects hide (D7)."""
    hidden = np.zeros(len(one.uv), dtype=bool)
    for other in posed:
        if other is not one and other.object_type.opaque:
            hidden |= hidden_by(one, other)
    types = [frozenset(a.type for a in f.appearances) for f in one.object_type.seen_features]
    return matched(one, data, compatible(types, data.types), kb.rates.match_tolerance, hidden=hidden), hidden


def _slot(one: Hypothesis, hidden: NDArray[np.bool_], data: Data, kb: KnowledgeBase, *, present: bool | None) -> Slot:
    kind = one.object_type
    expected = np.flatnonzero(one.expected(hidden))
    sightings = tuple(
        Sighting(seen.type, near=bool(one.detected[f]), chance=_chance(seen.appearances, data, kb))
        for f, seen in ((f, kind.seen_features[f]) for f in expected)
    )
    return Slot(kind.name, present, sightings)


def _chance(appearances: Sequence[Any], data: Data, kb: KnowledgeBase) -> float:
    """That clutter alone puts an appearance of one of these types within the match tolerance: 1 − exp(−λ·π·r²/area)."""
    area = data.camera.width * data.camera.height
    rate = sum(kb.rates.clutter[name] for name in {a.type for a in appearances})
    return float(-np.expm1(-rate * np.pi * kb.rates.match_tolerance**2 / area))


def _clutter(looked: Sequence[tuple[Hypothesis, NDArray[np.bool_]]], data: Data, kb: KnowledgeBase) -> dict[str, int]:
    """Per appearance type what no expected feature of a true object takes."""
    used = {int(m) for one, hidden in looked for m in one.matches[one.expected(hidden) & one.detected]}
    left = Counter(kind for a, kind in enumerate(data.types) if a not in used)
    return {name: left[name] for name in kb.appearance_types}


def is_scene(path: Path) -> bool:
    """Whether a folder has a ground truth."""
    return (path / "truth.json").exists()


def scene_folders(paths: Sequence[str]) -> list[Path]:
    """The scenes that are named: folders with a truth.json, or folders of such folders.

    Raises InputError for anything else.
    """
    found: list[Path] = []
    for name in paths:
        path = Path(name)
        inside = [path] if is_scene(path) else sorted(p for p in path.iterdir() if is_scene(p)) if path.is_dir() else []
        if not inside:
            raise InputError(
                f"{name}: is no scene: a folder with truth.json (as `plogic simulate` writes), or a folder of such folders"
            )
        found += inside
    return list(dict.fromkeys(found))
