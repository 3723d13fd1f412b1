"""``plogic bench occlusion``: ROC-20 over random posed pairs.

Exactly one, converse, against dense rays, each of the twenty; and its tables. Then what detections alone tell of pairs
of which one pose is withheld.

Every pair is asked both ways, and told by the rays of ``benchmarks.occlusion.oracle``; where its making decides the
relation, by that.
"""

from __future__ import annotations

import json
import time
from collections import Counter
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from benchmarks.occlusion.bodies import CAMERA
from benchmarks.occlusion.neighbours import neighbours
from benchmarks.occlusion.oracle import FINE, raster_relation
from benchmarks.occlusion.pairs import KINDS, pairs
from benchmarks.occlusion.tables import sign
from benchmarks.occlusion.withheld import (
    AIMED,
    QUICK_AIMED,
    QUICK_WITHHELD,
    WITHHELD,
    aimed_pairs,
    reliability_rows,
    withheld_claims,
    withheld_figures,
    withheld_pairs,
    withheld_rows,
)
from benchmarks.occlusion.witness import arrangements, checked, triples
from benchmarks.shared.claims import Claim
from geometry.visibility.composition import possible_triples
from geometry.visibility.occlusion import TOLERANCE, drawn, occlusion
from geometry.visibility.roc import ROC20, coarse, converse
from plogic.face.shown.tables import plain_table

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from benchmarks.occlusion.pairs import Pair
    from geometry.visibility.roc import Roc

PAIRS, QUICK_PAIRS = 1300, 40
"""Pairs of each kind."""
ARRANGED, QUICK_ARRANGED = 8000, 600
"""Random arrangements of images for the composition table."""
BUILT, QUICK_BUILT = 2421, 60
"""Triples whose bodies are built and asked."""
MOTIONS, QUICK_MOTIONS = 100, 2
"""Motions of each kind of pair."""
CAPTION = """\
Pairs of each kind, in ideal pixels of a 640 x 480 camera, f = 600 px; tolerance 0.25 px. converse: R(x, y) is the converse of R(y, x).
known: the relation is decided by how the pair was made. rays: decided by 80 x 80 rays over both, or, where these say otherwise than we
do, by 400 x 400; undecided: it hangs on fewer than six rays, on what lies within two rays of an edge, or on the tolerance (at half or twice of
it we say otherwise), and is left out. withheld: pairs of which one pose is withheld, by the true relation; first: it is the most
probable by what is detected; cells: hiding changes so many; aimed: one before or behind the other, or a rod through a hollow, which poses
drawn as the prior has them seldom are; reliability: of the most probable relations.
us: microseconds of the processor a pair, median and 95 %, its two outlines given; outlines: of drawing."""


@dataclass(frozen=True)
class Judged:
    """One pair: what we say of it both ways, what rays say (None: undecided), and the microseconds."""

    kind: str
    relation: Roc
    backward: Roc
    known: Roc | None
    rays: Roc | None
    spent: float
    drawing: float


def run(*, seed: int, quick: bool, as_json: bool, say: Callable[[str], None]) -> tuple[str, bool]:
    """Run the benchmark; a line of progress a kind on ``say``."""
    judged: list[Judged] = []
    for kind in KINDS:
        judged += [judge(pair) for pair in pairs(kind, QUICK_PAIRS if quick else PAIRS, seed)]
        say(f"{kind}: {sum(j.kind == kind for j in judged)} pairs")
    tables = composed(seed, quick=quick)
    say("composition: done")
    found = neighbours(QUICK_MOTIONS if quick else MOTIONS, seed)
    say(f"neighbours: {len(found)} ordered pairs")
    told = withheld_pairs(QUICK_WITHHELD if quick else WITHHELD, seed, say)
    rare = aimed_pairs(QUICK_AIMED if quick else AIMED, seed, say)
    printed = {
        "pairs": [_row(kind, judged) for kind in KINDS],
        "relations": _relations(judged, found),
        "composition": [tables],
        "withheld": withheld_rows(told),
        "withheld, aimed": withheld_rows(rare),
        "reliability": reliability_rows(told),
        "withheld figures": [withheld_figures(told)],
    }
    promised = (*claims(judged, tables, quick=quick), *([] if quick else withheld_claims(told)))
    documents = [claim.document() for claim in promised]
    met = all(claim.met for claim in promised)
    if as_json:
        rows = [{"table": name, **row} for name, some in printed.items() for row in some]
        return json.dumps({"bench": "occlusion", "rows": rows, "claims": documents}), met
    text = "\n".join(plain_table(name, rows) for name, rows in printed.items())
    return f"{CAPTION}\n\n{text}\n{plain_table('claims', documents)}", met


