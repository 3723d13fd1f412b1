"""Each trap of §8 that concerns programs, with a test of its consequence."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest
from problog.formula import LogicFormula
from problog.program import PrologString
from situations import feature, hypothesis, situation
from stock_worlds import assert_same_worlds, stock

from plogic.base.errors import InconsistentError
from plogic.scene.text.program_text import program_text, query_lines
from plogic.scene.worlds.ranked_worlds import ranked_worlds


def logit(p):
    return math.log(p / (1 - p))


def test_a_rivals_that_share_an_appearance_have_exactly_one_cause_each():
    """Both may be present in the posterior, but an appearance is explained once, and no second detector is free."""
    pair = [hypothesis(name, [feature("x", match="a")]) for name in ("h1", "h2")]
    subject = situation(pair, "posterior")
    theirs = stock(
        program_text(subject)
        + "query(cause(_, _, _)). query(noise(_)). both :- cause(a, h1, x), cause(a, h2, x). query(both)."
    )
    assert theirs["both"] == 0.0
    assert theirs["cause(a,h1,x)"] + theirs["cause(a,h2,x)"] + theirs["noise(a)"] == pytest.approx(1, abs=1e-9)
    assert_same_worlds(subject)


def test_b_a_fully_hidden_phantom_is_not_present():
    phantom = hypothesis("h2", [feature(f"x{i}", "C", hidden_by=("h1",)) for i in range(4)])
    front = hypothesis("h1", [feature("y0"), feature("y1")])
    for mode in ("to_B", "drop", "reassign"):
        assert ranked_worlds(situation([front, phantom], mode=mode)).marginals == {"h1": 1.0, "h2": 0.0}


def test_b_one_detected_feature_makes_it_count():
    seen = hypothesis("h2", [feature("x", "A"), *(feature(f"x{i}", "C", hidden_by=("h1",)) for i in range(4))])
    assert ranked_worlds(situation([hypothesis("h1", [feature("y")]), seen])).marginals["h2"] == 1.0


def test_c_smoothing_moves_the_dogmatic_and_is_off_by_default():
    certain = [hypothesis("h1", [feature("x")]), hypothesis("h2", [feature("y")])]
    clash = frozenset({("h1", "h2")})
    with pytest.raises(InconsistentError, match="h1, h2"):
        ranked_worlds(situation(certain, overlaps=clash))
    smoothed = situation(certain, overlaps=clash, smoothing=0.05)
    assert ranked_worlds(smoothed).marginals["h1"] == pytest.approx(0.95 * 0.05 / (1 - 0.95**2))
    assert "0.05" not in program_text(situation(certain))
    assert_same_worlds(smoothed)


def test_d_unexplained_data_cost_something():
    """With everything detected the present hypothesis beats the empty world, though its prior is small."""
    good = hypothesis("h1", [feature(f"x{i}") for i in range(5)])
    assert ranked_worlds(situation([good], "posterior", priors={"box": 0.01})).worlds[0].present == ("h1",)


def test_e_a_common_appearance_is_not_noise_when_its_clutter_is_rare():
    """The odds of cause against noise are densities against clutter; dv does not enter."""
    common = hypothesis("h1", [feature(f"x{i}", dv=0.15) for i in range(3)])
    world = ranked_worlds(situation([common], "posterior")).worlds[0]
    assert world.causes == {f"a_x{i}": f"h1/x{i}" for i in range(3)}
    without_dv = replace(common, features=tuple(replace(f, dv=0.0) for f in common.features))
    assert ranked_worlds(situation([without_dv], "posterior")).worlds[0].probability == world.probability


@pytest.mark.parametrize("mode", ["to_B", "drop", "reassign"])
@pytest.mark.parametrize("count", [2, 3])
def test_f_cyclic_occlusion_is_one_alternative_over_joint_states(mode, count):
    """Mutual occlusion, and A before B before C before A; an occluder outside the cycle; each equal to ProbLog."""
    ring = [
        hypothesis(
            f"h{i}",
            [
                feature("x"),
                feature("y", "C", hidden_by=(f"h{(i + 1) % count}", "front")),
                feature("z", "D"),
                feature("u", "A"),
            ],
        )
        for i in range(count)
    ]
    front = hypothesis("front", [feature("x", match="b1"), feature("y", "C")])
    subject = situation([*ring, front], mode=mode)
    ranking = assert_same_worlds(subject)
    assert "occluders(block(1), [front])." in program_text(subject)
    assert 0 < ranking.marginals["h0"] < 1


def test_f_presence_depends_on_occluders():
    """The score of what is hidden rises with the occluder, so the worlds are not the product of the marginals."""
    front = hypothesis("h1", [feature("x"), feature("y", "C")])
    back = hypothesis("h2", [feature("x", match="b"), feature("z", "C", hidden_by=("h1",))])
    ranking = ranked_worlds(situation([front, back]))
    both = next(w.probability for w in ranking.worlds if len(w.present) == 2)
    assert both == pytest.approx(0.5)
    assert both != pytest.approx(ranking.marginals["h1"] * ranking.marginals["h2"])


def test_f_a_cycle_without_a_stable_state_accepts_none():
    """Each state contradicts itself: h1 holds for certain only without h2, h2 only with h1."""
    first = hypothesis("h1", [feature("x", hidden_by=("h2",))])
    second = hypothesis("h2", [feature("y", "D"), feature("z", "C", hidden_by=("h1",), match=None)])
    subject = situation([first, second])
    assert_same_worlds(subject)


@pytest.mark.parametrize("density", [1e-9, 1e-6, 2e-5])
def test_g_hundreds_of_weak_appearances(density):
    """The mass of the evidence is far below 1e-100, and stock ProbLog gives the same marginals."""
    many = [
        hypothesis(f"h{i}", [feature(f"x{j}", match=f"a{i}_{j}", density=density) for j in range(100)])
        for i in range(2)
    ]
    missed = hypothesis("h2", [feature(f"x{j}", "C") for j in range(100)])
    subject = situation([*many, missed], "posterior")
    ranking = ranked_worlds(subject)
    theirs = stock(program_text(subject) + query_lines(subject))
    assert ranking.log_evidence < -1000
    for name, p in ranking.marginals.items():
        assert theirs[f"present({name})"] == pytest.approx(p, abs=1e-9)


def test_g_labels_are_never_below_problogs_threshold():
    subject = situation(
        [hypothesis("h1", [feature("x", density=1e-30), feature("y", dv=1e-12), feature("z", "C", hit_rate=1e-15)])],
        "posterior",
    )
    for reading in ("posterior", "score"):
        text = (
            program_text(replace(subject, reading=reading))
            + "query(hit(_, _)). query(pick(_, _)). query(chosen(_, _))."
        )
        asked = PrologString(text + " hit(_, _) :- fail. pick(_, _) :- fail. chosen(_, _) :- fail.")
        labels = [float(p) for p in LogicFormula.create_from(asked).get_weights().values() if p is not True]
        assert len(labels) > 2
        assert min(labels) >= 1e-9
        assert_same_worlds(replace(subject, reading=reading))
