"""What each occlusion relation predicts of ev, and when that is a reason to doubt (§3.8)."""

import pytest
from situations import feature, hypothesis, situation, towers

from geometry.visibility.roc import ROC20
from plogic.facts.situation import PairFact, pair_facts
from plogic.scene.worlds.predictions import Doubt, doubts, said, weighed

MODES = ("to_B", "drop", "reassign")


def pair(relation, front, back, mode="to_B", **changes):
    """Two hypotheses h1 and h2 with these features, h1 standing to h2 in the relation."""
    h1 = hypothesis("h1", front, opaque=changes.pop("opaque", True))
    return situation(
        [h1, hypothesis("h2", back)], mode=mode, relations=tuple(pair_facts(relation, "h1", "h2")), **changes
    )


SEEN = [feature("a", match="a1"), feature("b", match="a2"), feature("c", "C")]
MISSED_BEHIND = [feature("d", match="a3"), feature("e", "C", hidden_by=("h1",))]
FOUND_BEHIND = [feature("d", match="a3"), feature("e", match="a4", hidden_by=("h1",))]
ALL_BEHIND = [feature("d", "C", hidden_by=("h1",)), feature("e", "C", hidden_by=("h1",))]


@pytest.mark.parametrize("mode", MODES)
@pytest.mark.parametrize(
    ("relation", "back"),
    [
        ("non_occludes_dc", SEEN),
        ("non_occludes_ec", SEEN),
        ("partially_occludes_po", MISSED_BEHIND),
        ("partially_occludes_ntpp", SEEN),
        ("totally_occludes_ntppi", ALL_BEHIND),
        ("totally_occludes_eq", [feature("d", "B")]),
        ("mutually_occludes_tpp", MISSED_BEHIND),
    ],
)
def test_where_the_prediction_holds_there_is_no_doubt(mode, relation, back):
    back = [feature(f.id + "_", "AC"[f.match is None], hidden_by=f.hidden_by, in_lobe=f.in_lobe) for f in back]
    assert doubts(pair(relation, SEEN, back, mode)) == ()


@pytest.mark.parametrize("relation", ["non_occludes_dc", "partially_occluded_by_po", "totally_occluded_by_ntpp"])
def test_who_is_behind_nobody_keeps_its_ev(relation):
    """h2 is hidden by h1, which by the outlines is not in front of it anywhere."""
    front = [feature("a", "C", hidden_by=("h2",))] if relation.startswith("totally") else SEEN
    (doubt,) = doubts(pair(relation, front, MISSED_BEHIND))
    assert doubt.expected == "ev(h2 given h1) = ev(h2) = +0.000"
    assert doubt.found == "+1.000"
    assert "line of sight to e" in doubt.why


def test_a_totally_hidden_object_has_no_evidence():
    (doubt,) = doubts(pair("totally_occludes_tppi", SEEN, FOUND_BEHIND))
    assert (doubt.relation, doubt.args) == ("totally_occludes", ("h1", "h2"))
    assert doubt.found == "1 expected, 2 detected"
    assert "d, e of h2" in doubt.why
    assert "totally_occludes(h1, h2)" in said(doubt)


def test_a_hidden_feature_that_is_detected_lifts_the_prediction_of_a_partial_occluder():
    assert doubts(pair("partially_occludes_po", SEEN, FOUND_BEHIND)) == ()


def test_nothing_is_predicted_of_rivals_and_nothing_of_what_is_behind_glass():
    assert doubts(pair("totally_occludes_eq", SEEN, FOUND_BEHIND, rivals=frozenset({("h2", "h1")}))) == ()
    assert doubts(pair("totally_occludes_eq", SEEN, FOUND_BEHIND, opaque=False)) == ()


@pytest.mark.parametrize("relation", ROC20)
def test_every_relation_can_be_checked_and_says_the_same_from_both_sides(relation):
    one = pair(relation, SEEN, MISSED_BEHIND)
    assert {d.args for d in doubts(one)} <= {("h1", "h2"), ("h2", "h1")}
    assert all(set(d.document()) == {"relation", "args", "expected", "found", "why"} for d in doubts(one))
    renamed = situation(
        [hypothesis("h1", [feature("d", match="a3"), feature("e", "C", hidden_by=("h2",))]), hypothesis("h2", SEEN)],
        relations=tuple(pair_facts(relation, "h2", "h1")),
    )
    swapped = {"h1": "h2", "h2": "h1"}
    assert {(d.relation, swapped[d.args[0]], swapped[d.args[1]]) for d in doubts(renamed)} == {
        (d.relation, *d.args) for d in doubts(one)
    }


def test_the_papers_example_gives_no_reason_to_doubt():
    assert towers().relations
    assert doubts(towers()) == ()


def test_a_coarse_relation_of_an_older_document_is_checked_too():
    old = situation(
        [hypothesis("h1", SEEN), hypothesis("h2", FOUND_BEHIND)], relations=(PairFact("totally_occludes", "h1", "h2"),)
    )
    assert len(doubts(old)) == 1


def test_a_doubt_says_what_evidence_gives_its_relation():
    doubt = Doubt("totally_occludes", ("h1", "h2"), "none", "2 detected", "they should be hidden")
    row = {**doubt.document(), "evidence": 0.031}
    assert Doubt.of(row).document() == row
    (told,) = weighed([doubt], {"doubts": [row]})
    assert said(told) == f"{said(doubt)}; what is detected of both gives it 0.031"
    assert weighed([doubt], {}) == [doubt]
