"""Every command does what the contract says, on the demo's output."""

from __future__ import annotations

import json
import math
import os
import re
import subprocess

import cv2
import pytest
from console import BIN, bytes_in, document, good, plogic

PROGRAM = "0.3::rain. 0.5::sprinkler(front). 0.2::sprinkler(back).\nwet :- rain. wet :- sprinkler(X).\nquery(wet). query(sprinkler(X)).\n"


@pytest.fixture(scope="module")
def perceived(demo, tmp_path_factory):
    """``perceive`` of the demo's image with everything that it can write, run elsewhere than in the demo's folder."""
    folder = tmp_path_factory.mktemp("perceived")
    options = ("-o", "out.json", "--report", "page.html", "--picture", "picture.png", "--timings", "timings.json")
    run = plogic(
        "perceive", demo / "image.png", "--camera", demo / "camera.json", "--kb", "towers", *options, cwd=folder
    )
    assert run.returncode == 0, run.stderr
    return run, folder


@pytest.fixture
def interpretation(demo):
    return demo / "interpretation.json"


@pytest.fixture
def program_file(tmp_path):
    (tmp_path / "rain.pl").write_text(PROGRAM)
    return tmp_path / "rain.pl"


def test_perceive_of_the_image_is_the_demos_interpretation(perceived, demo):
    """Only the files asked for are written, and they are the demo's, byte by byte."""
    run, folder = perceived
    files = bytes_in(folder)
    assert set(files) == {"out.json", "page.html", "picture.png", "timings.json"}
    assert files["out.json"] == (demo / "interpretation.json").read_bytes()
    assert files["page.html"] == (demo / "page.html").read_bytes()
    assert files["picture.png"] == (demo / "picture.png").read_bytes()
    assert run.stdout == ""
    assert len(run.stderr.splitlines()) == 1 + 2


PLACED = re.compile(r"(h\d+) (\S+) \((\d\.\d{3})\) at \((\S+), (\S+), (\S+)\) m, (\S+) m away")


def test_perceive_tells_where_each_object_stands_in_a_short_line(perceived):
    """The pose of the document, to centimetres, in the camera's frame."""
    run, folder = perceived
    counted, *lines = run.stderr.splitlines()
    assert "; 2 objects; " in counted
    accepted = [h for h in json.loads((folder / "out.json").read_text())["hypotheses"] if h["status"] == "accepted"]
    assert len(accepted) == len(lines) == 2
    for line, h in zip(lines, accepted, strict=True):
        name, kind, probability, *numbers = PLACED.fullmatch(line).groups()
        origin = [row[3] for row in h["T_camera_object"][:3]]
        assert (name, kind, probability) == (h["id"], h["type"], f"{h['probability']:.3f}")
        assert [float(number) for number in numbers] == pytest.approx([*origin, math.hypot(*origin)], abs=0.005)
        assert len(line) <= 72, line


def test_timings_are_a_document_of_their_own(perceived):
    timings = json.loads((perceived[1] / "timings.json").read_text())
    assert timings["format"] == "timings/1"
    assert {"read", "detect", "search", "worlds"} <= set(timings["seconds"])
    assert timings["total"] == pytest.approx(sum(timings["seconds"].values()))


def test_perceive_of_the_gamma_is_the_same_but_for_the_image(demo):
    ours = json.loads(good("perceive", demo / "gamma.json", "--kb", "towers"))
    theirs = json.loads((demo / "interpretation.json").read_text())
    assert "image" in theirs["assets"]
    assert "image" not in ours["assets"]
    differing = [key for key in theirs if key != "assets" and ours[key] != theirs[key]]
    assert differing == []


def test_perceive_pipes_into_worlds(demo, gamma):
    """``plogic perceive - --kb towers < gamma.json | plogic worlds -``, in a shell."""
    script = f'"{BIN}/plogic" perceive - --kb towers < gamma.json | "{BIN}/plogic" worlds - --json'
    run = subprocess.run(["sh", "-c", script], cwd=demo, capture_output=True, text=True, check=True, timeout=120)
    assert json.loads(run.stdout) == document("worlds", demo / "interpretation.json", "--json")
    assert len(run.stderr.splitlines()) == 1 + 2


@pytest.mark.parametrize(
    "command", [("worlds", "-"), ("query", "-"), ("program", "-"), ("explain", "-", "present(h1)")], ids=" ".join
)
def test_a_dash_is_stdin(command, interpretation):
    from_file = good(*(interpretation if word == "-" else word for word in command))
    assert good(*command, stdin=interpretation.read_text()) == from_file


