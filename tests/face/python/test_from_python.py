"""The contract's section *From Python*, line by line."""

from __future__ import annotations

import subprocess
import sys
import time
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pandas as pd
import pytest
from console import document, good
from sent import sent

import plogic
from plogic import Camera, Gamma, Interpretation, KnowledgeBase, Program, Session, detect, perceive
from plogic.facts.interpretation import text_of

ALARM = Path(__file__).parents[3] / "examples" / "alarm.pl"


# -- knowledge bases -------------------------------------------------------------------------------------------------


def test_a_folder_and_a_shipped_name_load(first, tmp_path):
    good("kb", "new", tmp_path / "mykb")
    assert KnowledgeBase.load(tmp_path / "mykb").name
    assert first.name == "first"
    assert first.types == ("box",)
    assert set(first.appearance_types) == {"corner", "sticker"}
    assert KnowledgeBase.load("first") == first


def test_a_folder_with_mistakes_tells_them_with_their_places(tmp_path):
    (tmp_path / "kb.yaml").write_text("name: 3\nnonsense: 1\n")
    told = _command_says("perceive", ALARM, "--kb", tmp_path)
    with pytest.raises(plogic.Error) as error:
        KnowledgeBase.load(tmp_path)
    assert "kb.yaml:1" in str(error.value)
    assert str(error.value) == told


# -- Γ and perceive --------------------------------------------------------------------------------------------------


def test_a_path_of_a_gamma_gives_what_the_command_gives(first, gamma_file):
    assert text_of(perceive(gamma_file, first).document) == good("perceive", gamma_file, "--kb", "first")


def test_options_are_the_commands(first, gamma_file, tmp_path):
    whole = Gamma.load(gamma_file)
    fewer = Gamma(whole.camera, whole.appearances[:7]).save(tmp_path / "fewer.json")  # every set of four is tried
    options = {"reading": "posterior", "reconsider": "drop", "smoothing": 0.01, "generator": "quadruples"}
    typed = [word for name, value in options.items() for word in (f"--{name}", str(value))]
    mine = perceive(fewer, first, **options)
    assert text_of(mine.document) == good("perceive", fewer, "--kb", "first", *typed)
    assert mine.document["hypotheses"]


def test_a_gamma_and_its_file_give_the_same(first, gamma_file, scene, tmp_path):
    gamma = Gamma.load(gamma_file)
    assert perceive(gamma, first) == scene
    assert perceive(str(gamma_file), "first") == scene
    assert Gamma.load(gamma.save(tmp_path / "gamma.json")) == gamma
    assert [a.id for a in gamma] == [row["id"] for row in gamma.to_pandas().to_dict("records")]


def test_a_path_and_an_image_and_its_gamma_give_the_same(towers_picture):
    kb, file, place = KnowledgeBase.load("towers"), towers_picture / "image.png", towers_picture / "camera.json"
    camera, pixels = Camera.load(place), cv2.imread(str(file))
    by_path = perceive(file, kb, place)
    command = towers_picture / "interpretation.json"
    good("perceive", file, "--kb", "towers", "--camera", place, "-o", command)
    assert by_path == perceive(pixels, kb, camera) == Interpretation.load(command)
    gamma = detect(pixels, kb, camera)
    assert gamma == detect(file, "towers", place)
    assert len(gamma) == len(by_path.document["appearances"])
    assert perceive(gamma, kb).hypotheses == by_path.hypotheses
    assert by_path.image is not None
    assert by_path.picture().shape == Interpretation.load(command).picture().shape


@pytest.mark.parametrize(
    "wrong",
    [
        {"source": "nowhere.json"},
        {"source": "nowhere.png"},
        {"source": np.zeros((4, 4), np.uint8), "camera": Camera.from_fov(4, 4, horizontal=60)},
        {"source": np.zeros((4, 4, 3)), "camera": Camera.from_fov(4, 4, horizontal=60)},
        {"source": np.zeros((4, 4, 3), np.uint8)},
        {"source": np.zeros((4, 4, 3), np.uint8), "camera": Camera.from_fov(8, 4, horizontal=60)},
        {"source": 5},
        {"kb": "nothing"},
        {"reading": "other"},
        {"reconsider": "other"},
        {"smoothing": 0.5},
        {"generator": "other"},
        {"deadline": 0},
        {"deadline": float("nan")},
        {"deadline": "2"},
        {"smoothing": "a"},
        {"source": np.zeros((0, 0, 3), np.uint8), "camera": Camera.from_fov(4, 4, horizontal=60)},
    ],
    ids=str,
)
def test_bad_input_raises_and_says_nothing(wrong, gamma_file, first, capfd):
    with pytest.raises(plogic.Error) as error:
        perceive(**({"source": gamma_file, "kb": first} | wrong))
    assert len(str(error.value).splitlines()) == 1
    assert capfd.readouterr() == ("", "")


