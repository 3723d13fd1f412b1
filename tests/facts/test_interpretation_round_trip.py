"""``interpretation.json`` holds everything that decides a probability.

Written and read back, it is the same situation.
"""

import json
from collections import Counter
from dataclasses import replace

import numpy as np
import pytest
from synthetic import belief_at, cycle_of, data, one_before_the_other, perceiver, scene, towers

from geometry.files.documents import Document
from plogic.base.errors import InterpretationError
from plogic.cycle.delta import Options, delta_of
from plogic.face.commands.asking import worlds_command
from plogic.face.shown.options import Asking
from plogic.facts.interpretation import interpretation_in, read_interpretation, situation_of, text_of
from plogic.measures.explanatory import Cells, case_of, explanatory_value, reconsidered
from plogic.run.document import document_of, relation_probabilities
from plogic.scene.worlds.ranked_worlds import ranked_worlds


@pytest.fixture(scope="module")
def parts():
    """A scene with two towers and a rival: shot, cycle with the rival considered, trace."""
    rng = np.random.default_rng(7400)
    shot = scene(rng, one_before_the_other(rng))
    cycle = cycle_of(shot.gamma)
    return shot, replace(cycle, considered=(belief_at("t1", shot.poses["t2"], data(shot), "rival"),))


def written(parts, options):
    """The situation, its worlds, and the document as it comes back from text."""
    shot, cycle = parts
    delta = delta_of(cycle, data(shot), towers(), perceiver().dv, options)
    ranking = ranked_worlds(delta.situation, 100)
    document = document_of(towers(), shot.gamma, delta, cycle.rejected, cycle.trace.document(), ranking, None)
    return delta, ranking, json.loads(text_of(document))


ASKED = Asking()
ALL = [
    Options(reading=r, reconsider=m, smoothing=s)
    for r in ("score", "posterior")
    for m in ("to_B", "drop", "reassign")
    for s in (0.0, 0.01)
]


@pytest.mark.parametrize("options", ALL, ids=lambda o: f"{o.reading}-{o.reconsider}-{o.smoothing}")
def test_the_situation_comes_back_whole(parts, options):
    delta, ranking, document = written(parts, options)
    back = situation_of(document)
    assert back == delta.situation
    assert ranked_worlds(back, 100) == ranking


def test_the_document_lists_the_same_worlds(parts):
    _, ranking, document = written(parts, Options())
    assert [(w["probability"], tuple(w["present"]), w["causes"]) for w in document["worlds"]] == [
        (w.probability, w.present, w.causes) for w in ranking.worlds
    ]
    assert document["unlisted_mass"] == list(ranking.unlisted)
    assert {h["id"]: h["probability"] for h in document["hypotheses"] if h["status"] != "rejected"} == ranking.marginals


def test_the_rejected_are_told_and_decide_nothing(parts):
    delta, _, document = written(parts, Options())
    rejected = [h for h in document["hypotheses"] if h["status"] == "rejected"]
    assert rejected
    assert all(h["probability"] == 0.0 and h["why"] for h in rejected)
    without = {**document, "hypotheses": [h for h in document["hypotheses"] if h["status"] != "rejected"]}
    assert situation_of(without) == delta.situation


def test_cases_are_those_of_the_accepted_world(parts):
    """The four cases, told per feature: outside the image none; counted they are the cells beside Δi."""
    delta, _, document = written(parts, Options())
    assert len(document["hypotheses"]) >= len(delta.beliefs) > 0
    for h in document["hypotheses"][: len(delta.beliefs)]:
        assert h["features"]
        for f in h["features"]:
            letter = {(True, True): "A", (True, False): "C", (False, False): "B", (False, True): "D"}[
                f["expected"], f["detected"]
            ]
            assert f["case"] == (letter if f["in_image"] else None)


@pytest.mark.parametrize("mode", ["to_B", "drop", "reassign"])
def test_the_ev_beside_the_others_is_that_of_the_mode(parts, mode):
    """§5.5 by its own tables of cells.

    What an accepted one hides is dropped, or moves to B, with data that an accepted one claims.
    """
    _, _, document = written(parts, Options(reconsider=mode))
    believed = [h for h in document["hypotheses"] if h["status"] == "accepted"]
    dv, hidden = document["measures"]["dv"], 0
    for h in believed:
        taken = {f["match"] for other in believed if other is not h for f in other["features"] if f["expected"]}
        alone, explained, displaced = {}, {}, {}
        for f in (f for f in h["features"] if f["in_image"]):
            awaited, found = f["in_lobe"] and not f["self_hidden"], f["match"] is not None
            behind = any(other["id"] in f["hidden_by"] for other in believed)
            case = case_of(expected=awaited and not (behind and mode == "reassign"), detected=found)
            alone.setdefault(f["type"], []).append(case)
            explained.setdefault(f["type"], []).append(case == "C" and behind)
            displaced.setdefault(f["type"], []).append(case == "D" and f["match"] in taken)
        cells = {kind: Cells(**Counter(cases)) for kind, cases in alone.items()}
        gone, moved = ({kind: sum(flags) for kind, flags in some.items()} for some in (explained, displaced))
        hidden += sum(gone.values())
        assert h["ev_reconsidered"] == pytest.approx(
            explanatory_value(reconsidered(cells, gone, mode, moved), dv), abs=1e-9
        )
    assert hidden or mode == "reassign"


