"""What an interpretation need not tell feature by feature.

The many features of a learned type that this view leads nobody to expect.

A type learned from a mesh has up to 4,000 features, of which one view shows a hundred. The others are case B in every
world: not expected, since the hypothesis alone does not lead to expect them, and not detected, since nothing is matched
to them. To P(ev) they give the sum of their dv, to the posterior nothing; so one feature named ``OTHERS`` that carries
their sum stands for all of them, and every probability stays. Features outside the image count nowhere and are left
out. Types written by hand are told in full.

A learned compound is told, and counts, once: by the part that stands for it (``Hypothesis.stands``). Its other parts
are told for the data that they explain, and have no dv.
"""

from collections.abc import Mapping, Sequence
from typing import Literal

import numpy as np

from geometry.arrays import Mask
from kb.clouds.cloud import KnowledgeBase
from kb.clouds.lobes import Feature
from plogic.facts.document import Cells, LeftOut, LookedRow
from plogic.facts.hypothesis import FeatureFact, Hypothesis, PartFact
from plogic.facts.situation import OTHERS

Cell = Literal["expected_detected", "expected_missed", "hidden_missed", "hidden_detected"]
CELLS: dict[str, Cell] = {
    "A": "expected_detected",
    "C": "expected_missed",
    "B": "hidden_missed",
    "D": "hidden_detected",
}


def told_in_full(posed: Hypothesis) -> bool:
    """Whether all features are told: where lobes have no measured rates of their own, features are few."""
    return posed.hit is None


def told(posed: Hypothesis) -> list[int]:
    """The features that are told one by one: all of a type written by hand.

    Of a learned one what is expected alone, or matched.
    """
    if told_in_full(posed):
        return list(range(len(posed.object_type.seen_features)))
    return np.flatnonzero(_notable(posed)).tolist()


def told_as(posed: Hypothesis, f: int) -> Feature:
    """What the seen feature ``f`` is told as.

    A learned compound by the part that stands for it, its other parts as themselves.
    """
    kind = posed.object_type
    return kind.features[kind.whole[f]] if posed.stands[f] else kind.seen_features[f]


def counts(posed: Hypothesis, f: int) -> int:
    """For how many maximal features the seen feature ``f`` stands.

    One, or, as a part of a compound that another part stands for, none.
    """
    return int(posed.stands[f])


def compound_parts(posed: Hypothesis) -> tuple[PartFact, ...]:
    """The learned compounds of which something is told, as nodes of the part-whole tree (A1).

    Those written by hand are in the type's tree.
    """
    kind = posed.object_type
    if told_in_full(posed) or len(kind.features) == len(kind.seen_features):
        return ()
    whole = [kind.features[w] for w in np.unique(kind.whole[told(posed)])]
    return tuple(PartFact(f.name, f.name.rpartition("/")[0], "feature", f.type) for f in whole if f.parts)


def lumped(posed: Hypothesis, dv: Mapping[str, float]) -> tuple[FeatureFact, ...]:
    """The one feature that stands for the others in the image; none where there are none."""
    rest = np.flatnonzero(_rest(posed))
    if not len(rest):
        return ()
    u, v = posed.uv[rest].mean(axis=0).tolist()
    x, y, z = posed.at[rest].mean(axis=0).tolist()
    weight = float(np.sum([dv[told_as(posed, f).type] for f in rest.tolist()]))
    return (
        FeatureFact(
            OTHERS,
            OTHERS,
            (x, y, z),
            (u, v),
            weight,
            in_image=True,
            in_lobe=False,
            self_hidden=False,
            stands_for=len(rest),
        ),
    )


def left_out(posed: Hypothesis) -> LeftOut | None:
    """How many features are not told: those that ``OTHERS`` stands for, and those outside the image.

    None of a type written by hand.
    """
    if told_in_full(posed):
        return None
    return {
        "in_image": int(_rest(posed).sum()),
        "outside_image": int((posed.stands & ~_notable(posed) & ~posed.in_image).sum()),
    }


def types_told(dv: Mapping[str, float], kb: KnowledgeBase, hypotheses: Sequence[Hypothesis]) -> dict[str, float]:
    """The table of dv without the visual words that no told feature has."""
    if kb.words is None:
        return dict(dv)
    silent = set(kb.words.names) - {f.type for h in hypotheses for f in h.features}
    return {name: value for name, value in dv.items() if name not in silent}


def support_document(posed: Hypothesis, dv: Mapping[str, float]) -> dict[str, Cells]:
    """The four cells for each feature type.

    Of a learned type one row for all its visual words, with the sums of their dv as ``weights``.

    The rows are those of the hypothesis alone (``Hypothesis.support``): counts and weights give its ev.
    """
    rows = posed.support()
    if told_in_full(posed):
        return {
            name: {
                "expected_detected": count.A,
                "expected_missed": count.C,
                "hidden_missed": count.B,
                "hidden_detected": count.D,
            }
            for name, count in rows.items()
        }
    return {
        "visual words": {
            "expected_detected": sum(c.A for c in rows.values()),
            "expected_missed": sum(c.C for c in rows.values()),
            "hidden_missed": sum(c.B for c in rows.values()),
            "hidden_detected": sum(c.D for c in rows.values()),
            "weights": {
                cell: float(sum(getattr(c, letter) * dv[name] for name, c in rows.items()))
                for letter, cell in CELLS.items()
            },
        }
    }


def looked_at(posed: Hypothesis, ids: Sequence[str], dv: Mapping[str, float]) -> list[LookedRow]:
    """Of a rejected hypothesis of a learned type, where its features were expected or found.

    To be looked at, nothing is computed from them.
    """
    if told_in_full(posed):
        return []
    return [*(_looked(posed, f, ids) for f in told(posed)), *(_rest_looked(rest) for rest in lumped(posed, dv))]


def _looked(posed: Hypothesis, f: int, ids: Sequence[str]) -> LookedRow:
    row: LookedRow = {
        "id": told_as(posed, f).name,
        "type": told_as(posed, f).type,
        "uv": np.round(posed.uv[f], 2).tolist(),
        "in_image": bool(posed.in_image[f]),
        "in_lobe": bool(posed.in_lobe[f]),
        "self_hidden": bool(posed.self_hidden[f]),
        "hidden_by": [],
        "match": ids[posed.matches[f]] if posed.matches[f] >= 0 else None,
        "expected": bool(posed.candidate[f]),
        "detected": bool(posed.detected[f]),
    }
    if posed.hit is not None:
        row["learned_rate"] = round(float(posed.hit[f]), 4)
    return row if posed.stands[f] else {**row, "stands_for": 0}


def _rest_looked(rest: FeatureFact) -> LookedRow:
    return {
        "id": rest.id,
        "type": rest.type,
        "at": list(rest.at),
        "uv": list(rest.uv),
        "dv": rest.dv,
        "in_image": rest.in_image,
        "in_lobe": rest.in_lobe,
        "self_hidden": rest.self_hidden,
        "hidden_by": list(rest.hidden_by),
        "match": rest.match,
        "residual": rest.residual,
        "density": rest.density,
        "hit_rate": rest.hit_rate,
        "stands_for": rest.stands_for,
        "expected": False,
        "detected": False,
        "case": "B",
    }


def _notable(posed: Hypothesis) -> Mask:
    return np.asarray(posed.candidate | (posed.matches >= 0))


def _rest(posed: Hypothesis) -> Mask:
    if told_in_full(posed):
        return np.zeros(len(posed.uv), dtype=bool)
    return np.asarray(posed.stands & ~_notable(posed) & posed.in_image)