@pytest.mark.parametrize(
    "ask",
    [
        lambda scene: scene.worlds(-1),
        lambda scene: scene.worlds(2.5),
        lambda scene: scene.worlds("3"),
        lambda scene: scene.worlds(deadline=-5),
        lambda scene: scene.query(5),
        lambda scene: scene.query(given=["present(h1)", 5]),
        lambda scene: scene.query(deadline=float("nan")),
        lambda scene: scene.explain(None),
        lambda scene: scene.explain("present(h1)", n=0),
        lambda scene: scene.settle(-1),
        lambda _: Session(5),
    ],
)
def test_a_wrong_argument_of_a_question_is_told(scene, ask):
    with pytest.raises(plogic.Error) as error:
        ask(scene)
    assert len(str(error.value).splitlines()) == 1


@pytest.mark.parametrize("kind", [np.float64, np.float32, np.int64])
def test_numbers_of_numpy_are_numbers(first, gamma_file, tmp_path, kind):
    gamma = Gamma.load(gamma_file)
    plain = Gamma(gamma.camera, [replace(a, uv=tuple(map(float, map(kind, a.uv)))) for a in gamma.appearances])
    theirs = Gamma(gamma.camera, [replace(a, uv=tuple(map(kind, a.uv))) for a in gamma.appearances])
    assert perceive(theirs, first).document == perceive(plain, first).document
    theirs.save(tmp_path / "g.json")
    assert Gamma.load(tmp_path / "g.json") == plain
    assert len(perceive(theirs, first).worlds(np.int64(2), deadline=np.float32(60.0))) == 2


def test_a_gamma_with_mistakes_tells_them_all(first, gamma_file):
    gamma = Gamma.load(gamma_file)
    other = Gamma(gamma.camera, [*gamma.appearances, plogic.Appearance("a1", "wheel", (9999.0, 0.0), "mine")])
    with pytest.raises(plogic.Error) as error:
        perceive(other, first)
    assert [line.split(": ")[1] for line in str(error.value).splitlines()] == [
        f"appearances.13.{key}" for key in ("id", "type", "uv")
    ]


def test_a_deadline_marks_what_is_unfinished(first, gamma_file):
    late = perceive(gamma_file, first, deadline=1e-6)
    assert late.unfinished
    assert [h.interval for h in late.hypotheses] == [(0.0, 1.0)] * len(late.hypotheses)
    assert not perceive(gamma_file, first, deadline=600).unfinished


# -- hypotheses and worlds -------------------------------------------------------------------------------------------


def test_hypotheses_have_their_fields(scene):
    (box,) = (h for h in scene.hypotheses if h.status == "accepted")
    row = scene.document["hypotheses"][0]
    assert (box.id, box.type, box.ev, box.p_ev) == (row["id"], row["type"], row["ev"], row["p_ev"])
    assert box.probability == row["probability"]
    assert box.T_camera_object.shape == (4, 4)
    assert box.T_camera_object.tolist() == row["T_camera_object"]
    assert sorted(box.cases.values()).count("A") == 10


def test_worlds_are_the_commands(scene, tmp_path):
    file = scene.save(tmp_path / "interpretation.json")
    told = document("worlds", file, "-n", 1, "--json")
    worlds = scene.worlds(1)
    (world,) = worlds
    assert (world.probability, list(world.present), world.causes) == (
        told["worlds"][0]["probability"],
        told["worlds"][0]["present"],
        told["worlds"][0]["causes"],
    )
    assert list(worlds.unlisted) == told["unlisted_mass"]
    assert worlds.unlisted[0] == pytest.approx(1.0 - world.probability)
    assert sum(w.probability for w in scene.worlds(10)) == pytest.approx(1.0)
    assert scene.worlds(10, given="present(h1)")[0].probability == pytest.approx(1.0)
    assert scene.worlds(10, given=["\\+ present(h1)"])[0].present == ()
    assert scene.worlds(10, given="pick(h1, north)")[0].causes is None
    assert scene.worlds(10, deadline=60) == scene.worlds(10)


# -- questions -------------------------------------------------------------------------------------------------------


