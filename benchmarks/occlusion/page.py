"""docs/occlusion.md and docs/occlusion-composition.txt, from what ``plogic bench occlusion --json`` found."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from benchmarks.occlusion.bench import ARRANGED
from benchmarks.occlusion.tables import composition, composition_lines, counts_table, relations_table, sign
from benchmarks.occlusion.witness import arrangements, triples
from geometry.visibility.composition import possible_triples
from geometry.visibility.roc import ROC20

if TYPE_CHECKING:
    from collections.abc import Mapping

    from benchmarks.occlusion.tables import Composition
    from geometry.visibility.roc import Roc

LINES_FILE = "occlusion-composition.txt"
WITHHELD = "withheld", "withheld, aimed", "reliability", "withheld figures"
_HEAD = """\
# Occlusion

Written by `python docs/generate.py --occlusion BENCH.json` from `plogic bench occlusion --json` (seed 0). Do not edit.

Which of twenty ways one object occludes another (ROC-20: Randell, Witkowski, Shanahan 2001) is decided from the exact outlines of the posed
meshes and from the first surface that lines of sight meet; of any two posed opaque bodies exactly one holds (`geometry/visibility/occlusion.py`).

## Definitions

The *image* of a body is the union of its projected triangles in ideal pixels (a lens changes no topology). How two images lie to each other
is RCC-8 at a tolerance t = 0.25 px (`geometry/visibility/occlusion.py`):

* the *common interior* is the intersection of the two less a seam of t: what is thinner than 2 t is none;
* without a common interior they are EC if they come as near as t to each other, else DC;
* with one, an image is *covered* if no point of it is farther than t from the other: both EQ, neither PO, the first TPP or NTPP, the second
  TPPi or NTPPi; tangential (TPP, TPPi) if the boundaries come as near as t.

*In front* on the common interior is the body that a line of sight meets first; two surfaces nearer to each other than 1e-4 of the distance
are equally near there. Asked is an even grid of about 400 rays, and just inside every corner of every crossing of a facet of the one with a
facet of the other, where the order of two facets takes its extremes (of more than 4000 crossings an even choice; crossings narrower than
about 0.04 px are left out). If each is first somewhere, the relation is mutual. If neither is first anywhere, the surfaces coincide: each is
there together with the other, and that is mutual too.

The two are taken in an order of their own, so R(x, y) is the converse of R(y, x), bit for bit. The six coarse relations are unions of the
twenty; without the mutual ones they are Galton's LOS-14. In queries, `roc(R, X, Y)` is the fine relation, `partially_occludes(X, Y)` and so on
the coarse one, of hypotheses and of parts that are objects (`h1/roof`). A part's body is the facets of the object's mesh whose middles are
nearest to a feature of the part (`kb/clouds/cloud.py`), taken alone: what else of its own object hides it is not looked at. At most
400 pairs with parts are told in one interpretation; parts of one hypothesis are not compared with each other.

A *sign* below is who is in front (`>` x, `<` y, `*` each somewhere) and the RCC-8 term: `>tpp` has x in front, its image a tangential proper
part of y's.

## The twenty, and their conceptual neighbours

Neighbours are relations between which a continuous motion led at once, bodies never passing through each other: a *lower bound* of
neighbourhood, found by bisecting {motions} motions of each of {kinds} kinds of pairs (`benchmarks/occlusion/neighbours.py`).
"""
_COMPOSED = """\
## Composition

From R(x, y) and S(y, z), which T(x, z) can follow: how many, of the twenty, for each R (row) and S (column). What they are is in
[occlusion-composition.txt](occlusion-composition.txt), a line an entry. A `+` marks an entry that is a lower bound.

{proved}

*From above*: every three bodies without coincident surfaces have an abstract model: which of the cells (inside or outside of each image) there
are, at which cells two boundaries can meet, and for each cell in two or more images the nonempty set of depth orders that occur in it.
All models are enumerated (`geometry/visibility/composition.py`); what none has cannot be. On the images alone they give the 193 triples of
RCC-8's composition table. *From below*: connected bodies that share no volume, built for random arrangements of three images
(`benchmarks/occlusion/witness.py`, which shows that every choice of depth orders can be built over an arrangement), {built} of them asked
for their relations, {wrong} otherwise than wanted. The table is of the relations themselves, without a tolerance; with a tolerance, bodies that
are smaller than it can break it.
"""
_JUDGED = """\
## How it was checked

`plogic bench occlusion`: random posed pairs of eight kinds, each asked both ways; by dense rays, which decide a pair unless it hangs on fewer than
six rays, on what lies within two rays of an edge, or on the tolerance (half or twice of it gives another relation), and by how
the pair was made, where that decides it. Interlocking, touching and nested
bodies, equal silhouettes (each corner moved along its line of sight), stacks and clamps of blocks along the lines of sight. µs: of the
processor a pair, its two outlines given; outlines: µs of drawing the two.
"""
_DOUBT = """\
## What a relation predicts