def test_relations_have_the_mass_of_the_worlds_that_hold_both(parts):
    delta, ranking, document = written(parts, Options())
    assert document["relations"] == relation_probabilities(delta.situation)
    assert document["relations"]
    for row in document["relations"]:
        mass = sum(w.probability for w in ranking.worlds if set(row["args"]) <= set(w.present))
        assert row["probability"] == pytest.approx(mass)


def test_the_same_document_gives_the_same_bytes(parts):
    _, _, document = written(parts, Options())
    assert text_of(document) == text_of(json.loads(text_of(document)))


def test_a_file_is_read_back(parts, tmp_path):
    delta, _, document = written(parts, Options())
    path = tmp_path / "interpretation.json"
    path.write_text(text_of(document), encoding="utf-8")
    assert situation_of(read_interpretation(path)) == delta.situation


def test_how_types_are_seen_is_read_back_as_they_are_described(parts):
    delta, _, document = written(parts, Options())
    assert situation_of(document).types.keys() == {"t1", "t2"}
    for name, fact in situation_of(document).types.items():
        kind = next(b.object_type for b in delta.beliefs.values() if b.type == name)
        assert dict(fact.features) == {f.name: f.type for f in kind.seen_features if f.appearances}
        assert len(fact.looks) == sum(len(f.appearances) for f in kind.seen_features)
        assert fact.facets == kind.facets
        assert fact.faces == kind.faces
        assert len(fact.facets) > len(fact.faces) > 5


def test_an_empty_gamma_round_trips():
    shot = scene(np.random.default_rng(1), {}, clutter=0)
    document = perceiver()(shot.gamma)
    back = situation_of(json.loads(text_of(document)))
    assert back.hypotheses == ()
    assert ranked_worlds(back).worlds[0].probability == 1.0


@pytest.mark.parametrize("key", ["facts", "hypotheses", "appearances", "measures", "reading", "rules", "priors"])
def test_what_is_missing_is_one_clear_line(parts, key):
    _, _, document = written(parts, Options())
    del document[key]
    with pytest.raises(InterpretationError) as caught:
        interpretation_in(Document("file.json", document))
    assert str(caught.value).startswith(f"file.json: {key}: is missing: should be ")
    assert "\n" not in str(caught.value)


def test_facts_between_parts_are_told_and_come_back(parts):
    delta, _, document = written(parts, Options())
    facts = [f for f in document["facts"] if f["fact"] == "part_relation"]
    assert {tuple(f["parts"]) for f in facts} >= {("roof", ""), ("body", "roof")}
    assert len(facts) == len(delta.situation.part_relations)
    assert all(f["roc"].startswith(f["relation"]) for f in facts)


def test_documents_of_before_the_twenty_relations_are_read(parts):
    _, ranking, document = written(parts, Options())
    old = [{k: v for k, v in f.items() if k != "roc"} for f in document["facts"] if f["fact"] != "part_relation"]
    back = situation_of(document | {"facts": old})
    assert back.relations
    assert {r.roc for r in back.relations} == {""}
    assert ranked_worlds(back, 100) == ranking


def test_doubts_are_told_and_printed(parts, tmp_path):
    """Of the scene as it is there are none; where the outlines are said to cover what is seen, there is one."""
    _, _, document = written(parts, Options())
    assert document["doubts"] == []
    path = tmp_path / "interpretation.json"
    path.write_text(text_of(document))
    assert "reason to doubt" not in worlds_command(str(path), 3, (), ASKED, as_json=False)[0]
    covered = [
        f | {"relation": "totally_occludes", "roc": "totally_occludes_eq"} if f["fact"] == "relation" else f
        for f in document["facts"]
    ]
    path.write_text(text_of(document | {"facts": covered}))
    assert (
        "a reason to doubt totally_occludes(h1, h2): expected no feature of h2"
        in worlds_command(str(path), 3, (), ASKED, as_json=False)[0]
    )
