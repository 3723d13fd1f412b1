"""``plogic demo --paper``: Table 1 (§5.6) and figure 5 of the paper, counted from poses, lobes, rays and a Γ.

The knowledge base ``paper`` holds the two towers, with as many features as the rows' sums say, its folder ``figure_5``
a Γ and three poses. No count is stored: Expected and Detected are computed as in any interpretation (D7, D8).
"""

import json
from collections import Counter
from collections.abc import Callable, Mapping
from dataclasses import asdict, replace
from pathlib import Path
from typing import cast

import cv2
import numpy as np
from numpy.typing import NDArray

from geometry.arrays import Mask
from kb.files.folder import shipped
from plogic.cycle.delta import Options, delta_of
from plogic.cycle.state import Cycle, Trace
from plogic.face.commands.demo import check_folder, write_into
from plogic.face.shown.overlay import overlay
from plogic.face.shown.tables import plain_table, text_of_table, worlds
from plogic.facts.document import FeatureRow, HypothesisRow, Interpretation, RejectedRow
from plogic.facts.hypothesis import Hypothesis
from plogic.facts.interpretation import situation_of, text_of
from plogic.facts.spatial import exclusion_lines
from plogic.match.gamma.data import data_of
from plogic.match.judged.evidence import judged
from plogic.match.judged.rivals import hidden_among
from plogic.measures.explanatory import Cells, Support, case_of, explanatory_value, reconsidered
from plogic.run.document import document_of
from plogic.run.perceive import Perceiver, ranked
from plogic.run.sources import kb_of
from plogic.scene.worlds.ranked_worlds import ranked_worlds
from sensing.appearance import Gamma
from sensing.files.gamma_files import gamma_to_dict, read_gamma
from sensing.simulated.scene import json_bytes, png

PRINTED = {"T2 distorted": -0.51, "T2 correct": 0.58, "T1 correct": 1.0, "T2 reconsidered": 0.94}
"""Ev as the paper prints it, for comparison: nothing is computed from it."""
KINDS = "apex", "corner", "other"
WHITE = 255, 255, 255
PANELS = "a: what was detected", "b: T2 distorted", "c: T1 and T2 correct", "d: T2 reconsidered beside T1"


def run_paper(out: Path, *, say: Callable[[str], None], as_json: bool = False) -> str:
    """Count the four rows, draw the four panels, write ``out``, and return the text to print."""
    check_folder(out)
    kb, place = kb_of("paper"), shipped("paper") / "figure_5"
    say("counting the cells of Table 1 from poses, lobes, rays and Γ ...")
    perceiver, gamma = Perceiver(kb), read_gamma(place / "gamma.json", kb.appearance_types)
    posed = _posed(perceiver, gamma, json.loads((place / "hypotheses.json").read_text(encoding="utf-8")))
    t1, t2 = posed["T1 correct"], posed["T2 correct"]
    hidden = hidden_among(t2, [t1])
    support = {name: some.support() for name, some in posed.items()}
    waived = _explained(t2, hidden)
    number = Counter(f.type for f, explained in zip(t2.object_type.seen_features, waived, strict=True) if explained)
    support["T2 reconsidered"] = reconsidered(t2.support(), number, "drop")
    document = _document(perceiver, gamma, posed)
    figure = _figure(document, posed, waived)
    files = {"gamma.json": json_bytes(gamma_to_dict(gamma)), "interpretation.json": text_of(document).encode()}
    write_into(out, {**files, "figure-5.png": png(figure)})
    ev = {name: explanatory_value(cells, perceiver.dv) for name, cells in support.items()}
    if as_json:
        rows = [
            {"row": name, "cells": {k: asdict(c) for k, c in support[name].items()}, "ev": ev[name], "printed": value}
            for name, value in PRINTED.items()
        ]
        told = {"rows": rows, "worlds": document["worlds"]}
        return json.dumps({"format": "demo/1", "folder": str(out), **told})
    rows = [
        {"": name, **_row(support[name]), "ev": ev[name], "paper": f"{value:.2f}"} for name, value in PRINTED.items()
    ]
    table = plain_table("Table 1: of each feature type E∧D, E∧¬D, ¬E∧¬D, ¬E∧D", rows)
    ends = f"look at {out}/figure-5.png; ask {out}/interpretation.json, with plogic measures for the other modes"
    return "\n".join(
        [table, text_of_table(worlds(document)).rstrip(), *exclusion_lines(document), _else(document), "", ends]
    )


