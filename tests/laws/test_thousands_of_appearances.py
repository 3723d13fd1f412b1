"""Thousands of appearances in one piece neither underflow nor raise; they weigh as sums of logarithms say (§8, g)."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from situations import feature, hypothesis, situation

from plogic.facts.situation import AppearanceFact
from plogic.scene.asking.live import LiveScene
from plogic.scene.worlds.ranked_worlds import ranked_worlds

COUNT = 3000
CLUTTER = 1e-3
HIT = 0.6
SHARED = 500
"""Appearances that both claim."""

MISSED = 1200
"""Features of h1 that are nowhere."""


def scene(ratios, reading="posterior"):
    """h1 claims the first appearances, h2 the last.

    ``SHARED`` in the middle are claimed by both, and h3 hides one of h1's.
    """
    size = (COUNT + SHARED) // 2
    mine, other = range(size), range(COUNT - size, COUNT)

    def claims(numbers, hidden):
        return [
            feature(
                f"f{i}",
                "A",
                match=f"a{i}",
                density=CLUTTER * ratios[i],
                hit_rate=HIT,
                dv=1e-4,
                hidden_by=hidden if i == 0 else (),
            )
            for i in numbers
        ]

    missed = [feature(f"m{i}", "C", hit_rate=0.5) for i in range(MISSED)] if reading == "posterior" else []
    members = [
        hypothesis("h1", [*claims(mine, ("h3",)), *missed]),
        hypothesis("h2", claims(other, ())),
        hypothesis("h3", [feature("m", "C", hit_rate=0.1)]),
    ]
    subject = situation(members, reading, priors={"box": 0.5}, smoothing=0.01)
    return replace(subject, appearances=tuple(AppearanceFact(a.id, a.type, a.uv, CLUTTER) for a in subject.appearances))


def log_weights(ratios):
    """Present (h1, h2, h3) → ln of the weight over the empty world's, by the closed form of §8, a sum of logarithms."""
    size = (COUNT + SHARED) // 2
    found = {}
    for one, two, three in np.ndindex(2, 2, 2):
        logs = [math.log(0.9) * three, MISSED * math.log(0.5) * one]
        for i in range(COUNT):
            claimants = (one and i < size and not (three and i == 0)) + (two and i >= COUNT - size)
            logs.append(
                math.log(
                    claimants * ratios[i] * HIT * (1 - HIT) ** (claimants - 1) + (1 - HIT) ** claimants
                    if claimants
                    else 1.0
                )
            )
        found[one, two, three] = math.fsum(logs)
    return found


KINDS = {
    "near one": lambda numbers: np.exp(numbers.normal(scale=1e-3, size=COUNT)),
    "strong": lambda _: np.full(COUNT, 1e6),
    "hostile": lambda _: np.full(COUNT, 1e-6),
    "mixed": lambda numbers: 10.0 ** numbers.choice([-6.0, -0.01, 0.01, 6.0], size=COUNT),
}


@pytest.mark.parametrize("kind", KINDS)
def test_in_the_posterior_reading_they_weigh_their_closed_form(kind):
    ratios = KINDS[kind](np.random.default_rng(4)).tolist()
    logs = log_weights(ratios)
    total = float(np.logaddexp.reduce(list(logs.values())))
    subject = scene(ratios)
    ranking = ranked_worlds(subject, 8)
    empty = 3 * math.log(0.5) + COUNT * math.log(CLUTTER)
    assert ranking.log_evidence == pytest.approx(total + empty, rel=1e-12, abs=1e-8)
    ids = ("h1", "h2", "h3")
    expected = {
        tuple(h for h, here in zip(ids, key, strict=True) if here): math.exp(log - total) for key, log in logs.items()
    }
    assert {w.present: w.probability for w in ranking.worlds} == pytest.approx(expected, rel=1e-7, abs=1e-12)
    assert len(ranking.worlds) == 8, "however improbable, a world that is possible is listed"
    live = LiveScene(subject)
    for i, h in enumerate(ids):
        p = math.fsum(math.exp(log - total) for key, log in logs.items() if key[i])
        assert ranking.marginals[h] == pytest.approx(p, rel=1e-7, abs=1e-12)
        assert live.marginals()[h] == (ranking.marginals[h],) * 2


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("mode", ["drop", "to_B", "reassign"])
def test_in_the_score_reading_all_sums_hold(kind, mode):
    """The score asks for no density: that thousands of features are there is all that counts.

    H3, which is seen, hides one of them.
    """
    subject = scene(KINDS[kind](np.random.default_rng(4)).tolist(), "score")
    front = hypothesis("h3", [feature("m", "A", match="a2999")])
    subject = replace(subject, reconsider=mode, hypotheses=(*subject.hypotheses[:2], front))
    ranking = ranked_worlds(subject, 8)
    assert ranking.log_evidence == pytest.approx(0.0, abs=1e-9)
    assert math.fsum(w.probability for w in ranking.worlds) == pytest.approx(1.0, abs=1e-9)
    lost = {"drop": 0.0, "to_B": 2 / (COUNT + SHARED), "reassign": 2 / (COUNT + SHARED)}[mode]
    assert ranking.marginals == pytest.approx({"h1": 0.99 - 0.98 * lost * 0.99, "h2": 0.99, "h3": 0.99}, abs=1e-9)