def test_a_query_has_every_answer_with_its_bindings(scene, tmp_path):
    told = document("query", scene.save(tmp_path / "i.json"), "cause(A, H, F)", "--given", "present(h1)", "--json")
    answers = scene.query("cause(A, H, F)", given="present(h1)")
    assert [(a.goal, a.probability, list(a.interval)) for a in answers] == [
        (row["goal"], row["probability"], row["interval"]) for row in told["answers"]
    ]
    assert len(answers) == 10
    assert [f"cause({a.bindings['A']}, {a.bindings['H']}, {a.bindings['F']})" for a in answers] == [
        a.goal for a in answers
    ]
    assert scene.query() == scene.query("present(H)")
    assert scene.query("present(H)", deadline=60).complete


def test_a_query_takes_rules_of_ones_own(scene, tmp_path):
    (tmp_path / "mine.pl").write_text("seen(T) :- object(_, T).\n")
    (answer,) = scene.query("seen(T)", rules=tmp_path / "mine.pl")
    assert answer.bindings == {"T": "box"}


def test_an_explanation_prints_as_the_command_does(scene, tmp_path):
    file = scene.save(tmp_path / "i.json")
    why = scene.explain("present(h1)")
    assert str(why) + "\n" == good("explain", file, "present(h1)")
    assert str(scene.explain("object(h1, T)", n=1)) + "\n" == good("explain", file, "object(h1, T)", "-n", 1)
    assert why.tree.goal == "present(h1)"
    assert why.tree.probability == pytest.approx(0.9375)
    assert [child.goal for child in why.tree.children] == ["present(h1)"] * 5
    assert why == scene.explain("present(h1)")
    assert sent(why) == why


def test_a_goal_that_cannot_be_read_tells_its_place(scene, tmp_path):
    file = scene.save(tmp_path / "i.json")
    with pytest.raises(plogic.Error) as error:
        scene.query("present(h1")
    assert str(error.value) == _command_says("query", file, "present(h1")
    assert str(error.value).startswith("goal:1:")


def test_a_program_is_asked_and_explained():
    program = Program.load(ALARM)
    told = document("query", ALARM, "calls(mary)", "--given", "burglary", "--json")
    (answer,) = program.query("calls(mary)", given="burglary")
    assert answer.probability == told["answers"][0]["probability"]
    assert str(program.explain("calls(mary)")) + "\n" == good("explain", ALARM, "calls(mary)")
    rows = document("worlds", ALARM, "--json")["worlds"]
    assert [(w.probability, list(w.present)) for w in program.worlds()] == [(r["probability"], r["true"]) for r in rows]
    assert Program(program.text) == program
    with pytest.raises(plogic.Error, match=r"mine\.pl:1:"):
        Program("a :- b(", "mine.pl").query("a")
    with pytest.raises(plogic.Error, match="cannot be read"):
        Program.load("nowhere.pl")


def test_a_session_observes_and_asks(scene, tmp_path):
    with Session(scene) as session:
        session.observe("present(h1)")
        (row,) = session.predict("object(X, T)")
        assert (row.bindings, row.probability) == ({"X": "h1", "T": "box"}, pytest.approx(1.0))
        assert row.before == pytest.approx(0.9375)
        assert session.ask("object(X, T)") == scene.query("object(X, T)")
        assert session.worlds(3)[0].present == ("h1",)
    with Session(Program.load(ALARM)) as session:
        assert session.ask("calls(mary)") == Program.load(ALARM).query("calls(mary)")
    with Session.open(scene.save(tmp_path / "i.json"), reading="posterior") as session:
        assert session.ask("present(H)") == scene.read_as("posterior").query("present(H)")
    with Session.open(ALARM) as session:
        assert session.ask("burglary")


# -- measures, program, picture, page, file --------------------------------------------------------------------------


def test_measures_stand_side_by_side(scene):
    (row,) = found = scene.measures()
    (box,) = (h for h in scene.hypotheses if h.status == "accepted")
    assert (row.id, row.type, row.status) == (box.id, box.type, box.status)
    assert row.ev == pytest.approx(box.ev)
    assert row.ev_to_B == pytest.approx(box.ev)
    assert row.ev_reassign == pytest.approx(box.ev)
    assert row.shanahan == 1.0
    assert row.posterior == scene.read_as("posterior").query("present(h1)")[0].probability
    dv = {feature.type: feature.over_types for feature in found.features}
    assert dv == {kind: scene.document["measures"]["dv"][kind] for kind in ("corner", "sticker")}
    assert dv == pytest.approx({feature.type: feature.over_instances for feature in found.features})
    assert row.rank == 1.0


def test_the_program_is_the_commands(scene, tmp_path):
    file = scene.save(tmp_path / "i.json")
    assert str(scene.program()) == good("program", file)
    (answer,) = (a for a in scene.program().query() if a.goal == "present(h1)")
    assert answer.probability == pytest.approx(0.9375)


