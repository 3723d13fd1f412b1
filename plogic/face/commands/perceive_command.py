"""``plogic perceive``: an image or Γ to an interpretation."""

from __future__ import annotations

import json
from pathlib import Path
from time import monotonic
from typing import TYPE_CHECKING, Any

from plogic.base.errors import InputError
from plogic.run.sources import gamma_of, image_of, is_gamma, kb_of

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from numpy.typing import NDArray

    from kb.clouds.cloud import KnowledgeBase
    from plogic.base.clock import Stopwatch
    from plogic.facts.document import HypothesisRow, Interpretation, RejectedRow

UNFINISHED = 3
"""Exit status: the deadline was reached, with the best answer so far printed and marked."""


def perceive_command(
    source: str,
    kb_folder: str,
    out: str,
    options: Mapping[str, Any],
    *,
    say: Callable[[str], None],
    write: Callable[[str], None],
) -> int:
    """Read, interpret, write; returns the exit status. Nothing is written where something is wrong with the input."""
    from plogic.base.clock import Stopwatch
    from plogic.base.jobs import processors
    from plogic.base.remembered import cache_folder
    from plogic.cycle.delta import Options
    from plogic.facts.interpretation import text_of
    from plogic.run.perceive import Perceiver
    from sensing.files.whole_files import check_places

    clock = Stopwatch()
    check_places(places(out, options))
    with clock.stage("read"):
        kb = kb_of(kb_folder)
        picture = None if is_gamma(source) else image_of(source, options.get("camera"))
    tell_unchecked(kb, say)
    gamma, image = gamma_of(source, picture, options.get("camera"), kb, clock)
    with clock.stage("index"):
        perceiver = Perceiver(kb, cache_folder("indices"), processors(), options["generator"])
    end = monotonic() + options["deadline"] if options.get("deadline") else None
    chosen = Options(options["reading"], options["reconsider"], options["smoothing"], end)
    document = perceiver(gamma, chosen, image, clock)
    write_all(document, text_of(document), out, options, image, clock, write)
    say(summary(document, clock))
    for line in _doubts(document):
        say(line)
    return UNFINISHED if document.get("unfinished") else 0


def tell_unchecked(kb: KnowledgeBase, say: Callable[[str], None]) -> None:
    """Say which part of Σ cannot be checked on this machine."""
    from sensing.simulated.physics import INSTALL, NO_PHYSICS, has_physics

    if kb.gravity and not has_physics():
        say(f"who holds whom is not checked, for {NO_PHYSICS}: {INSTALL}")


def places(out: str, options: Mapping[str, Any]) -> list[Path]:
    """The files that will be written. Raises InputError where one is named for two outputs."""
    named = [Path(options[key]) for key in ("report", "picture", "timings") if options.get(key)] + [Path(out)] * (
        out != "-"
    )
    for path in named:
        if named.count(path) > 1:
            raise InputError(f"{path}: is named for two outputs")
    return named


def write_all(
    document: Interpretation,
    text: str,
    out: str,
    options: Mapping[str, Any],
    image: NDArray[Any] | None,
    clock: Stopwatch,
    write: Callable[[str], None],
) -> None:
    """Make everything first, then write: a failure leaves nothing half done."""
    from sensing.files.whole_files import write_files

    files: dict[Path, bytes] = {}
    if options.get("report"):
        from plogic.face.pages.report import page

        files[Path(options["report"])] = page(document).encode()
    if options.get("picture"):
        files[Path(options["picture"])] = picture_of(document, image)
    if options.get("timings"):
        timings = {"format": "timings/1", "seconds": clock.seconds, "total": clock.total}
        files[Path(options["timings"])] = json.dumps(timings, indent=1).encode()
    if out != "-":
        files[Path(out)] = text.encode()
    write_files(files)
    if out == "-":
        write(text)


def picture_of(document: Interpretation, image: NDArray[Any] | None) -> bytes:
    """The overlay of figure 5 as PNG."""
    import cv2

    from plogic.face.shown.overlay import overlay

    return bytes(cv2.imencode(".png", overlay(document, image))[1].tobytes())


def _doubts(document: Interpretation) -> list[str]:
    """What the relations of accepted objects predict in vain (§3.8); of others the document says it."""
    from plogic.scene.worlds.predictions import Doubt, said

    accepted = {h["id"] for h in document["hypotheses"] if h["status"] == "accepted"}
    shown = [row for row in document["doubts"] if set(row["args"]) <= accepted]
    return [
        said(Doubt(row["relation"], (row["args"][0], row["args"][1]), row["expected"], row["found"], row["why"]))
        for row in shown
    ]


def summary(document: Interpretation, clock: Stopwatch) -> str:
    """One line: what was found, whether that is all, and how long it took."""
    from plogic.facts.situation import stopped_in
    from plogic.scene.readings.unfinished import REASONS

    stopped = stopped_in(document)
    accepted = [h for h in document["hypotheses"] if h["status"] == "accepted"]
    names = ", ".join(f"{h['id']} {h['type']} ({_chance(h)})" for h in accepted) or "no known object"
    names = f"{names}; {REASONS[stopped]}" if stopped else names
    stages = ", ".join(f"{name} {seconds * 1000:.0f} ms" for name, seconds in clock.seconds.items())
    return f"{len(document['appearances'])} appearances; {names}; {stages}"


def _chance(h: HypothesisRow | RejectedRow) -> str:
    """A probability to three places; of what is unfinished, with its interval."""
    low, high = h.get("interval") or (None, None)
    return f"{h['probability']:.3f}" + ("" if low is None else f" in {low:.3f}..{high:.3f}")
