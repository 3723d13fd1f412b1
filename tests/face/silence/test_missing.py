"""``plogic explain --missing TYPE``: the cause, the data, the best pose, and what it lacked."""

from __future__ import annotations

import json

import pytest
from in_process import told
from spoiled_box import TYPE, gamma_file, sight, texts, written

from kb.files.folder import shipped


@pytest.fixture
def far(tmp_path):
    """A knowledge base whose ranges end too soon, and the empty interpretation that it gives."""
    files = texts()
    folder = written(tmp_path / "kb", files | {TYPE: files[TYPE].replace("5 m]", "1 m]")})
    told("perceive", gamma_file(tmp_path, sight()), "--kb", folder, "-o", tmp_path / "out.json")
    return folder, tmp_path / "out.json"


def test_with_the_knowledge_base_the_cause_comes_first_and_the_data_are_counted(far):
    folder, out = far
    first, data, attention, poses, *_ = told("explain", out, "--missing", "box", "--kb", folder)
    assert "7 of 7 corners are farther than their range: 1.5 m, range 1 m" in first
    assert data == "data: 13 of 13 appearances look like features of it: 10 corner, 3 sticker"
    assert attention.startswith("attention: rank ")
    assert poses.startswith("poses: ")


def test_without_it_what_the_interpretation_holds(far):
    _, out = far
    data, *_ = told("explain", out, "--missing", "box")
    assert data == "data: 13 appearances; which of them look like box, and the cause, is told with --kb KB"


def test_the_best_pose_and_what_it_lacked(tmp_path):
    """Corners alone of a box, half of them: the pose is tried, and too little of it is there."""
    document = sight(noise=0)
    corners = [row for row in document["appearances"] if row["type"] == "corner"]
    document["appearances"] = [*corners[:4], *(row for row in document["appearances"] if row["type"] == "sticker")][:5]
    out = tmp_path / "out.json"
    told("perceive", gamma_file(tmp_path, document), "--kb", "first", "-o", out)
    (answer,) = told("explain", out, "--missing", "box", "--kb", "first", "--json")
    found = json.loads(answer)
    assert (found["format"], found["in_delta"]) == ("missing/1", [])
    assert found["best"]["detected"] < found["best"]["expected"]
    assert len(found["best"]["missed"]) >= found["best"]["expected"] - found["best"]["detected"]
    text = "\n".join(told("explain", out, "--missing", "box", "--kb", "first"))
    assert "  missed: " in text
    assert f"  why not: {found['best']['why']}" in text


def test_what_was_found_is_said_to_be_there(tmp_path):
    out = tmp_path / "out.json"
    told("perceive", gamma_file(tmp_path, sight()), "--kb", "first", "-o", out)
    first = told("explain", out, "--missing", "box", "--kb", "first")[0]
    assert first.startswith("h1 is a box: accepted, probability ")
    (poses,) = [
        line for line in told("explain", out, "--missing", "box", "--kb", "first") if line.startswith("poses: ")
    ]
    assert poses.startswith("poses: h1 stands there; of others, ")


def test_of_a_rival_no_cause_is_told_that_contradicts_it(tmp_path):
    """A rival was posed, judged and kept: it is not said that no pose was found."""
    out = tmp_path / "out.json"
    told("perceive", gamma_file(tmp_path, sight()), "--kb", "first", "-o", out)
    document = json.loads(out.read_text())
    document["hypotheses"] = [{**h, "status": "rival"} for h in document["hypotheses"] if h["status"] == "accepted"]
    out.write_text(json.dumps(document))
    lines = told("explain", out, "--missing", "box", "--kb", "first")
    assert lines[0].startswith("h1 is a box: rival, probability ")
    assert not [line for line in lines if line.startswith("box: ")], "no cause"
    assert [line for line in lines if line.startswith("poses: h1 is held in other worlds; of others, ")]


