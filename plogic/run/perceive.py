"""From Γ to an interpretation: the cycle, the situation, its worlds, and the document that holds them all."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from time import monotonic

import numpy as np
from numpy.typing import NDArray

from geometry.files.remembered import cache_folder
from kb.clouds.cloud import KnowledgeBase
from plogic.base.clock import Stopwatch
from plogic.base.errors import InconsistentError, InputError
from plogic.base.jobs import processors
from plogic.cycle.delta import Delta, Options, delta_of, pictured
from plogic.cycle.judging import over_instances
from plogic.cycle.perception import Seed, perceive
from plogic.cycle.state import Cycle, Task
from plogic.facts.document import Interpretation, StepRow
from plogic.facts.hypothesis import Hypothesis
from plogic.facts.situation import SEARCH, WORLDS, Stopped
from plogic.logic.served.engine import within
from plogic.match.gamma.data import Data, data_of
from plogic.match.kinds import FAST, GENERATORS, models_of
from plogic.measures.distinctiveness import distinctiveness, instance_counts
from plogic.run.document import IMPOSSIBLE, document_of
from plogic.run.lens import focal_doubt
from plogic.scene.readings.unfinished import marked
from plogic.scene.worlds.ranked_worlds import Ranking, ranked_worlds
from sensing.appearance import Gamma
from sensing.pixels.photo import Photo
from sensing.uncollected import uncollected

SMOOTHED = 0.001
"""ε that the score program falls back to where no world is left at 0."""
AFTER = 0.1
"""Seconds that the worlds of what was found may take, however near the deadline is: they take some milliseconds, as a
rule."""
RULES = 1.0
"""Seconds that the rules of an author may take then: a process reads them, which starts in half of one."""
LISTED_WORLDS = 100
"""Worlds that an interpretation lists; the mass of the others is stated."""


class Perceiver:
    """A knowledge base made ready: dv and the view cells of its types, computed once and used for any number of images.

    ``cache``: a folder in which the index over many types is kept between runs; ``processes``: how many search an image
    for learned types, this one and copies of it (``plogic.base.jobs`` says when there may be more than one).
    ``generator``: who proposes poses of types written by hand, ``index``, the fast search, or a plain one,
    ``quadruples`` or ``softposit``; all else is the same, and learned types have their own search.

    Raises:
        InputError: where there is no such generator.
    """

    def __init__(self, kb: KnowledgeBase, cache: Path | None = None, processes: int = 1, generator: str = FAST) -> None:
        if generator not in GENERATORS:
            raise InputError(f"generator: {generator!r} is none of {', '.join(GENERATORS)}")
        self.kb, self.processes = kb, processes
        self.dv = distinctiveness(instance_counts(kb.types))
        self.width = kb.words.centroids.shape[1] if kb.words is not None else 128
        self.models = models_of(kb, self.dv, cache, generator)
        if processes > 1:
            for kind in self.models.kinds.values():
                kind.make_ready()

    def __call__(
        self,
        gamma: Gamma,
        options: Options | None = None,
        image: NDArray[np.uint8] | None = None,
        clock: Stopwatch | None = None,
    ) -> Interpretation:
        """The interpretation document of one Γ; ``image`` (H, W, 3), if it is known, tells how poses fit its pixels.

        An empty Γ gives the empty world.
        """
        options, clock = options or Options(), clock or Stopwatch()
        return self.document(gamma, *self.cycle(gamma, options, clock, image=image), options, image, clock)

    def document(
        self,
        gamma: Gamma,
        data: Data,
        cycle: Cycle,
        options: Options,
        image: NDArray[np.uint8] | None,
        clock: Stopwatch,
    ) -> Interpretation:
        """The interpretation document of what the cycle came to."""
        left = math.inf if options.end is None else max(options.end - monotonic(), RULES)
        with within(left):
            gamma, (delta, rejected, trace) = gamma.in_order(), self._facts(data, cycle, options, clock)
            with clock.stage("worlds"):
                delta, ranking = ranked(
                    delta, trace, None if options.end is None else max(options.end - monotonic(), AFTER)
                )
                late = not ranking.exact and options.end is not None
                stopped = _stopped(trace, late=late)
            with clock.stage("document"):
                document = document_of(
                    self.kb, gamma, delta, rejected, trace, ranking, image, seconds=AFTER if late else None
                )
                doubt = focal_doubt(document, gamma.camera)
            if doubt is not None:
                document = {**document, "camera_doubt": doubt}
            return marked(document, ranking, stopped) if stopped else document

    def accepted(
        self, gamma: Gamma, image: NDArray[np.uint8] | None = None, clock: Stopwatch | None = None
    ) -> list[tuple[Hypothesis, float]]:
        """What is accepted of one Γ, with its probability.

        What the interpretation document says of it, where nobody reads the rest.
        """
        clock = clock or Stopwatch()
        data, cycle = self.cycle(gamma, Options(), clock, image=image)
        with clock.stage("worlds"):
            delta = delta_of(cycle, data, self.kb, self.dv, Options(), related=False)
            delta, ranking = ranked(delta, cycle.trace.document())
        return [
            (belief, ranking.marginals[name]) for name, belief in delta.beliefs.items() if belief.status == "accepted"
        ]

    def delta(
        self, gamma: Gamma, options: Options, clock: Stopwatch
    ) -> tuple[Delta, tuple[Hypothesis, ...], list[StepRow]]:
        """Δh with its facts, what was rejected, and the trace."""
        return self._facts(*self.cycle(gamma, options, clock), options, clock)

    def _facts(
        self, data: Data, cycle: Cycle, options: Options, clock: Stopwatch
    ) -> tuple[Delta, tuple[Hypothesis, ...], list[StepRow]]:
        with clock.stage("facts"):
            cycle, dv = over_instances(cycle, self.kb) if options.dv_over == "instances" else (cycle, self.dv)
            delta = delta_of(cycle, data, self.kb, dv, options, models=self.models)
            delta = pictured(delta, data, self.models, self.processes)
        return delta, cycle.rejected, cycle.trace.document()

    def cycle(
        self,
        gamma: Gamma,
        options: Options,
        clock: Stopwatch,
        seeds: Sequence[Seed] = (),
        usual: Mapping[str, int] | None = None,
        image: NDArray[np.uint8] | None = None,
    ) -> tuple[Data, Cycle]:
        """Γ as arrays, in its own order (``Gamma.in_order``), and what the cycle comes to in it.

        ``seeds`` are what is remembered to stand here, the surest first; ``usual``: how many data of each type are left
        unexplained here, as a rule. ``image`` (H, W, 3): what Γ was detected in.
        """
        photo = None if image is None else Photo(image, gamma.camera)
        data = data_of(gamma.in_order().appearances, gamma.camera, self.width, photo)
        with clock.stage("search"), uncollected():
            task = Task(data, self.kb, self.models, self.dv, options.end, self.processes, clock.at)
            cycle = perceive(task, seeds=seeds, usual=usual)
        return data, cycle


def _stopped(trace: list[StepRow], *, late: bool) -> Stopped:
    """Where the deadline came; the trace tells it."""
    if any(step["event"] == "deadline" for step in trace):
        return SEARCH
    if not late:
        return ""
    what = "the deadline was reached: probabilities are known within intervals"
    trace.append(_step(len(trace) + 1, "deadline", what))
    return WORLDS


def perceiver_of(kb: KnowledgeBase, generator: str = FAST, processes: int | None = None) -> Perceiver:
    """A perceiver whose index is kept between runs, with the stated processes or those that the machine can lend."""
    return Perceiver(kb, cache_folder("indices"), processors() if processes is None else processes, generator)


def ranked(delta: Delta, trace: list[StepRow], seconds: float | None = None) -> tuple[Delta, Ranking]:
    """The worlds of Δh; with ``seconds``, what is known of them by then.

    Where dogmatic P(ev) of 0 and 1 leave none (§8, trap c), or none with anything that was accepted, the program is
    smoothed, if that helps. The trace says so, and of which accepted hypotheses the probability is 0.
    """
    lost = False
    accepted = [name for name, belief in delta.beliefs.items() if belief.status == "accepted"]
    try:
        ranking = ranked_worlds(delta.situation, LISTED_WORLDS, seconds=seconds)
        lost = delta.situation.reading == "score" and {ranking.marginals[name] for name in accepted} == {0.0}
        why = "no possible world holds anything that was accepted" if lost else ""
    except InconsistentError as error:
        why = str(error)
        if delta.situation.smoothing > 0.0:
            raise
    if why and delta.situation.smoothing == 0.0:
        smoothed = replace(delta, situation=replace(delta.situation, smoothing=SMOOTHED))
        again = ranked_worlds(smoothed.situation, LISTED_WORLDS, seconds=seconds)
        if not lost or any(again.marginals[name] for name in accepted):  # else the author's constraints exclude it all
            remedy = f"the score program is smoothed by {SMOOTHED}; --reading posterior has no such certainties"
            trace.append(_step(len(trace) + 1, "smooth", f"{why}: {remedy}"))
            delta, ranking = smoothed, again
    for name in (name for name in accepted if ranking.marginals[name] == 0.0):
        trace.append(_step(len(trace) + 1, "impossible", IMPOSSIBLE, name, delta.beliefs[name]))
    return delta, ranking


def _step(number: int, event: str, why: str, name: str | None = None, of: Hypothesis | None = None) -> StepRow:
    """One more of a trace that is written already."""
    return {
        "step": number,
        "event": event,
        "hypothesis": name,
        "type": None if of is None else of.type,
        "ev": None if of is None else of.ev,
        "why": why,
    }