@pytest.mark.parametrize("command", [("worlds", "-"), ("query", "-", "wet"), ("explain", "-", "wet")], ids=" ".join)
def test_a_program_comes_over_stdin_too(command, program_file):
    from_file = good(*(program_file if word == "-" else word for word in command))
    assert good(*command, stdin=program_file.read_text()) == from_file
    assert "<stdin>:1:6: " in plogic(*command, stdin="0.5::Rain.\n").stderr


def test_report_is_the_demos_page_to_a_file_or_stdout(demo, interpretation, tmp_path):
    run = plogic("report", interpretation, "-o", "page.html", cwd=tmp_path)
    assert (run.returncode, run.stdout, run.stderr) == (0, "", "wrote page.html\n")
    page = (demo / "page.html").read_bytes()
    assert (tmp_path / "page.html").read_bytes() == page
    assert good("report", interpretation, "-o", "-").encode().rstrip() == page.rstrip()


def test_report_writes_over_an_older_page_and_leaves_nothing_else(interpretation, tmp_path):
    (tmp_path / "page.html").write_text("old")
    good("report", interpretation, "-o", tmp_path / "page.html")
    assert list(bytes_in(tmp_path)) == ["page.html"]
    assert (tmp_path / "page.html").read_text() != "old"


@pytest.mark.parametrize(("reconsider", "reading"), [("drop", "score"), ("reassign", "posterior")])
def test_perceive_takes_the_reading_and_the_mode(demo, reconsider, reading):
    found = json.loads(
        good("perceive", demo / "gamma.json", "--kb", "towers", "--reconsider", reconsider, "--reading", reading)
    )
    assert (found["reconsider"], found["reading"]) == (reconsider, reading)


def test_worlds_are_ranked_and_the_rest_is_stated(interpretation):
    everything = document("worlds", interpretation, "-n", 1000, "--json")
    assert everything["format"] == "worlds/1"
    assert everything["worlds"] == json.loads(interpretation.read_text())["worlds"]
    one = document("worlds", interpretation, "-n", 1, "--json")
    assert one["worlds"] == everything["worlds"][:1]
    rest = 1 - one["worlds"][0]["probability"]
    assert one["unlisted_mass"] == pytest.approx([rest, rest])
    assert "not listed" in good("worlds", interpretation, "-n", 1)


def test_worlds_in_the_other_reading_are_that_interpretations_own(demo):
    told = document("worlds", demo / "interpretation.json", "--reading", "posterior", "--json")
    own = document("worlds", demo / "posterior-interpretation.json", "--json")
    assert told["reading"] == own["reading"] == "posterior"
    assert [w["present"] for w in told["worlds"]] == [w["present"] for w in own["worlds"]]
    assert [w["probability"] for w in told["worlds"]] == pytest.approx(
        [w["probability"] for w in own["worlds"]], abs=1e-9
    )


def answers(*args):
    found = document("query", *args, "--json")
    assert found["format"] == "answers/1"
    return [(a["goal"], a["probability"]) for a in found["answers"]]


def test_query_without_a_goal_asks_what_is_present(interpretation):
    found = answers(interpretation)
    assert found == answers(interpretation, "present(H)")
    marginals = {
        f"present({h['id']})": h["probability"]
        for h in json.loads(interpretation.read_text())["hypotheses"]
        if h["status"] == "accepted"
    }
    assert dict(found) == pytest.approx(marginals, abs=1e-9)
    assert [p for _, p in found] == sorted((p for _, p in found), reverse=True)


def test_query_with_labels_and_conjunctions(interpretation):
    causes = json.loads(interpretation.read_text())["worlds"][0]["causes"]
    appearance, cause = next((a, c) for a, c in causes.items() if c.startswith("h1/"))
    feature = cause.removeprefix("h1/")
    ((goal, p),) = answers(interpretation, f"cause({appearance}, H, F)")
    assert goal == f"cause({appearance}, h1, '{feature}')"
    assert dict(answers(interpretation))["present(h1)"] == pytest.approx(p, abs=1e-9)
    ((_, both),) = answers(interpretation, "present(h1), present(h2)")
    top = document("worlds", interpretation, "--json")["worlds"][0]
    assert both == pytest.approx(top["probability"], abs=1e-9)
    ((_, neither),) = answers(interpretation, f"noise({appearance}), present(h1)")
    assert neither == 0.0


def test_query_given_evidence_is_the_quotient(interpretation):
    ((_, both),) = answers(interpretation, "present(h1), present(h2)")
    one = dict(answers(interpretation))["present(h2)"]
    ((_, given),) = answers(interpretation, "present(h1)", "--given", "present(h2)")
    assert given == pytest.approx(both / one, abs=1e-9)


