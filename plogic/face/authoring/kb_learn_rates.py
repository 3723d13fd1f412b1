"""``plogic kb learn-rates``: priors, hit rates and clutter from scenes with ground truth, back into ``kb.yaml``."""

import json
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from geometry.errors import PlogicError
from kb.clouds.cloud import Counts, KnowledgeBase, Rates
from kb.files.changes import Writer
from kb.files.write import rounded, with_rates
from plogic.base.errors import InputError
from plogic.face.authoring.kb_types import changing
from plogic.face.shown.tables import plain_table
from plogic.rates.estimates import added, counted, expected_counts, learned, open_slots, without
from plogic.rates.scene_records import Record, record_of, scene_folders
from plogic.run.perceive import perceiver_of
from plogic.run.sources import kb_of

KINDS = ("hit", "clutter", "prior")
"""Rates that are learned: the fields that ``Rates`` and ``Counts`` have in common."""


def learn_rates_command(
    scenes: Sequence[str], kb_folder: str, *, add: bool, dry_run: bool, say: Callable[[str], None], as_json: bool
) -> str:
    """Learn, and write unless ``dry_run``; ``add``: to the counts that the KB has."""
    if dry_run:
        return _learn(scenes, kb_of(kb_folder), None, add=add, say=say, as_json=as_json)
    with changing(kb_folder) as (kb, writer):
        return _learn(scenes, kb, writer, add=add, say=say, as_json=as_json)


def _learn(
    scenes: Sequence[str],
    kb: KnowledgeBase,
    writer: Writer | None,
    *,
    add: bool,
    say: Callable[[str], None],
    as_json: bool,
) -> str:
    """As ``learn_rates_command``, of a knowledge base that nobody else changes where there is a ``writer``."""
    records = _records(scene_folders(scenes), kb, say)
    words = frozenset(kb.words.names if kb.words is not None else ())
    observed = without(added(kb.rates.counts if add else Counts(), counted(records)), words)
    unknown = open_slots(records)
    counts = without(expected_counts(unknown, observed, learned(observed, kb.rates)), words)
    rates = learned(counts, kb.rates)
    if writer is not None:
        file = writer.root / "kb.yaml"
        writer.change({file: with_rates(file.read_text(encoding="utf-8"), rates).encode()})
        say(f"wrote {file}")
    if unknown:
        say(f"{len(unknown)} instances of unknown presence were weighed by EM")
    return (
        _document(kb, rates, counts, len(records))
        if as_json
        else plain_table(f"rates of {kb.name}", _rows(kb, rates, counts))
    )


def _records(folders: Sequence[Path], kb: KnowledgeBase, say: Callable[[str], None]) -> list[Record]:
    """Every scene's record; what is wrong with any of them is told at once."""
    perceiver = perceiver_of(kb)
    records, wrong = [], []
    for i, folder in enumerate(folders, start=1):
        try:
            records.append(record_of(folder, kb, perceiver))
            say(f"{i}/{len(folders)} {folder}: {len(records[-1].slots)} slots")
        except PlogicError as error:
            wrong += str(error).splitlines()
    if wrong:
        raise InputError("\n".join(wrong))
    return records


def _rows(kb: KnowledgeBase, rates: Rates, counts: Counts) -> list[dict[str, Any]]:

    return [
        {
            "rate": rate,
            "of": name,
            "before": getattr(kb.rates, rate)[name],
            "learnt": rounded(getattr(rates, rate)[name]),
            "count": round(pair[0], 2),
            "in": round(pair[1], 2),
        }
        for rate in KINDS
        for name, pair in getattr(counts, rate).items()
    ]


def _document(kb: KnowledgeBase, rates: Rates, counts: Counts, scenes: int) -> str:
    return json.dumps({"format": "rates/1", "kb": kb.name, "scenes": scenes, "rates": _rows(kb, rates, counts)})
