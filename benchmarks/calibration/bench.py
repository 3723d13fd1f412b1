"""``plogic bench calibration``.

Whether probabilities mean what they say, of the posterior reading and of P(ev), side by side.

Rates are learned on some scenes as ``plogic kb learn-rates`` learns them, and what perception then says is compared
with the truth on others. ``--quick``: fewer scenes, which promise fewer hypotheses. ``--picture FILE``: the reliability
diagram, an SVG.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from benchmarks.calibration.forecasts import forecasts_of
from benchmarks.calibration.scenes import random_world, scene
from benchmarks.calibration.table import CAPTION, claims, drawn, rows
from benchmarks.shared.claims import report

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

    from benchmarks.calibration.forecasts import Forecast
    from benchmarks.calibration.scenes import World
    from kb.clouds.cloud import KnowledgeBase

FIRST_OF_TRAINING = 50_000
"""Seeds from here on are scenes to learn from; those below, scenes to be judged by."""
STEP = 1_000
"""How far apart the scenes of two seeds of the benchmark are: no two have one in common."""
SAID_EVERY = 20
"""Scenes between two lines of progress."""


@dataclass(frozen=True)
class Plan:
    """How many scenes are learned from, and how many are judged."""

    training: int = 300
    judged: int = 600


QUICK = Plan(training=100, judged=60)


def run(
    *, seed: int, quick: bool, picture: Path | None, as_json: bool, say: Callable[[str], None], plan: Plan | None = None
) -> tuple[str, bool]:
    """Run the benchmark; a line of progress every few scenes on ``say``.

    Raises SensingError where the picture cannot be written.
    """
    from sensing.files.whole_files import write_whole

    whole, plan = Plan(), plan or (QUICK if quick else Plan())
    found = forecasts(random_world(seed), seed, plan, say)
    if picture is not None:
        write_whole(picture, drawn(found).encode())
    text, met = report("calibration", rows(found, seed), claims(found, plan.judged / whole.judged), as_json=as_json)
    return (text if as_json else f"{CAPTION}\n\n{text}"), met


def forecasts(world: World, seed: int, plan: Plan, say: Callable[[str], None]) -> list[Forecast]:
    """Learn, and forecast on scenes that learning never saw."""
    from plogic.run.perceive import Perceiver

    kb = learned_on(world, range(FIRST_OF_TRAINING + STEP * seed, FIRST_OF_TRAINING + STEP * seed + plan.training))
    say(f"rates learned on {plan.training} scenes")
    perceiver, found = Perceiver(kb), []
    for i in range(plan.judged):
        found += forecasts_of(perceiver, scene(world, STEP * seed + i), i)
        if (i + 1) % SAID_EVERY == 0:
            say(f"{i + 1}/{plan.judged} scenes, {len(found)} forecasts")
    return found


def learned_on(world: World, seeds: range) -> KnowledgeBase:
    """Σ with hit rates, clutter and priors that ``plogic kb learn-rates`` learns from the scenes of these seeds."""
    from plogic.match.gamma.data import data_of
    from plogic.rates.estimates import counted, learned
    from plogic.rates.scene_records import record_in

    records = []
    for seed in seeds:
        known = scene(world, seed)
        records.append(record_in(known.truth, data_of(known.gamma.appearances, known.gamma.camera), world.kb))
    return replace(world.kb, rates=learned(counted(records), world.kb.rates))
