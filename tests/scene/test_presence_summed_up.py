"""The summary of a hypothesis' presence: numbers of the situation itself."""

from __future__ import annotations

from dataclasses import replace

import pytest
from situations import towers

from plogic.face.session.account_text import SCREEN, account_text
from plogic.logic.served.engine import Text
from plogic.scene.asking.explanations import explain, present
from plogic.scene.asking.presence import contributions
from plogic.scene.worlds.ranked_worlds import ranked_worlds

pytestmark = pytest.mark.usefixtures("programs_run_here")


def test_the_score_reading_counts_concordant_features_and_names_who_hides_what():
    account = present(towers(mode="to_B"), "present(t2)")
    text = "\n".join(account.summary)
    assert account.probability == pytest.approx(ranked_worlds(towers(mode="to_B"), 1).marginals["t2"])
    assert "beside t1" in text
    assert "for: expected and detected: 1 apex (apex/a0)" in text
    assert "hidden by t1, so not expected" in text
    assert "ev = 0.95" in text, "strict D7 gives 0.95 (§5.6)"


def test_in_mode_drop_what_an_occluder_explains_is_not_in_the_sum():
    """0.970 is the paper's P(ok(T2, [T1])): what is hidden and missed is neither for nor against."""
    summary = present(towers(mode="drop"), "present(t2)").summary
    assert "32 of 34 features in the image, but for 6 hidden, which mode drop leaves out" in summary[1]
    assert "0.9703 = P(ev)" in summary[1]
    assert "38 of 40 features in the image are concordant" in present(towers(mode="to_B"), "present(t2)").summary[1]


def test_the_posterior_reading_lists_log_likelihood_ratios():
    scene = towers(reading="posterior")
    text = "\n".join(present(scene, "present(t2)").summary)
    strongest = contributions(scene, "t2", ("t1", "t2"))[0]
    assert f"{strongest.llr:+.3g}" in text
    assert "excludes, as rivals" in text or "shares volume" in text


def test_given_evidence_counts():
    scene = towers(mode="to_B", smoothing=0.01)
    with_it, without = (
        present(scene, "present(t2)", given=[g]).probability for g in ("present(t1)", "\\+ present(t1)")
    )
    assert with_it > without


def test_the_account_carries_the_summary_and_its_probability_is_the_programs():
    scene = towers(mode="to_B")
    account = explain(scene, "present(t2)", most=1)
    assert account.summary == present(scene, "present(t2)").summary
    assert account.probability == pytest.approx(present(scene, "present(t2)").probability, abs=1e-9)


def test_what_takes_the_rest_of_p_ev_is_told():
    """Its rival; and an occluder that may be absent, for P(ev) is that beside it."""
    scene = towers(mode="to_B", smoothing=0.01)
    account = present(scene, "present(t2)")
    lines = [line for line in account.summary if "less than P(ev)" in line]
    rival, occluder = lines
    assert "its rival t2 t2_distorted is never together with it" in rival
    without = replace(scene, overlaps=frozenset(), exclusive=frozenset())
    assert float(rival.rsplit(" ", 1)[1]) == pytest.approx(ranked_worlds(without, 1).marginals["t2"], abs=1e-4)
    assert "which is that beside t1 t1" in occluder


def test_where_nothing_takes_of_it_nothing_is_said():
    scene = towers(mode="to_B")
    alone = replace(scene, hypotheses=scene.hypotheses[:1], overlaps=frozenset(), exclusive=frozenset())
    alone = replace(alone, rivals=frozenset(), relations=())
    assert present(alone, f"present({alone.hypotheses[0].id})").summary
    assert not [s for s in present(alone, f"present({alone.hypotheses[0].id})").summary if "less than" in s]


def test_other_goals_have_no_summary():
    assert present(towers(), "object(t2, T)") is None


def test_the_brief_text_leads_with_the_summary_and_says_how_to_get_the_rest():
    lines = account_text(present(towers(mode="to_B"), "present(t2)"), brief=True).splitlines()
    assert lines[0].startswith("P(present(t2)) = ")
    assert lines[1] == "t2 is a t2; in the most probable world that holds it, beside t1:"
    assert lines[-1] == "choice by choice: -n 5, or --json"


def test_a_question_is_answered_on_one_screen_with_what_is_left_out():
    account = explain(towers(mode="to_B"), "number_of_objects(2)")
    whole, short = account_text(account).splitlines(), account_text(account, whole="more").splitlines()
    assert len(whole) > 2 * SCREEN >= 2 * len(short)
    assert short[0] == whole[0]
    headings = [line for line in whole if line.startswith(("why", "  listed: "))]
    assert headings
    assert [line for line in short if line.startswith(("why", "  listed: "))] == headings
    left = len(whole) - len(short) + 2
    assert short[-1] == f'(the reasons end at "...", {left} lines are left out: more)'
    assert {line.removesuffix(" ...") for line in short[:-2]} <= set(whole)
    assert "it rests on present(t1) " in whole[-1]


def test_what_fits_a_screen_is_told_whole():
    account = explain(Text("0.5::a. b :- a."), "b")
    assert account_text(account, whole="more") == account_text(account)