def test_what_others_claim_is_told_beside_what_is_missed(tmp_path):
    """Of the best rejected pose 31 features are expected and none detected, but only 17 have no datum."""
    out = tmp_path / "out.json"
    told("perceive", shipped("paper") / "figure_5/gamma.json", "--kb", "paper", "-o", out)
    (answer,) = told("explain", out, "--missing", "t2", "--kb", "paper", "--json")
    best = json.loads(answer)["best"]
    claimed = best["expected"] - best["detected"] - len(best["missed"])
    assert claimed > 0
    text = told("explain", out, "--missing", "t2", "--kb", "paper")
    assert f"  {claimed} more have data near them that fit others, or that accepted objects claim" in text


def test_under_changed_rules_it_is_told_all_the_same_and_not_with_another_type(far):
    folder, out = far
    before = told("explain", out, "--missing", "box", "--kb", folder)
    (folder / "rules.pl").write_text("solitary(X) :- present(X).\n")
    assert told("explain", out, "--missing", "box", "--kb", folder) == before
    (folder / TYPE).write_text(texts()[TYPE])
    (line,) = told("explain", out, "--missing", "box", "--kb", folder)
    assert f"files of {folder} beside rules.pl have changed since" in line


def test_rules_that_were_there_before_and_are_gone_change_nothing(tmp_path):
    folder, out = (
        written(tmp_path / "kb", texts() | {"rules.pl": "solitary(X) :- present(X).\n"}),
        tmp_path / "out.json",
    )
    told("perceive", gamma_file(tmp_path, sight()), "--kb", folder, "-o", out)
    (folder / "rules.pl").unlink()
    assert told("explain", out, "--missing", "box", "--kb", folder)[0].startswith("h1 is a box: accepted")


def causes_of(folder, tmp_path, document):
    told("perceive", gamma_file(tmp_path, document), "--kb", folder, "-o", tmp_path / "out.json")
    return told("explain", tmp_path / "out.json", "--missing", "box", "--kb", folder)


def test_a_feature_that_is_never_seen_is_no_cause_where_the_others_suffice(tmp_path):
    files = texts()
    inside = files[TYPE].replace("at: [0.08, -0.1, 0.1]", "at: [0.08, -0.05, 0.1]")
    folder = written(tmp_path / "kb", files | {TYPE: inside})
    (warning,) = [line for line in told("kb", "check", folder) if line.startswith("warning: ")]
    assert "no viewpoint sees south_right" in warning
    document = sight(noise=0)
    corners = [row for row in document["appearances"] if row["type"] == "corner"]
    stickers = [row for row in document["appearances"] if row["type"] == "sticker"]
    document["appearances"] = [*corners[:4], *stickers[:1]]
    first, second, *_ = causes_of(folder, tmp_path, document)
    assert not first.startswith("box: no viewpoint sees")
    assert second.startswith("box: besides, no viewpoint sees south_right")


def test_that_a_type_shows_too_little_is_the_first_cause(tmp_path):
    files = texts()
    rows = files[TYPE].split("  - feature:")
    few = "  - feature:".join([row for row in rows if not row.startswith((" top", " base_n", " north", " east"))])
    folder = written(tmp_path / "kb", files | {TYPE: few})
    (warning,) = [line for line in told("kb", "check", folder) if line.startswith("warning: ")]
    assert "it would not be accepted even if all that it shows were detected" in warning
    assert f"warning: {causes_of(folder, tmp_path, sight(home=folder))[0]}" == warning


@pytest.mark.parametrize(
    ("arguments", "why"),
    [
        (["--missing", "bax"], "bax: no such type in {out}; it tells of: box"),
        (["--missing", "bax", "--kb", "{kb}"], "bax: no such object type; there are: box"),
        (["--missing", "box", "--kb", "first"], "{out}: files of "),
        ([], "give either a GOAL or --missing TYPE"),
        (["present(h1)", "--missing", "box"], "give either a GOAL or --missing TYPE"),
        (["present(h1)", "--kb", "first"], "--kb: only with --missing"),
        (["--missing", "box", "-n", "2"], "--missing takes --kb, --digits and --json alone"),
    ],
)
def test_what_cannot_be_asked_says_why(far, arguments, why):
    folder, out = far
    last = told("explain", out, *(text.format(kb=folder) for text in arguments))[-1]
    assert why.format(out=out) in last