def _posed(perceiver: Perceiver, gamma: Gamma, stored: Mapping[str, list[dict[str, object]]]) -> dict[str, Hypothesis]:
    """The three hypotheses by name, each matched to all of Γ at its pose, which stays as it is, and judged alone."""
    data = data_of(gamma.appearances, gamma.camera, perceiver.width)
    return {
        str(row["name"]): judged(
            perceiver.models[str(row["type"])].settle(
                np.array(row["T_camera_object"], float), data, perceiver.kb, rounds=0
            ),
            data,
            perceiver.kb,
            perceiver.dv,
        )
        for row in stored["hypotheses"]
    }


def _explained(posed: Hypothesis, hidden: Mask) -> Mask:
    """(F,) its C cells that the ``hidden`` features (F,) explain (§5.5)."""
    return posed.candidate & ~posed.detected & hidden


def _row(support: Support) -> dict[str, str]:
    cells = {kind: support.get(kind, Cells()) for kind in KINDS}
    return {kind: f"{c.A} {c.C} {c.B} {c.D}" for kind, c in cells.items()}


def _document(perceiver: Perceiver, gamma: Gamma, posed: Mapping[str, Hypothesis]) -> Interpretation:
    """The interpretation: both towers accepted, the distorted one their rival, in mode ``drop``."""
    kb, data = perceiver.kb, data_of(gamma.appearances, gamma.camera, perceiver.width)
    accepted = tuple(
        posed[name].told(status="accepted", why="as in the paper") for name in ("T1 correct", "T2 correct")
    )
    rival = posed["T2 distorted"].told(status="rival", why="a pose from wrong matches")
    cycle = Cycle(accepted, (rival,), (), (), Trace())
    delta, ranking = ranked(delta_of(cycle, data, kb, perceiver.dv, Options(reconsider="drop")), [])
    return document_of(kb, gamma, delta, (), [], ranking, None)


def _else(document: Interpretation) -> str:
    """The worlds were the distorted pose discrete from T1, as §8 takes it, which has no geometry."""
    situation = situation_of(document)
    t1, _, distorted = (h.id for h in situation.hypotheses)
    pair = {(t1, distorted)}
    freed = replace(situation, overlaps=situation.overlaps - pair, exclusive=situation.exclusive - pair)
    names = {h.id: f"{h.type} {h.id}" for h in situation.hypotheses}
    found = (f"{', '.join(names[h] for h in w.present)}: {w.probability:.3f}" for w in ranked_worlds(freed).worlds)
    return f"without the last of these, as where cells alone are counted, there are three worlds: {'; '.join(found)}"


def _figure(document: Interpretation, posed: Mapping[str, Hypothesis], waived: Mask) -> NDArray[np.uint8]:
    """Figure 5: the four panels, two by two; of T2 reconsidered the ``waived`` features (F,) are left out."""
    found = cast("list[HypothesisRow]", document["hypotheses"])
    names = "T1 correct", "T2 correct", "T2 distorted"
    t1, t2, distorted = (_drawn(row, posed[name]) for row, name in zip(found, names, strict=True))
    again = _drawn(found[1], posed["T2 correct"], waived)
    shown: list[list[HypothesisRow | RejectedRow]] = [[], [distorted], [t1, t2], [t1, again]]
    panels = [_panel(title, {**document, "hypotheses": rows}) for title, rows in zip(PANELS, shown, strict=True)]
    high = max(panel.shape[0] for panel in panels)
    panels = [np.pad(p, ((0, high - len(p)), (6, 6), (0, 0)), constant_values=255) for p in panels]
    return np.vstack([np.hstack(panels[:2]), np.hstack(panels[2:])])


def _drawn(row: HypothesisRow, posed: Hypothesis, waived: Mask | None = None) -> HypothesisRow:
    """A hypothesis' row as it is alone: its cases are those without any other object."""
    mask = np.zeros(len(posed.uv), bool) if waived is None else waived
    cases = zip(posed.candidate.tolist(), posed.detected.tolist(), (posed.in_image & ~mask).tolist(), strict=True)
    features: list[FeatureRow] = [
        {**f, "expected": e, "detected": d, "case": case_of(expected=e, detected=d) if counts else None}
        for f, (e, d, counts) in zip(row["features"], cases, strict=True)
    ]
    return {**row, "status": "accepted", "features": features}


def _panel(title: str, document: Interpretation) -> NDArray[np.uint8]:
    picture = overlay(document, None)
    head = np.full((40, picture.shape[1], 3), WHITE, np.uint8)
    cv2.putText(head, title, (8, 28), cv2.FONT_HERSHEY_SIMPLEX, 0.8, (30, 30, 30), 1, cv2.LINE_AA)
    return np.vstack([head, picture])
