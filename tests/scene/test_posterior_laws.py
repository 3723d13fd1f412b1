"""Laws of the posterior reading (§8): log-likelihood ratios, explaining away, duplicates."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from situations import feature, hypothesis, random_situations, situation

from plogic.base.errors import InconsistentError
from plogic.scene.worlds.ranked_worlds import ranked_worlds

QUICK = settings(max_examples=50, deadline=None, derandomize=True, suppress_health_check=list(HealthCheck))
CLUTTER = 2e-5


def log_odds(subject, name="h1"):
    p = ranked_worlds(subject).marginals[name]
    return math.log(p / (1 - p))


@QUICK
@given(st.floats(0.05, 0.95), st.floats(1e-6, 1e-1))
def test_llr_of_an_expected_and_detected_feature(h, f):
    """ln((h + f − hf) / f), f the clutter relative to the density of the hit."""
    subject = situation([hypothesis("h1", [feature("x", density=1.0, hit_rate=h)])], "posterior")
    subject = replace(subject, appearances=tuple(replace(a, clutter=f) for a in subject.appearances))
    assert log_odds(subject) - math.log(0.3 / 0.7) == pytest.approx(math.log((h + f - h * f) / f), abs=1e-6)


@pytest.mark.parametrize("h", [0.1, 0.5, 0.9])
def test_llr_of_an_expected_and_missed_feature(h):
    subject = situation([hypothesis("h1", [feature("x", "C", hit_rate=h)])], "posterior")
    assert log_odds(subject) - math.log(0.3 / 0.7) == pytest.approx(math.log(1 - h))


@pytest.mark.parametrize("case", ["B", "D"])
def test_an_unexpected_feature_says_nothing(case):
    subject = situation([hypothesis("h1", [feature("x", case)])], "posterior")
    assert log_odds(subject) == pytest.approx(math.log(0.3 / 0.7))


def in_the_open(h):
    return replace(h, features=tuple(replace(f, hidden_by=()) for f in h.features))


def test_explaining_away_raises_the_log_odds_by_exactly_the_waived_penalties():
    hidden = [feature(f"c{i}", "C", hit_rate=0.3 + 0.1 * i, hidden_by=("front",)) for i in range(4)]
    back = hypothesis("h1", [feature("x"), *hidden])
    front = hypothesis("front", [feature("y"), feature("z")], type="sure")
    priors = {"box": 0.3, "sure": 1.0}
    without = situation([in_the_open(back)], "posterior", priors=priors)
    with_front = situation([back, front], "posterior", priors=priors)
    waived = -math.fsum(math.log(1 - f.hit_rate) for f in hidden)
    assert log_odds(with_front) - log_odds(without) == pytest.approx(waived, abs=1e-9)


def test_a_transparent_occluder_and_a_rival_explain_nothing_away():
    back = hypothesis("h1", [feature("x"), feature("c", "C", hidden_by=("front",))])
    front = hypothesis("front", [feature("y")], opaque=False)
    alone = log_odds(situation([in_the_open(back)], "posterior"))
    assert log_odds(situation([back, front], "posterior")) == pytest.approx(alone)
    rivals = frozenset({("front", "h1")})
    assert log_odds(situation([back, replace(front, opaque=True)], "posterior", rivals=rivals)) == pytest.approx(alone)


def type_presence(subject, name):
    worlds = ranked_worlds(subject, 10**6).worlds
    types = {h.id: h.type for h in subject.hypotheses}
    return math.fsum(w.probability for w in worlds if any(types[h] == name for h in w.present))


@QUICK
@given(random_situations(most=3, readings=("posterior",)))
def test_duplicating_every_hypothesis_of_a_group_changes_no_types_presence(subject):
    """Rivals for one instance share its prior: n copies of all of them have the same presence as one."""
    copies = tuple(replace(h, id=f"{h.id}_copy") for h in subject.hypotheses)
    twice = duplicated(subject, copies)
    for name in ("t1", "t2", "A Box"):
        assert type_presence(twice, name) == pytest.approx(type_presence(subject, name), abs=1e-9)


def duplicated(subject, copies):
    """Each copy stands wherever its original stands: it hides and is hidden alike, is its rival, and overlaps it."""
    ids = [h.id for h in subject.hypotheses]

    def both(pairs):
        return frozenset((x + a, y + b) for x, y in pairs for a in ("", "_copy") for b in ("", "_copy"))

    def widened(h):
        return replace(
            h,
            features=tuple(
                replace(f, hidden_by=(*f.hidden_by, *(f"{g}_copy" for g in f.hidden_by))) for f in h.features
            ),
        )

    same = frozenset((name, f"{name}_copy") for name in ids)
    return replace(
        subject,
        hypotheses=tuple(widened(h) for h in (*subject.hypotheses, *copies)),
        overlaps=both(subject.overlaps) | same,
        rivals=both(subject.rivals) | same,
        exclusive=frozenset(),
    )


RENAMED = {"h1": "zebra", "h2": "Quoted Name", "h3": "h1", "h4": "it's", "h5": "is"}


def renamed(subject):
    def pairs(them):
        return frozenset((RENAMED[x], RENAMED[y]) for x, y in them)

    return replace(
        subject,
        hypotheses=tuple(
            replace(
                h,
                id=RENAMED[h.id],
                type=h.type.upper(),
                features=tuple(replace(f, hidden_by=tuple(RENAMED[g] for g in f.hidden_by)) for f in h.features),
            )
            for h in subject.hypotheses
        ),
        overlaps=pairs(subject.overlaps),
        rivals=pairs(subject.rivals),
        exclusive=pairs(subject.exclusive),
        relations=tuple(replace(r, x=RENAMED[r.x], y=RENAMED[r.y]) for r in subject.relations),
        priors={name.upper(): p for name, p in subject.priors.items()},
    )


@QUICK
@given(random_situations())
def test_renaming_and_reordering_change_no_number(subject):
    try:
        before = ranked_worlds(subject)
    except InconsistentError:
        with pytest.raises(InconsistentError):
            ranked_worlds(renamed(subject))
        return
    after = ranked_worlds(renamed(subject)).marginals
    turned = replace(subject, hypotheses=subject.hypotheses[::-1], appearances=subject.appearances[::-1])
    for name, p in before.marginals.items():
        assert after[RENAMED[name]] == pytest.approx(p, abs=1e-12)
        assert ranked_worlds(turned).marginals[name] == pytest.approx(p, abs=1e-12)