Each relation puts an inequality on ev (formalism §3.8; `plogic/scene/worlds/predictions.py`): not to occlude changes
neither ev; a partial occluder keeps its own, and raises or keeps the other's unless it hides a detected feature of it;
what is totally occluded has no evidence either way; of a mutual pair each may rise. Every interpretation is held to
them; where one fails, that is a *reason to doubt* the poses or the matches: it is in the document under `doubts`, on
the page, in what `plogic worlds` prints, and on stderr from `plogic perceive`.
"""
_WITHHELD = """\
## Relations by evidence

Where a pose is withheld (`plogic query ... --withhold h2`, [asking](asking.md)), detections alone tell how two stand
(formalism §9.5; `plogic/sequence/unposed`):

* *known* of h2: which of its features are expected of it alone, and which of these were detected, not where. So it is
  known from which side it is seen.
* *prior*: its middle even in the image, in log depth up to e times nearer or farther than what else is accepted, the
  roll even, no volume shared (A4). How often each relation occurs there is its prior.
* *likelihood* of a pose: a feature, of h2 or of another, that it makes expected is detected with its hit rate; one that
  is hidden, by chance as clutter has it. That is the change of ev that a relation predicts, feature by feature.
* *posterior*: 4000 poses whose bodies' balls meet others' on the screen, annealed by sequential Monte Carlo to 500; and
  400 poses apart. Of 200 the relation is told, by outlines and depth, jointly to all others, and what the composition
  table excludes is left out.

Two objects of ten types, five convex, the others concave or a rod, remembered where they stand but for 0.3 degrees and
0.2 % of their size, are looked at in one Γ by the normal matching; one in ten features is missed, three in ten data are
clutter. The one is wholly in the image, the other drawn as the prior has it, and the pose of either is withheld. *3
cells*: pairs in which hiding changes so many; *first*: the true relation is the most probable. `--seed` draws others.
"""
_RARE = """\
The relations that are rare there, from pairs made for them, one before or behind the other or a rod through a hollow.
These are not drawn as the prior has them; mutual occlusion, which asks for a narrow fit, is mostly told as partial:
"""
_RELIABLE = """\
What was given to the most probable relation, and how often it held; the ECE of these beside what chance makes it were
they right, and seconds of the processor a pair:
"""


def page(bench: Mapping[str, Any], lower: Composition, upper: Composition, kinds: int, motions: int) -> str:
    """The text of docs/occlusion.md; ``bench``: the document of the benchmark."""
    rows = {
        name: [row for row in bench["rows"] if row["table"] == name]
        for name in ("pairs", "relations", "composition", *WITHHELD)
    }
    (composed,) = rows["composition"]
    same = sum(lower[pair] == upper[pair] for pair in upper)
    proved = f"Of the 400 entries {same} are proved: what no model excludes, bodies reach."
    return "\n".join([
        _HEAD.format(motions=motions, kinds=kinds),
        *relations_table(_neighbours(rows["relations"])),
        "",
        _COMPOSED.format(proved=proved, built=composed["built"], wrong=composed["built wrong"] or "none"),
        *counts_table(lower, upper),
        "",
        _JUDGED,
        *_markdown(rows["pairs"]),
        "",
        "How often each occurred: " + ", ".join(f"`{row['sign']}` {row['pairs']}" for row in rows["relations"]) + ".",
        "",
        *_markdown(bench["claims"]),
        "",
        _DOUBT,
        *_said(_WITHHELD, rows["withheld"]),
        *_said(_RARE, rows["withheld, aimed"]),
        *_said(_RELIABLE, rows["reliability"]),
        *_markdown(rows["withheld figures"]),
        "",
    ])  # fmt: skip


def _said(text: str, rows: list[dict[str, Any]]) -> list[str]:
    return [text, *_markdown(rows), ""]


def bounds() -> tuple[Composition, Composition]:
    """The composition table from below and from above."""
    return composition(triples(arrangements(np.random.default_rng(0), ARRANGED))), composition(possible_triples())


def lines(lower: Composition, upper: Composition) -> str:
    """The text of docs/occlusion-composition.txt."""
    head = [
        "R(x, y) ; S(y, z) = the relations that T(x, z) can be; after '?', those that no model excludes and no bodies were found for.",
        "Signs: > x in front, < y in front, * each somewhere, then the RCC-8 term of the images. Written by docs/generate.py --occlusion.",
        "",
    ]
    return "\n".join([*head, *composition_lines(lower, upper)]) + "\n"


def _neighbours(rows: list[dict[str, Any]]) -> list[tuple[Roc, Roc]]:
    named = {sign(r): r for r in ROC20}
    return [(named[row["sign"]], named[beside]) for row in rows for beside in row["neighbours"].split()]


def _markdown(rows: list[dict[str, Any]]) -> list[str]:
    keys = [key for key in rows[0] if key != "table"]
    body = ["| " + " | ".join(str(row[key]) for key in keys) + " |" for row in rows]
    return ["| " + " | ".join(keys) + " |", "|---" * len(keys) + "|", *body]
