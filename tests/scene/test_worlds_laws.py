"""Laws of ranked worlds: what sums to what, in which order, and what changes nothing."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from enumeration import log_weights
from hypothesis import HealthCheck, assume, given, settings
from hypothesis import strategies as st
from situations import feature, hypothesis, random_situations, situation
from tangles import tangle

from plogic.base.clock import Clock
from plogic.base.errors import InconsistentError, LimitError
from plogic.facts.situation import AppearanceFact
from plogic.scene.factors.scene_graph import scene_graph
from plogic.scene.worlds.ranked_worlds import ranked_worlds, weighed

QUICK = settings(max_examples=80, deadline=None, derandomize=True, suppress_health_check=list(HealthCheck))


def ranked_or_none(subject, n=10**6, **options):
    try:
        return ranked_worlds(subject, n, **options)
    except InconsistentError:
        assume(condition=False)


@QUICK
@given(random_situations())
def test_worlds_sum_to_the_evidence_and_marginals_to_worlds(subject):
    ranking = ranked_or_none(subject)
    assert ranking.log_evidence == pytest.approx(float(np.logaddexp.reduce(log_weights(subject))), abs=1e-9)
    assert math.fsum(w.probability for w in ranking.worlds) == pytest.approx(1.0)
    for h in subject.hypotheses:
        assert math.fsum(w.probability for w in ranking.worlds if h.id in w.present) == pytest.approx(
            ranking.marginals[h.id], abs=1e-12
        )


@QUICK
@given(random_situations(), st.integers(0, 6))
def test_a_shorter_list_is_the_beginning_of_a_longer_one_and_says_what_it_left_out(subject, n):
    whole = ranked_or_none(subject)
    short = ranked_worlds(subject, n)
    assert short.worlds == whole.worlds[:n]
    assert list(whole.worlds) == sorted(whole.worlds, key=lambda w: (-float(f"{w.probability:.9e}"), w.present))
    rest = math.fsum(w.probability for w in whole.worlds[n:])
    assert short.unlisted[0] - 1e-12 <= rest <= short.unlisted[1] + 1e-12


@QUICK
@given(random_situations())
def test_names_change_nothing(subject):
    """Names that keep the order of ids, which breaks ties."""
    assume(len(subject.hypotheses) > 1)
    new = {h.id: f"a name, {h.id}" for h in subject.hypotheses}

    def renamed(pairs):
        return frozenset((new[x], new[y]) for x, y in pairs)

    hypotheses = tuple(
        replace(
            h,
            id=new[h.id],
            features=tuple(replace(f, hidden_by=tuple(new[g] for g in f.hidden_by)) for f in h.features),
        )
        for h in subject.hypotheses
    )
    other = replace(
        subject,
        hypotheses=hypotheses,
        overlaps=renamed(subject.overlaps),
        rivals=renamed(subject.rivals),
        exclusive=renamed(subject.exclusive),
        relations=(),
    )
    ranking, again = ranked_or_none(subject), ranked_or_none(other)
    assert [w.probability for w in again.worlds] == [w.probability for w in ranking.worlds]
    assert [w.present for w in again.worlds] == [tuple(new[h] for h in w.present) for w in ranking.worlds]


def chain(count, seed=0):
    """Each shares an appearance with the next, and hides a feature of the one after: one piece, of any length."""
    rng = np.random.default_rng(seed)
    members = []
    for i in range(count):
        before = (f"h{i - 2}",) if i > 1 else ()
        own = [
            feature("x", "A", match=f"a{i}", density=float(rng.choice([0.01, 0.05, 0.2]))),
            feature("y", "A", match=f"a{i + 1}", density=float(rng.choice([0.01, 0.1])), hidden_by=before),
            feature("z", "C", hit_rate=float(rng.choice([0.3, 0.9])), hidden_by=before),
        ]
        members.append(hypothesis(f"h{i}", own))
    return situation(members, "posterior")


def test_more_than_sixteen_that_hang_together_equal_enumeration():
    subject = chain(18)
    weights = log_weights(subject)
    evidence = float(np.logaddexp.reduce(weights))
    ranking = ranked_worlds(subject, 50)
    assert ranking.log_evidence == pytest.approx(evidence)
    best = np.sort(np.exp(weights - evidence))[::-1][:50]
    assert [w.probability for w in ranking.worlds] == pytest.approx(list(best))
    probabilities = np.exp(weights - evidence)
    for i in range(18):
        present = np.arange(len(weights)) >> i & 1 == 1
        assert ranking.marginals[f"h{i}"] == pytest.approx(float(probabilities[present].sum()))


@cache
def of_a_tangle():
    """The exact ranking of all worlds of a tangle of 15."""
    return ranked_worlds(tangle(15), 2**15)


@pytest.mark.parametrize("seconds", [0.0, 0.001, 0.05])
def test_intervals_contain_what_is_exact_at_every_deadline(seconds):
    exact, hurried = of_a_tangle(), ranked_worlds(tangle(15), 5, seconds=seconds)
    low, high = hurried.log_evidence_interval
    assert low - 1e-9 <= exact.log_evidence <= high + 1e-9
    for h, (least, most) in hurried.intervals.items():
        assert least - 1e-9 <= exact.marginals[h] <= most + 1e-9
    every = {w.present: w.probability for w in exact.worlds}
    assert hurried.worlds
    for w in hurried.worlds:
        assert w.interval[0] - 1e-9 <= every[w.present] <= w.interval[1] + 1e-9
    rest = 1.0 - math.fsum(every[w.present] for w in hurried.worlds)
    assert hurried.unlisted[0] - 1e-9 <= rest <= hurried.unlisted[1] + 1e-9


def test_a_ranking_that_gives_up_keeps_what_it_has_only_under_a_deadline(monkeypatch):
    whole = ranked_worlds(chain(4), 2)

    def two_and_no_more(scene, _):
        every = weighed(scene, Clock(None))
        yield next(every)
        yield next(every)
        raise LimitError("the queue is full")

    monkeypatch.setattr("plogic.scene.worlds.ranked_worlds.weighed", two_and_no_more)
    assert ranked_worlds(chain(4), 9, seconds=60).worlds == whole.worlds
    with pytest.raises(LimitError):
        ranked_worlds(chain(4), 9)


@pytest.mark.parametrize("reading", ["score", "posterior"])
def test_thousands_of_weak_appearances_neither_underflow_nor_raise(reading):
    own = [feature(f"f{i}", "A", match=f"a{i}", density=1e-9, hit_rate=0.01, dv=1e-4) for i in range(3000)]
    missed = [feature(f"m{i}", "C", hit_rate=0.5, dv=1e-4) for i in range(3000)]
    subject = situation([hypothesis("h1", own + missed), hypothesis("h2", own[:1500])], reading)
    subject = replace(
        subject, appearances=tuple(AppearanceFact(a.id, a.type, a.uv, 1e-12) for a in subject.appearances)
    )
    ranking = ranked_worlds(subject)
    assert math.isfinite(ranking.log_evidence)
    assert math.fsum(w.probability for w in ranking.worlds) == pytest.approx(1.0)


def test_very_many_claimants_of_one_appearance():
    """Seventeen claim the same, two of them behind others: its cause is a variable of its own."""
    members = [
        hypothesis(
            f"h{i}",
            [feature("x", "A", match="a", density=0.01 * (i + 1), hit_rate=0.7, hidden_by=("h16",) if i < 2 else ())],
        )
        for i in range(17)
    ]
    subject = situation(members, "posterior", priors={"box": 0.2})
    assert "a" in scene_graph(subject).causes
    weights = log_weights(subject)
    ranking = ranked_worlds(subject, 20)
    assert ranking.log_evidence == pytest.approx(float(np.logaddexp.reduce(weights)))
    assert [w.probability for w in ranking.worlds] == pytest.approx(
        list(np.sort(np.exp(weights - ranking.log_evidence))[::-1][:20])
    )


def test_more_occluders_than_one_factor_can_have():
    """Eighteen hide features of one: its pick is a variable of its own."""
    front = [
        hypothesis(f"g{i}", [feature("u", "A", match=f"g{i}", dv=0.3), feature("w", "C", dv=0.1)]) for i in range(17)
    ]
    hidden = [
        feature(f"c{i}", "AC"[i % 2], match=f"own{i}" if i % 2 == 0 else None, dv=0.1 * (i + 1), hidden_by=(f"g{i}",))
        for i in range(17)
    ]
    subject = situation([*front, hypothesis("h", [*hidden, feature("d", "B", hidden_by=("g1",))])], smoothing=0.01)
    assert scene_graph(subject).auxiliary
    weights = log_weights(subject)
    ranking = ranked_worlds(subject, 10)
    assert ranking.log_evidence == pytest.approx(0.0, abs=1e-9)
    assert [w.probability for w in ranking.worlds] == pytest.approx(list(np.sort(np.exp(weights))[::-1][:10]))
    present = np.arange(len(weights)) >> 17 & 1 == 1
    assert ranking.marginals["h"] == pytest.approx(float(np.exp(weights[present]).sum()))