def test_the_picture_is_the_commands(scene, gamma_file, tmp_path):
    good("perceive", gamma_file, "--kb", "first", "-o", tmp_path / "i.json", "--picture", tmp_path / "p.png")
    picture = scene.picture()
    assert picture.dtype == np.uint8
    assert picture.shape[2] == 3
    assert (np.asarray(picture) == cv2.imread(str(tmp_path / "p.png"))).all()
    assert picture._repr_png_() == (tmp_path / "p.png").read_bytes()


def test_the_page_and_the_file_are_the_commands(scene, tmp_path):
    file = scene.save(tmp_path / "i.json")
    good("report", file, "-o", tmp_path / "command.html")
    assert scene.report(tmp_path / "page.html").read_bytes() == (tmp_path / "command.html").read_bytes()
    assert Interpretation.load(file) == scene
    with pytest.raises(plogic.Error, match=r"first_gamma.json:1:12: format"):
        Interpretation.load(Path(ALARM).parent / "first_gamma.json")


# -- tables ----------------------------------------------------------------------------------------------------------


def tables(scene):
    with Session(scene) as session:
        session.observe("present(h1)")
        predicted = session.predict("object(X, T)")
    return [
        scene.hypotheses, scene.relations, scene.worlds(), scene.query("cause(A, H, F)"), scene.measures(), predicted,
        Program.load(ALARM).query(), Program.load(ALARM).worlds(),
    ]  # fmt: skip


def test_tables_are_sequences_equal_by_value_and_show_themselves(scene):
    one, two = tables(scene), tables(scene)
    assert one == two
    assert [len(table) == len(list(table)) == len(table.to_pandas()) for table in one] == [True] * len(one)
    assert [type(table).__name__ for table in one if "<table>" not in table._repr_html_()] == []
    assert [repr(table) for table in one] == [str(table) for table in one]


def test_a_frame_has_a_column_each_field_and_each_variable(scene):
    frame = scene.query("cause(A, H, F)").to_pandas()
    assert list(frame.columns) == ["goal", "A", "H", "F", "probability", "interval"]
    assert isinstance(frame, pd.DataFrame)
    assert list(scene.worlds().to_pandas().columns) == [
        "probability",
        "present",
        "causes",
        "interval",
        "choices",
        "support",
        "stances",
    ]


def test_without_pandas_one_line_says_what_to_install(scene, monkeypatch):
    monkeypatch.setitem(sys.modules, "pandas", None)
    with pytest.raises(plogic.Error, match="pip install pandas"):
        scene.hypotheses.to_pandas()


def test_everything_shows_itself_in_a_notebook(scene, first, gamma_file):
    shown = [scene, first, Gamma.load(gamma_file), scene.explain("present(h1)")]
    assert [thing for thing in shown if "box" not in thing._repr_html_() and "corner" not in thing._repr_html_()] == []


# -- what a library does not do --------------------------------------------------------------------------------------


def test_nothing_prints(scene, first, gamma_file, tmp_path, capfd):
    perceive(gamma_file, first).report(tmp_path / "page.html")
    tables(scene)
    scene.explain("present(h1)").tree  # noqa: B018 - it is computed when it is asked for
    assert capfd.readouterr() == ("", "")


def test_every_error_of_ours_is_an_error_of_plogics():
    from kb.errors import KBErrors
    from plogic.base.errors import InconsistentError, InputError, LimitError, ProgramError
    from sensing.errors import GammaError, ImageError

    kinds = (KBErrors, InconsistentError, InputError, LimitError, ProgramError, GammaError, ImageError)
    assert [kind for kind in kinds if not issubclass(kind, plogic.Error)] == []


def test_an_interpretation_and_a_program_can_be_sent_to_another_process(scene):
    assert sent(scene) == scene
    assert sent(Program.load(ALARM)) == Program.load(ALARM)


def test_a_file_of_an_interpretation_is_asked_for_its_worlds_at_once(scene, tmp_path):
    file = scene.save(tmp_path / "i.json")
    code = f"from plogic import Interpretation; Interpretation.load({str(file)!r}).worlds()"
    start = time.perf_counter()
    subprocess.run([sys.executable, "-c", code], check=True, timeout=60)
    assert time.perf_counter() - start < 5.0


def _command_says(*args):
    """What the command tells on stderr, without its name."""
    from console import plogic as run

    done = run(*args)
    assert done.returncode == 1
    return "\n".join(line.removeprefix("plogic: ") for line in done.stderr.splitlines())
