"""What ``plogic bench scale`` prints: tables, and the claims.

* ``Vocabulary``: all that was measured with so many appearance types
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from statistics import median
from typing import TYPE_CHECKING, Any

import numpy as np

from benchmarks.scale.costs import looks_needed, need, types_under_limit
from benchmarks.scale.recall import interval, line, recall
from benchmarks.shared.claims import Claim
from plogic.match.oriented.oriented_search import USUAL
from plogic.match.oriented.pair_votes import WHOLE

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from benchmarks.scale.recall import Standing
    from benchmarks.scale.votes import Seen

    Rows = list[dict[str, Any]]

CAPTION = """\
Random types of 100 features, images of 1000 appearances, the easy detector of bench clutter. looks: appearance types in all. Seconds, ms and µs are
of the processor, one thread. The bytes of an index are those of its pairs, sights and view cells; Σ: the types themselves as Python's objects;
disk: the folder of the index. attention, votes, laying (with refining), rest: medians a frame; the rest is judging and the later rounds. recall:
how often a right vote is among those that are laid onto Γ (2000, or ten or a hundred times as many), with its 95 % interval over trials; measured:
where the true type and so many others were in one index (or, of more than were built, voted against the image with its looks exchanged). limited:
recall where, besides, one index looks at 2,000,000 entries at most a frame, as it does. right box: weight of the heaviest right one, in pairs of the
image whose angles fit, median. false: accepted where nothing in the image is of any type. GB: of a machine, of which 80 % hold the index and Σ; types
an index: no more than are not limited; s a frame: of one core, by the line of growth; only votes grow: where attention and all after the votes took
the time of no types."""
SIZES = tuple(10**i for i in range(2, 7))
GROWN = 1, 10, 100
"""Times as many votes are laid."""
FULL = 1, 2, 3, 4, 5, 6
"""Weight of a box, in pairs of the image whose angles fit."""
CLOSE, NEAR, ENOUGH, BYTES = 0.05, 0.25, 100, 2e6
STAGES = "attention", "votes", "laying", "rest"
MILLION = 10**6
MEMORIES = 64, 256
"""GB of a machine."""


@dataclass(frozen=True, eq=False)
class Vocabulary:
    """``sizes`` bytes a type; ``builds`` seconds by number of types; ``frames`` and ``standings`` by number of types.

    ``deep`` among more types.

    ``asked`` entries a type and frame; ``caps`` by number of types where they are limited as there; ``false`` accepted
    in so many ``images``.
    """

    looks: int
    sizes: Mapping[str, float]
    builds: Mapping[int, float]
    frames: Mapping[int, Sequence[Seen]]
    standings: Mapping[int, Sequence[Standing]]
    deep: Sequence[Standing]
    asked: float
    caps: Mapping[int, Sequence[Standing] | None]
    false: int
    images: int

    @property
    def types(self) -> int:
        """That were built."""
        return max(self.standings)

    def growth(self, stage: int | None = None) -> tuple[float, float]:
        """Seconds a frame without types, and for each type: of a stage, or of all."""
        return line(list(self.frames), [_seconds(some, stage) for some in self.frames.values()])

    def among(self, size: int) -> Sequence[Standing]:
        """The trials for so many types.

        Beyond those that were built, with the votes a type of all that voted, which are rarer than one a type.
        """
        if size <= self.types or not self.deep:
            return self.standings[self.types]
        longest = max(len(more.others) for more in self.deep)
        others = np.sum([np.pad(more.others, (0, longest - len(more.others))) for more in self.deep], axis=0)
        types = sum(more.types for more in self.deep)
        return [replace(standing, others=others, types=types) for standing in self.standings[self.types]]


def tables(
    measured: Sequence[Vocabulary], cells: float, memory: Mapping[str, float], rng: np.random.Generator
) -> dict[str, Rows]:
    """By title, the rows; ``cells``: seconds a type for its view cells.

    ``memory``: bytes a type of Σ, and of the index on the disk.
    """
    return {
        "a type": [_type(v, cells, memory) for v in measured],
        "a frame": [_frame(v, size) for v in measured for size in v.frames],
        "growth: ms and, a type, µs": [_growth(v) for v in measured],
        "recall": [_recall(v, size, rng) for v in measured for size in SIZES],
        "prediction from fewer types, and measurement": [row for v in measured for row in _checked(v)],
        "wrong votes in boxes so heavy: predicted from fewer types, and measured": [
            _tail(v) for v in measured if v.deep
        ],
        "one index": [_limits(v) for v in measured],
        "10^6 types, 10^6 frames an hour": [
            _million(v, memory["Σ"], gigabytes) for v in measured for gigabytes in MEMORIES
        ],
    }


def claims(measured: Sequence[Vocabulary]) -> list[Claim]:
    """Whether what is foretold of more types comes about, and how large an index is."""
    off = [abs(row["predicted"] - row["measured"]) for v in measured for row in _checked(v)]
    tails = [
        abs(foretold / max(1.0, there) - 1.0) for v in measured for foretold, there in _tails(v) if foretold >= ENOUGH
    ]
    return [
        Claim("recall: prediction from fewer types off measurement at most", "<=", CLOSE, max(off)),
        Claim(
            f"wrong votes where there are {ENOUGH} or more: prediction off measurement at most",
            "<=",
            NEAR,
            max(tails, default=0.0),
        ),
        Claim("bytes of the index a type", "<=", BYTES, max(sum(v.sizes.values()) for v in measured)),
    ]


def _seconds(some: Sequence[Seen], stage: int | None) -> float:
    return median(sum(s.stages) if stage is None else s.stages[stage] for s in some)


def _type(v: Vocabulary, cells: float, memory: Mapping[str, float]) -> dict[str, Any]:
    kilobytes = {
        name: round(size / 1e3, 1) for name, size in {**v.sizes, "index": sum(v.sizes.values()), **memory}.items()
    }
    built = {f"built {types}, ms": round(1e3 * (seconds / types + cells), 1) for types, seconds in v.builds.items()}
    return {"looks": v.looks} | {f"{name}, KB": size for name, size in kilobytes.items()} | built


def _frame(v: Vocabulary, size: int) -> dict[str, Any]:
    some = v.frames[size]
    stages = {f"{name}, ms": round(1e3 * _seconds(some, i), 1) for i, name in enumerate(STAGES)}
    found = {"found": f"{sum(s.found for s in some)}/{len(some)}", "false": sum(s.false for s in some)}
    before = {"types before it": f"{median(s.place for s in some):.0%}"}
    return (
        {"looks": v.looks, "types": size} | stages | {"all, ms": round(1e3 * _seconds(some, None), 1)} | found | before
    )


def _growth(v: Vocabulary) -> dict[str, Any]:
    row: dict[str, Any] = {"looks": v.looks}
    for i, name in [*enumerate(STAGES), (None, "all")]:
        a, b = v.growth(i)
        row |= {name: f"{1e3 * a:.1f} {1e6 * b:+.1f}"}
    return row


def _recall(v: Vocabulary, size: int, rng: np.random.Generator) -> dict[str, Any]:
    some, limited = v.among(size), v.caps.get(size)
    chances = [standing.chance(size, USUAL.laid) for standing in some]
    low, high = interval(chances, rng)
    grown = {f"laid {USUAL.laid * times}": round(recall(some, size, USUAL.laid * times), 3) for times in GROWN}
    under = grown[f"laid {USUAL.laid}"] if limited is None else round(recall(limited, size, USUAL.laid), 3)
    return {"looks": v.looks, "types": size} | grown | {"interval": f"{low:.3f} to {high:.3f}", "limited": under}


def _checked(v: Vocabulary) -> list[dict[str, Any]]:
    """From the fewer of two sizes to the greater, over all trials.

    From the greatest to the most simulated, in those trials that were.
    """
    less, many = sorted(v.standings)
    rows = [_check(v, less, v.standings[less], v.standings[many])]
    return rows + ([_check(v, many, v.standings[many][: len(v.deep)], v.deep)] if v.deep else [])


def _check(v: Vocabulary, less: int, few: Sequence[Standing], more: Sequence[Standing]) -> dict[str, Any]:
    types = more[0].types + 1
    before = [[sum(s.before(types)) for s in some] for some in (few, more)]
    return {
        "looks": v.looks, "from": less, "types": types, "trials": len(more),
        "predicted": round(recall(few, types, USUAL.laid), 3), "measured": round(recall(more, types, USUAL.laid), 3),
        "votes before it, predicted": round(float(np.mean(before[0])), 1), "measured, votes": round(float(np.mean(before[1])), 1),
    }  # fmt: skip


def _tails(v: Vocabulary) -> list[tuple[float, float]]:
    """Wrong votes of other types in boxes as heavy as each of ``FULL``, or heavier.

    As foretold from the types built, and among the most types.
    """
    few = v.standings[v.types][: len(v.deep)]
    return [
        (
            float(
                np.mean(
                    [
                        less.others[WHOLE * full :].sum() / less.types * more.types
                        for less, more in zip(few, v.deep, strict=True)
                    ]
                )
            ),
            float(np.mean([more.others[WHOLE * full :].sum() for more in v.deep])),
        )
        for full in FULL
        if v.deep
    ]


def _tail(v: Vocabulary) -> dict[str, Any]:
    said = {
        f"{full} or more": f"{foretold:.0f} / {there:.0f}"
        for full, (foretold, there) in zip(FULL, _tails(v), strict=True)
    }
    return {"looks": v.looks, "from": v.types, "types": v.deep[0].types + 1, "trials": len(v.deep)} | said


def _limits(v: Vocabulary) -> dict[str, Any]:
    right = [standing.right for standing in v.standings[v.types]]
    return {
        "looks": v.looks,
        "right box": f"{median(right) / WHOLE:.1f}, least {min(right) / WHOLE:.1f}",
        "entries a type": round(v.asked, 1),
        "types until limited": round(types_under_limit(v.asked)),
        "looks for 10^5": looks_needed(10**5, v.looks, v.asked),
        "looks for 10^6": looks_needed(MILLION, v.looks, v.asked),
        "false": f"{v.false} in {v.images} x {v.types} types",
    }


def _million(v: Vocabulary, objects: float, gigabytes: int) -> dict[str, Any]:
    of_type, most = sum(v.sizes.values()) + objects, types_under_limit(v.asked)
    whole, voting = ((v.growth()[0], v.growth(stage)[1]) for stage in (None, STAGES.index("votes")))
    n, least = (need(MILLION, float(MILLION), of_type, growth, gigabytes, most) for growth in (whole, voting))
    return {
        "looks": v.looks, "GB": gigabytes, "TB": round(n.terabytes, 2), "types an index": n.index, "indices": n.indices,
        "machines": n.machines, "s a frame": round(n.seconds, 1), "cores": n.cores,
        "s, only votes grow": round(least.seconds, 1), "cores then": least.cores,
    }  # fmt: skip
