"""Observing, retracting, adding and removing.

Any detour restores every byte, and recomputes only the pieces that it touches.
"""

from __future__ import annotations

import json
from dataclasses import replace

import pytest
from drawn_programs import programs
from hypothesis import HealthCheck, assume, given, settings
from hypothesis import strategies as st
from situations import feature, hypothesis, random_situations, situation

from plogic.base.errors import InconsistentError
from plogic.face.session.session import Session
from plogic.logic.served.engine import Process, Text
from plogic.logic.served.program_child import serve
from plogic.scene.asking.live import LiveScene

QUICK = settings(max_examples=40, deadline=None, derandomize=True, suppress_health_check=list(HealthCheck))
EVIDENCE = ("present(h1)", "\\+ present(h2)", "noise(a0)", "\\+ noise(a1)", "case(H, F, a)", "present(h1) ; noise(a2)")


pytestmark = pytest.mark.usefixtures("served_here")


def everything(live):
    """All that a live scene says, to the last bit."""
    return repr((live.marginals(), live.worlds(1000), live.answers("noise(A)"), live.answers("present(H)")))


def live_or_none(subject):
    try:
        live = LiveScene(subject)
        live.marginals()
    except InconsistentError:
        assume(condition=False)
    return live


@QUICK
@given(
    random_situations(most=4),
    st.lists(st.sampled_from(EVIDENCE), min_size=1, max_size=4, unique=True),
    st.randoms(use_true_random=False),
)
def test_any_detour_comes_to_the_bytes_of_the_direct_way(subject, evidence, random):
    """Evidence comes and goes, in an order of its own.

    What is left says what it says alone in a scene that never saw the rest.
    """
    assume(len(subject.hypotheses) > 1)
    live, kept = live_or_none(subject), []
    for goal in evidence:
        try:
            live.observe(goal)
            kept.append(goal)
        except InconsistentError:
            assert everything(live) == everything(observed(subject, kept)), "what is refused leaves no trace"
    for goal in random.sample(kept, random.randrange(len(kept) + 1)):
        live.unobserve(goal)
        kept.remove(goal)
    assert live.given == tuple(kept)
    assert everything(live) == everything(observed(subject, kept))


def observed(subject, goals):
    """The direct way: a scene that never saw anything else."""
    fresh = LiveScene(subject)
    for goal in goals:
        fresh.observe(goal)
    return fresh


@QUICK
@given(random_situations(most=4))
def test_a_hypothesis_that_comes_and_goes_leaves_no_trace(subject):
    live = live_or_none(subject)
    before = everything(live)
    more = hypothesis(
        "h9", [feature("x", "A", match="a0"), feature("y", "C", hidden_by=("h1",))], type="t1", group="g1"
    )
    try:
        live.add(more, overlaps=frozenset({("h1", "h9")}), exclusive=frozenset({("h9", "h1")}))
    except InconsistentError:
        assert live.situation == subject
    else:
        assert "h9" in live.marginals()
        live.remove("h9")
    assert live.situation == subject
    assert everything(live) == before


@QUICK
@given(random_situations(most=4))
def test_all_removed_but_one_is_the_one_alone(subject):
    """Nothing speaks of what was removed any more: no pair, no relation, no occlusion."""
    live = live_or_none(subject)
    one, *rest = subject.hypotheses
    alone = replace(
        one, features=tuple(replace(f, hidden_by=tuple(g for g in f.hidden_by if g == one.id)) for f in one.features)
    )
    try:
        for h in rest:
            live.remove(h.id)
    except InconsistentError:
        return
    nobody = frozenset()
    lone = replace(subject, hypotheses=(alone,), overlaps=nobody, rivals=nobody, exclusive=nobody, relations=())
    assert live.situation == lone
    assert everything(live) == everything(LiveScene(lone))


@QUICK
@given(programs(), st.randoms(use_true_random=False))
def test_a_session_about_a_program_restores_every_byte(monkeypatch, drawn, random):
    assume(drawn.held())

    def shown(session):
        return [str(session.worlds(100)), str(session.predict()), str(session.ask()), session.observed]

    monkeypatch.setattr(Process, "ask", lambda _, request: serve(json.loads(json.dumps(request))))
    literals = [f"{random.choice(['', chr(92) + '+ '])}{atom}" for atom in drawn.queries]
    with Session(Text(drawn.text)) as session, Session(Text(drawn.text)) as other:
        before, taken = shown(session), []
        at = before
        for literal in literals:
            try:
                session.observe(literal)
                taken.append(literal)
            except InconsistentError:
                assert shown(session) == at
            else:
                at = shown(session)
        for literal in random.sample(taken, len(taken)):
            other.observe(literal)
        assert at[:3] == shown(other)[:3]
        for literal in random.sample(taken, len(taken)):
            session.unobserve(literal)
        assert shown(session) == before


def apart(count, reading="posterior"):
    """Pieces of two hypotheses over data of their own, no two pieces alike."""
    members = [
        hypothesis(
            f"p{i}h{j}",
            [
                feature(f"f{k}", "A", match=f"p{i}a{k}", density=0.01 * (i + j + k + 1), dv=0.1 * (i + 1 + j) / count)
                for k in range(2)
            ]
            + [feature("m", "C", dv=0.3, hidden_by=(f"p{i}h0",) if j else ())],
        )
        for i in range(count)
        for j in range(2)
    ]
    return situation(
        members, reading, smoothing=0.01, overlaps=frozenset((f"p{i}h0", f"p{i}h1") for i in range(0, count, 2))
    )


@pytest.mark.parametrize("reading", ["score", "posterior"])
@pytest.mark.parametrize(
    ("goal", "pieces"),
    [
        ("present(p2h0)", 1),
        ("\\+ present(p3h1)", 1),
        ("\\+ noise(p1a0)", 1),
        ("case(p1h0, F, a)", 1),
        ("present(p2h0), \\+ present(p5h1)", 2),
        ("present(p0h0) ; noise(p1a1)", 1),
    ],
)
def test_evidence_solves_only_the_piece_that_it_speaks_of(reading, goal, pieces):
    """What is said of each of two leaves them apart; a formula over two joins them to one."""
    live = LiveScene(apart(12, reading))
    live.marginals()
    start = live.solved
    assert start == 12
    live.observe(goal)
    live.marginals()
    live.worlds(5)
    assert live.solved == start + pieces
    live.unobserve(goal)
    live.marginals()
    live.observe(goal)
    live.marginals()
    assert live.solved == start + pieces, "what was solved once is remembered"


@pytest.mark.parametrize("reading", ["score", "posterior"])
def test_a_hypothesis_added_or_removed_solves_only_its_piece(reading):
    subject = apart(12, reading)
    live = LiveScene(subject)
    live.marginals()
    live.add(hypothesis("more", [feature("x", "A", match="p4a0", density=0.7), feature("y", "C", hidden_by=("p4h0",))]))
    assert live.solved == 13
    live.remove("more")
    live.marginals()
    assert live.solved == 13
    live.remove("p7h1")
    assert live.solved == 14
    assert live.marginals() == LiveScene(live.situation).marginals()
    alone = replace(
        subject, hypotheses=tuple(h for h in subject.hypotheses if h.id.startswith("p5")), overlaps=frozenset()
    )
    assert live.marginals()["p5h1"] == LiveScene(alone).marginals()["p5h1"], "what was not touched is what it is alone"
