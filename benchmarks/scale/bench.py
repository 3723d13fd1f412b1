"""``plogic bench scale``: bytes and microseconds a type and a frame, and the need of a million types.

Every figure of docs/scale.md. ``--quick``: up to a hundred types, few trials.
"""

from __future__ import annotations

import json
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from benchmarks.clutter.scenes import trial
from benchmarks.clutter.types import EASY
from benchmarks.scale.table import CAPTION, Vocabulary, claims, tables
from benchmarks.scale.types import FEATURES, bodies, disk_bytes, first, index_bytes, made_ready, object_bytes
from benchmarks.scale.votes import Seen, entries, falsely_accepted, seen, standing, under_cap, with_more
from plogic.face.shown.tables import plain_table
from plogic.match.oriented.pair_index import MOST

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from benchmarks.clutter.scenes import Trial
    from benchmarks.scale.recall import Standing
    from benchmarks.scale.types import Bodies, Ready


@dataclass(frozen=True)
class Plan:
    """How many types, told apart by how many appearance types; how many trials of each kind.

    ``frames`` are timed at each size; ``trials`` vote at the two greatest; ``caps`` of them with fewer entries;
    ``deep`` of them among the votes of ``passes`` (one number for each of ``looks``) times as many types more.
    """

    sizes: Sequence[int] = (10, 30, 100, 300, 1000)
    looks: Sequence[int] = (3000, 300, 100)
    frames: int = 6
    trials: int = 40
    caps: int = 12
    deep: int = 3
    passes: Sequence[int] = (9, 99, 9)
    built: int = 100
    kept: int = 24


QUICK = Plan((10, 30, 100), (300, 100), frames=3, trials=8, caps=3, deep=1, passes=(9, 9), built=30)


def run(
    *, seed: int, quick: bool, as_json: bool, say: Callable[[str], None], plan: Plan | None = None
) -> tuple[str, bool]:
    """Run the benchmark; a line of progress a step on ``say``."""
    plan = plan or (QUICK if quick else Plan())
    made = bodies(max(plan.sizes), seed)
    say(f"{len(made.types)} bodies")
    memory = {"Σ": object_bytes(max(1, plan.kept // 4), seed), "disk": disk_bytes(plan.kept, seed)}
    measured = [
        _of_vocabulary(made, looks, passes, plan, seed, say)
        for looks, passes in zip(plan.looks, plan.passes, strict=True)
    ]
    printed = tables(measured, made.seconds, memory, np.random.default_rng(seed))
    listed = claims(measured)
    met, documents = all(claim.met for claim in listed), [claim.document() for claim in listed]
    if as_json:
        rows = [{"table": name, **row} for name, some in printed.items() for row in some]
        return json.dumps({"bench": "scale", "rows": rows, "claims": documents}), met
    text = "\n".join(plain_table(name, rows) for name, rows in printed.items())
    return f"{CAPTION}\n\n{text}\n{plain_table('claims', documents)}", met


def _of_vocabulary(
    made: Bodies, looks: int, passes: int, plan: Plan, seed: int, say: Callable[[str], None]
) -> Vocabulary:
    """All that is measured with so many appearance types."""
    types = made.alike(looks)
    whole = made_ready(types, made.cells, looks)
    few = made_ready(types[: plan.built], made.cells[: plan.built], looks)
    say(f"{looks} looks: the index of {len(types)} types in {whole.seconds:.1f} s")
    frames = {size: _timed(first(whole, size), plan.frames, seed) for size in plan.sizes}
    say(f"{looks} looks: frames timed")
    sizes = sorted(plan.sizes)[-2:]
    posed = [_trial(whole, sizes[0], seed, i) for i in range(plan.trials)]
    standings = {
        size: [standing(ready, one) for one in posed] for size, ready in ((size, first(whole, size)) for size in sizes)
    }
    say(f"{looks} looks: {plan.trials} trials voted")
    asked = entries(whole, posed[: plan.caps])
    rng = np.random.default_rng([seed, looks, 1])
    deep = [
        with_more(whole, one, before, passes, rng)
        for one, before in zip(posed[: plan.deep], standings[sizes[1]], strict=False)
    ]
    say(f"{looks} looks: {plan.deep} trials among the votes of {(1 + passes) * sizes[1]} types")
    caps = {many: _capped(whole, posed[: plan.caps], many, asked) for many in (10**4, 10**5, 10**6)}
    false = sum(falsely_accepted(whole, one.gamma, rng) for one in posed[: plan.caps])
    say(f"{looks} looks: done")
    return Vocabulary(
        looks,
        index_bytes(whole),
        {plan.built: few.seconds, len(types): whole.seconds},
        frames,
        standings,
        deep,
        asked,
        caps,
        false,
        plan.caps,
    )


def _trial(ready: Ready, among: int, seed: int, number: int) -> Trial:
    """The trial of this number: of one of the first ``among`` types."""
    rng = np.random.default_rng([seed, FEATURES, 1 + number])
    return trial(ready.kb.types[int(rng.integers(among))], ready.kb, EASY, rng)


def _timed(ready: Ready, frames: int, seed: int) -> list[Seen]:
    """Frames of these types, one before them left out: what is computed once is computed there."""
    return [seen(ready, _trial(ready, len(ready.kb.types), seed, i)) for i in range(frames + 1)][1:]


def _capped(ready: Ready, posed: Sequence[Trial], many: int, asked: float) -> list[Standing] | None:
    """The trials where of entries as large a share is looked at as of ``many`` types; None where it is all."""
    most = int(MOST * len(ready.indices) / many)
    return None if asked * len(ready.indices) <= most else [under_cap(ready, one, most) for one in posed]
