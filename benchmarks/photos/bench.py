"""``plogic bench photos``: real photos beside a peer; rendered ones with photos' troubles; each type left out.

The datasets lie in ``../shared/data/photos``, or where ``PLOGIC_PHOTOS`` says.
"""

from __future__ import annotations

import os
from pathlib import Path
from typing import TYPE_CHECKING, Any

from benchmarks.photos.pictures import folder_made
from benchmarks.photos.real import of_all, of_dataset
from benchmarks.photos.simulated import of_pictures
from benchmarks.photos.without import of_left_out
from benchmarks.shared.claims import report
from plogic.base.errors import InputError

if TYPE_CHECKING:
    from collections.abc import Callable

FOLDER = Path(os.environ.get("PLOGIC_PHOTOS", "../shared/data/photos"))
SETS = "ycb", "lmo"
SIMULATED, WITHOUT = "simulated", "without"
PICTURES, QUICK_PICTURES = 100, 12
"""Simulated ones."""


def run(
    *,
    seed: int,
    quick: bool,
    as_json: bool,
    say: Callable[[str], None],
    pictures: Path | None = None,
    kb: Path | None = None,
    part: str | None = None,
    count: int | None = None,
) -> tuple[str, bool]:
    """Run the benchmark, of ``quick`` the first dataset alone; ``pictures``: the folder of a picture of each photo.

    ``kb``: the folder of the learned knowledge bases, each of its dataset's name: what is not there is learned into it.
    ``part``: ``simulated``, ``count`` rendered pictures of the first dataset's models; ``without``, each posed type
    left out; None for the photos.

    Raises:
        InputError: The photos are not there, their models cannot be learned, or the folder of pictures cannot be made.
    """
    from plogic.run.bop.dataset import open_dataset

    if pictures is not None:
        folder_made(pictures)
    reports = []
    for name in SETS[:1] if quick or part == SIMULATED else SETS:
        if not (FOLDER / name).is_dir():
            raise InputError(f"{FOLDER / name}: there are no such photos: PLOGIC_PHOTOS may name their folder")
        dataset, kept = open_dataset(FOLDER / name), None if kb is None else kb / name
        if part == SIMULATED:
            number = count or (QUICK_PICTURES if quick else PICTURES)
            reports.append(of_pictures(dataset, name, kept, seed, number, say, pictures))
        elif part == WITHOUT:
            reports.append(of_left_out(dataset, name, kept, seed, say))
        else:
            reports.append(of_dataset(dataset, name, kept, seed, say, pictures))
    if part is None:
        reports.append(of_all(reports))
    more: dict[str, list[dict[str, Any]]] = {}
    for key, table in (item for one in reports for item in one.more.items()):
        more.setdefault(key, []).extend(table)
    rows, claims = [row for one in reports for row in one.rows], [claim for one in reports for claim in one.claims]
    return report("photos", rows, claims, as_json=as_json, more=more)
