"""What one view leaves to decide: the typed description that the program text and the exact worlds are both made from.

Vocabulary, each with an example value:

* ``AppearanceFact``: one datum of Γ, ``AppearanceFact(id="a1", type="l_junction", uv=(312.4, 201.9), clutter=2e-5)``
* ``PairFact``: a relation that geometry computed of two posed objects, ``PairFact("partially_occludes", "h1", "h2",
  "partially_occludes_po")``
* ``Situation``: all of it, with the reading, the mode of reconsideration and the side tables.

Nothing here is computed from probabilities; everything here is plain data that goes into ``interpretation.json`` and
comes back.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Literal

from plogic.facts.spatial import Space

if TYPE_CHECKING:
    from plogic.facts.gravity import Gravity
    from plogic.facts.hypothesis import Hypothesis
    from plogic.facts.stopped import Stopped

Reading = Literal["score", "posterior"]
Reconsider = Literal["to_B", "drop", "reassign"]


OTHERS = "(others)"
"""Id and type of the feature that stands for those that are not told; no name of a knowledge base has parentheses."""


@dataclass(frozen=True)
class AppearanceFact:
    """One datum of Γ: ``uv`` in pixels.

    ``clutter`` is the density f of clutter of its type, per pixel² (§8, posterior).
    """

    id: str
    type: str
    uv: tuple[float, float]
    clutter: float


@dataclass(frozen=True)
class PairFact:
    """``relation`` holds of the ordered pair ``(x, y)`` of hypotheses, decided by outlines and depth (§3.5-3.7).

    ``roc`` is the relation of ROC-20 that it is the coarse form of, '' in documents that do not tell it. ``parts``: of
    which part of x, and of which part of y, it is said; '' is the whole.
    """

    relation: str
    x: str
    y: str
    roc: str = ""
    parts: tuple[str, str] = ("", "")


@dataclass(frozen=True)
class Situation:
    """Everything that decides the probabilities of one image's worlds.

    ``overlaps``: unordered pairs that share volume (A4). ``rivals``: unordered pairs that never hide each other (§4.1):
    those that A4 excludes from one world and those that claim the same appearances; ``exclusive`` is the part of
    ``rivals`` that the constraints of the score reading forbid to be present together (an appearance serves one
    feature, D8). ``priors`` per type (posterior). ``smoothing`` ε replaces p by ε + (1 − 2ε) p in the *score* program's
    choices (trap c), never in the measures; 0 by default. ``dv`` per feature type and ``rank`` per object type are side
    tables for queries. ``relations`` are of whole hypotheses that can be present together, ``part_relations`` of a part
    of one and a part of another, or the whole of it. ``space`` says where bodies are, and decides no probability of a
    world; ``gravity`` who holds whom, which decides some (Σc); None where nobody said that it holds. ``rules`` is the
    author's ``rules.pl``. ``stopped`` says whether more time would have found more; it decides no probability of what
    was.
    """

    reading: Reading
    hypotheses: tuple[Hypothesis, ...]
    appearances: tuple[AppearanceFact, ...]
    reconsider: Reconsider = "to_B"
    overlaps: frozenset[tuple[str, str]] = frozenset()
    rivals: frozenset[tuple[str, str]] = frozenset()
    exclusive: frozenset[tuple[str, str]] = frozenset()
    relations: tuple[PairFact, ...] = ()
    space: Space = field(default_factory=Space)
    part_relations: tuple[PairFact, ...] = ()
    gravity: Gravity | None = None
    priors: dict[str, float] = field(default_factory=dict)
    dv: dict[str, float] = field(default_factory=dict)
    rank: dict[str, float] = field(default_factory=dict)
    smoothing: float = 0.0
    rules: str = ""
    stopped: Stopped = ""
