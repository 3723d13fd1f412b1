"""Our side of ``plogic bench worlds``: each step timed several times in turn, the median of each, and what came out."""

from __future__ import annotations

from dataclasses import dataclass, field
from statistics import median
from time import perf_counter, process_time
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from collections.abc import Callable

    from benchmarks.worlds.stock import StockRun
    from plogic.facts.situation import Situation
    from plogic.inference.graph import Beliefs
    from plogic.scene.factors.scene_graph import SceneGraph

REPEATS, ENOUGH = 9, 4.0
"""Times that everything is run (once more before, to warm up); no further time is begun after so many seconds."""
FEW, MANY = 10, 1000


@dataclass(frozen=True)
class OurRun:
    """Median processor seconds, P(present(H)) by both ways, and the probabilities of the ``FEW`` best worlds.

    ``build``: the graph from the typed description; ``infer``: all marginals from the graph; ``few``, ``many``: the
    best worlds from the graph; ``listed``: ``ranked_worlds`` with ``MANY``, from the typed description to worlds with
    their causes; ``text``: from the characters of the program to all marginals, None where that was not asked for.
    ``least``: build and infer, the least of all times.
    """

    build: float
    infer: float
    few: float
    many: float
    listed: float
    text: float | None
    least: float
    answers: dict[str, float]
    of_text: dict[str, float] = field(default_factory=dict)
    best: tuple[float, ...] = ()

    @property
    def marginals(self) -> float:
        """Seconds from the typed description to all marginals."""
        return self.build + self.infer


def ours(situation: Situation, text: StockRun | None) -> OurRun:
    """Run everything of ours on one situation; ``text`` is our run from its program, in a process of its own."""
    from plogic.scene.worlds.ranked_worlds import ranked_worlds

    _, scene, beliefs = _steps(situation)
    times = _repeated(situation)
    return OurRun(
        build=median(times["build"]),
        infer=median(times["infer"]),
        few=median(times["few"]),
        many=median(times["many"]),
        listed=median(times["listed"]),
        text=text.whole if text is not None and text.answers else None,
        least=min(build + infer for build, infer in zip(times["build"], times["infer"], strict=True)),
        answers={h: float(beliefs.low[v][s]) for h, (v, s) in scene.place.items()},
        of_text=text.answers if text is not None else {},
        best=tuple(w.probability for w in ranked_worlds(situation, FEW).worlds),
    )


def _repeated(situation: Situation) -> dict[str, list[float]]:
    times: dict[str, list[float]] = {}
    start = perf_counter()
    while not times or (len(times["build"]) < REPEATS and perf_counter() - start < ENOUGH):
        for name, seconds in _steps(situation)[0].items():
            times.setdefault(name, []).append(seconds)
    return times


def _steps(situation: Situation) -> tuple[dict[str, float], SceneGraph, Beliefs]:
    """Everything once: seconds a step, the graph, and the marginals."""
    from plogic.inference.marginals import beliefs, summed_out
    from plogic.inference.ranked import best
    from plogic.scene.factors.scene_graph import scene_graph
    from plogic.scene.worlds.ranked_worlds import ranked_worlds

    times: dict[str, float] = {}
    scene = _timed(times, "build", lambda: scene_graph(situation))
    belief = _timed(times, "infer", lambda: beliefs(scene.graph))
    ranks = summed_out(scene.graph, scene.auxiliary) if scene.auxiliary else scene.graph
    _timed(times, "few", lambda: best(ranks, FEW))
    _timed(times, "many", lambda: best(ranks, MANY))
    _timed(times, "listed", lambda: ranked_worlds(situation, MANY))
    return times, scene, belief


def _timed(times: dict[str, float], name: str, run: Callable[[], Any]) -> Any:  # noqa: ANN401 - whatever the step gives
    from plogic.inference.marginals import plan

    plan.cache_clear()  # what an earlier step remembered would make this one look faster than it is
    start = process_time()
    result = run()
    times[name] = process_time() - start
    return result