def test_query_with_rules_of_ones_own(interpretation, tmp_path):
    rules = tmp_path / "mine.pl"
    rules.write_text("% two towers make a town\ntown :- object(X, t1), object(Y, t2), present(X), present(Y).\n")
    ((goal, p),) = answers(interpretation, "town", "--rules", rules)
    ((_, both),) = answers(interpretation, "present(h1), present(h2)")
    assert (goal, p) == ("town", pytest.approx(both, abs=1e-9))
    assert (
        document("query", interpretation, "town", "--rules", "-", "--json", stdin=rules.read_text())["answers"][0][
            "probability"
        ]
        == p
    )


def test_query_of_a_program(program_file):
    assert dict(answers(program_file)) == pytest.approx({"wet": 0.72, "sprinkler(front)": 0.5, "sprinkler(back)": 0.2})
    assert answers(program_file)[0][0] == "wet"
    assert dict(answers(program_file, "rain", "--given", "\\+ sprinkler(front)", "--given", "wet")) == pytest.approx(
        {"rain": 0.3 / 0.44}
    )
    assert answers(program_file, "sprinkler(cellar)") == [("sprinkler(cellar)", 0.0)]


def test_query_as_text_lists_the_same_answers(program_file):
    rows = [line.split() for line in good("query", program_file).splitlines()]
    assert [row for row in rows if row and row[0][0] in "01"] == [
        ["0.720", "wet"],
        ["0.500", "sprinkler(front)"],
        ["0.200", "sprinkler(back)"],
    ]


def test_explain_of_an_interpretation_goes_down_to_the_data(interpretation):
    found = document("explain", interpretation, "present(h2)", "-n", 1, "--json")
    assert found["format"] == "explanation/1"
    assert found["probability"] == pytest.approx(dict(answers(interpretation))["present(h2)"], abs=1e-9)
    assert found["why"]
    causes = json.loads(interpretation.read_text())["worlds"][0]["causes"]
    named = [a for a in causes if f", {a})" in json.dumps(found["why"])]
    assert named
    assert all(causes[a].startswith("h2/") for a in named)
    text = good("explain", interpretation, "present(h2)", "-n", 1)
    assert text.startswith(f"P(present(h2)) = {found['probability']:.6g}\n")
    assert "why 1: " in text
    assert "why 2: " not in text


def test_explain_of_a_program_and_of_what_cannot_hold(program_file):
    found = document("explain", program_file, "wet", "--json")
    assert found["probability"] == pytest.approx(0.72)
    assert [e["probability"] for e in found["why"]] == pytest.approx([0.5, 0.3, 0.2])
    assert "it cannot hold" in good("explain", program_file, "sprinkler(cellar)")


def test_program_is_text_or_a_document(interpretation):
    text = good("program", interpretation)
    assert text.endswith("query(present(h1)).\nquery(present(h2)).\n")
    assert document("program", interpretation, "--json") == {"format": "program/1", "reading": "score", "program": text}


def test_kb_commands_with_and_without_json(demo):
    documents = {
        "kb_check/1": document("kb", "check", "towers", "--json"),
        "kb_show/1": document("kb", "show", "towers", "--json"),
        "kb_measures/1": document("kb", "measures", "towers", "--gamma", demo / "gamma.json", "--json"),
    }
    assert [d["format"] for d in documents.values()] == list(documents)
    counts = {row["type"]: row["instances"] for row in documents["kb_measures/1"]["features"]}
    assert counts == {"apex": 1, "corner": 16, "patch": 95}
    assert {row["type"] for row in documents["kb_measures/1"]["ranks"]} == {"t1", "t2"}
    texts = [
        good("kb", "check", "towers"),
        good("kb", "show", "towers"),
        good("kb", "measures", "towers", "--gamma", demo / "gamma.json"),
    ]
    assert "no mistakes" in texts[0]
    assert "feature apex" in texts[1]
    assert {"rank", "excess", "within_cell"} <= set(texts[2].split())


@pytest.mark.parametrize("which", ["kb", "object"])
def test_kb_schema_is_a_json_schema(which):
    schema = document("kb", "schema", which)
    assert "$schema" in schema or "properties" in schema
    assert schema["type"] == "object"


def test_simulate_twice_gives_the_same_bytes_and_another_seed_does_not(tmp_path):
    for name, seed in (("one", 5), ("second", 5), ("three", 6)):
        scene = "--kb", "towers", "--objects", 2, "--decoys", 1, "--seed", seed
        order = {"PYTHONHASHSEED": "38"} if name == "second" else {}
        run = plogic("simulate", *scene, "-o", name, cwd=tmp_path, **order)
        assert (run.returncode, run.stdout) == (0, "")
        assert run.stderr == (
            f"t1, t2 there; next: plogic perceive {name}/image.png --camera {name}/camera.json --kb towers -o out.json\n"
            f"wrote {name}\n"
        )
    one, two, three = (bytes_in(tmp_path / name) for name in ("one", "second", "three"))
    assert one == two
    assert set(one) == {"image.png", "camera.json", "truth.json"}
    assert all(one[name] != three[name] for name in one)
    labels = [o["label"] for o in json.loads(one["truth.json"])["objects"]]
    assert sorted(labels, key=str) == [None, "t1", "t2"]
    assert cv2.imread(str(tmp_path / "one/image.png")).shape == (480, 640, 3)