def judge(pair: Pair) -> Judged:
    """A pair asked both ways, and its oracles."""
    start = time.process_time()
    images = (drawn(pair.x, CAMERA), drawn(pair.y, CAMERA))
    middle = time.process_time()
    relation = occlusion(pair.x, pair.y, CAMERA, images=images)
    end = time.process_time()
    backward = occlusion(pair.y, pair.x, CAMERA)
    sure = all(
        occlusion(pair.x, pair.y, CAMERA, other, images=images) == relation for other in (TOLERANCE / 2, 2 * TOLERANCE)
    )
    rays = raster_relation(pair.x, pair.y) if sure else None
    if rays not in (None, relation):
        rays = raster_relation(pair.x, pair.y, FINE)
    return Judged(pair.kind, relation, backward, pair.known, rays, 1e6 * (end - middle), 1e6 * (middle - start))


def composed(seed: int, *, quick: bool) -> dict[str, Any]:
    """The bounds of the composition table.

    Triples that no model excludes, that bodies were found for, and whose bodies were built and asked.
    """
    upper = possible_triples()
    found = arrangements(np.random.default_rng(seed), QUICK_ARRANGED if quick else ARRANGED)
    lower = triples(found)
    built = checked(found, lower, np.random.default_rng(seed), QUICK_BUILT if quick else BUILT)
    reached = {"possible": len(upper), "reached": len(lower & upper), "beyond": len(lower - upper)}
    return reached | {"built": len(built), "built wrong": built.count(False)}


def _row(kind: str, judged: Sequence[Judged]) -> dict[str, Any]:
    some = [j for j in judged if j.kind == kind]
    spent = np.array([j.spent for j in some])
    return {
        "kind": kind,
        "pairs": len(some),
        "not converse": sum(converse(j.relation) != j.backward for j in some),
        "known": sum(j.known is not None for j in some),
        "known wrong": sum(j.known not in (None, j.relation) for j in some),
        "rays": sum(j.rays is not None for j in some),
        "rays wrong": sum(j.rays not in (None, j.relation) for j in some),
        "undecided": sum(j.rays is None and j.known is None for j in some),
        "us": f"{np.median(spent):.0f}",
        "us 95 %": f"{np.quantile(spent, 0.95):.0f}",
        "outlines": f"{np.median([j.drawing for j in some]):.0f}",
    }


def _relations(judged: Sequence[Judged], found: frozenset[tuple[Roc, Roc]]) -> list[dict[str, Any]]:
    """Each of the twenty: how often it occurred, and its neighbours."""
    count = Counter(j.relation for j in judged)
    return [
        {
            "relation": r,
            "sign": sign(r),
            "coarse": coarse(r),
            "pairs": count[r],
            "neighbours": " ".join(sign(t) for t in ROC20 if (r, t) in found),
        }
        for r in ROC20
    ]


def claims(judged: Sequence[Judged], tables: dict[str, Any], *, quick: bool) -> list[Claim]:
    """What was promised; quick runs promise fewer pairs, and no whole composition table."""
    decided = [j for j in judged if j.rays is not None]
    known = [j for j in judged if j.known is not None]
    one = [j for j in judged if j.relation in ROC20 and j.backward in ROC20]
    listed = [
        Claim("posed pairs, exactly one relation each", ">=", QUICK_PAIRS * len(KINDS) if quick else 10_000, len(one)),
        Claim("pairs without exactly one relation", "<=", 0, len(judged) - len(one)),
        Claim(
            "pairs of which R(x, y) is not the converse of R(y, x)",
            "<=",
            0,
            sum(converse(j.relation) != j.backward for j in judged),
        ),
        Claim(
            "agreement with the rays where they decide",
            ">=",
            1.0,
            sum(j.rays == j.relation for j in decided) / max(len(decided), 1),
        ),
        Claim(
            "pairs that the rays or their making decide, share",
            ">=",
            0.8,
            len({id(j) for j in (*decided, *known)}) / len(judged),
        ),
        Claim(
            "agreement with how a pair was made",
            ">=",
            1.0,
            sum(j.known == j.relation for j in known) / max(len(known), 1),
        ),
        Claim("relations of the twenty that occur", ">=", 15 if quick else 20, len({j.relation for j in judged})),
        Claim("composition: triples that bodies reach and no model allows", "<=", 0, tables["beyond"]),
        Claim("composition: built bodies in another relation", "<=", 0, tables["built wrong"]),
    ]
    return (
        listed
        if quick
        else [
            *listed,
            Claim("composition: possible triples not reached", "<=", 0, tables["possible"] - tables["reached"]),
        ]
    )