def test_simulate_of_nothing_is_a_scene(tmp_path):
    good("simulate", "--kb", "towers", "--objects", 0, "-o", tmp_path / "scene")
    assert json.loads((tmp_path / "scene/truth.json").read_text())["objects"] == []


def test_the_deadline_exits_with_3_and_marks_its_best_answer(demo, tmp_path):
    command = ("perceive", demo / "gamma.json", "--kb", "towers", "--deadline", "0.000001")
    run = plogic(*command)
    assert run.returncode == 3
    found = json.loads(run.stdout)
    assert found["unfinished"] is True
    assert any(step["event"] == "deadline" for step in found["trace"])
    assert plogic(*command, "-o", tmp_path / "out.json").returncode == 3
    assert json.loads((tmp_path / "out.json").read_text())["format"] == "interpretation/1"
    assert good("worlds", tmp_path / "out.json")


def test_a_deadline_that_is_not_reached_changes_nothing(demo):
    interpretation = json.loads(good("perceive", demo / "gamma.json", "--kb", "towers", "--deadline", 600))
    assert "unfinished" not in interpretation
    assert interpretation["worlds"] == json.loads((demo / "interpretation.json").read_text())["worlds"]


def test_a_reader_that_leaves_early_sees_no_traceback(interpretation):
    script = f'"{BIN}/plogic" program "{interpretation}" | head -n 1'
    run = subprocess.run(["sh", "-c", script], capture_output=True, text=True, check=True, timeout=60)
    assert (len(run.stdout.splitlines()), run.stderr) == (1, "")


def test_an_error_of_ours_is_one_line_too(tmp_path):
    """No traceback reaches a user, whatever is broken; PLOGIC_TRACEBACK=1 shows it."""
    broken = "import cli, plogic.face.authoring.kb_show\ndef no(*a, **k): raise ZeroDivisionError('by\\nzero')\n"
    broken += "plogic.face.authoring.kb_show.check_command = no\ncli.main()"
    command = [BIN / "python", "-c", broken, "kb", "check", "towers"]
    quiet = subprocess.run(command, capture_output=True, text=True, check=False, timeout=60)
    assert (quiet.returncode, quiet.stdout) == (1, "")
    assert quiet.stderr.startswith("plogic: internal error: ZeroDivisionError: by zero (")
    assert len(quiet.stderr.splitlines()) == 1
    loud = subprocess.run(
        command, capture_output=True, text=True, check=False, timeout=60, env=os.environ | {"PLOGIC_TRACEBACK": "1"}
    )
    assert "Traceback" in loud.stderr


def test_rules_of_ones_own_in_worlds_explanations_and_the_shell(interpretation, tmp_path):
    """As in ``query``; evidence may speak of them, and a mistake has its place in their file."""
    rules, wrong = tmp_path / "mine.pl", tmp_path / "wrong.pl"
    rules.write_text("town :- object(X, t1), object(Y, t2).\nhalf :- lucky, town.\n0.5::lucky.\n")
    wrong.write_text("town.\na :- b.\n")
    listed = document("worlds", interpretation, "--given", "town", "--rules", rules, "--json")["worlds"]
    assert [world["present"] for world in listed] == [["h1", "h2"]]
    assert good("worlds", interpretation, "--rules", rules) == good("worlds", interpretation)
    half = document("worlds", interpretation, "--given", "half", "--rules", rules, "--json")["worlds"]
    assert [world["present"] for world in half] == [["h1", "h2"]]
    told = document("explain", interpretation, "half", "-n", 1, "--rules", rules, "--json")
    ((_, p),) = answers(interpretation, "town", "--rules", rules)
    assert told["probability"] == pytest.approx(p / 2)
    assert "lucky" in good("explain", interpretation, "half", "-n", 1, "--rules", rules)
    shell = plogic("shell", interpretation, "--rules", rules, stdin="ask half\nlisting town\n")
    assert shell.returncode == 0, shell.stderr
    assert "town :- " in shell.stdout
    for command in (("worlds",), ("explain", "town"), ("query", "town"), ("shell",)):
        run = plogic(command[0], interpretation, *command[1:], "--rules", wrong)
        assert (run.returncode, run.stdout) == (1, "")
        assert f"{wrong}:2:" in run.stderr
