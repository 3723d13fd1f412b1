"""``plogic bop``: the loop over frames, names to numbers, the CSV, the scores."""

import io
import json
import re
import sys
from pathlib import Path
from time import monotonic, sleep

import numpy as np
import pytest
from bop_folders import dataset, put, truth
from click.testing import CliRunner
from results_reader import read_results

from plogic.base.clock import Stopwatch
from plogic.base.errors import InputError, ProgramError
from plogic.face.commands import bop as bop_module
from plogic.face.commands.bop import bop_command, look_of
from plogic.face.commands.clicked import bop
from plogic.face.shown import progress
from plogic.face.shown.options import Scoring
from plogic.run.bop.dataset import open_dataset
from plogic.run.bop.models import ids_of, read_ids, unknown
from plogic.run.bop.recalls import views_of
from plogic.run.bop.results_file import HEADER, run
from plogic.run.sources import kb_of
from sensing.files.gamma_files import read_gamma

IDS = {"t1": 1, "t2": 2}
FIRST = Path(__file__).parents[3] / "examples" / "first_gamma.json"
OPTIONS = {"ids": None, "timed": False, "as_json": False}


def at(x_mm=0.0):
    pose = np.eye(4)
    pose[:3, 3] = x_mm / 1000, 0, 1
    return pose


def told():
    lines = []
    return lines, lines.append


@pytest.fixture
def folder(tmp_path):
    """Two images: a cube 1 in each, a cube 2 in the second."""
    root = dataset(tmp_path / "d", {0: [truth(1)], 4: [truth(1), truth(2, (300, 0, 1000))]})
    put(tmp_path / "ids.json", {"t1": 1, "t2": 2})
    return root


def perfect(image, camera):
    """What is right for image 4."""
    assert image.shape == (camera.height, camera.width, 3)
    return [("t1", at(), 0.9), ("t2", at(300), 0.8), ("t3", at(), 0.7)]


def command(folder, out, look=perfect, **options):
    lines, say = told()
    written, write = told()
    stated = {**OPTIONS, "ids": str(folder.parent / "ids.json"), **options}
    return (
        bop_command(str(folder), "towers", str(out), Scoring(**stated), say=say, write=write, look=look),
        lines,
        written,
    )


def test_every_frame_is_looked_at(folder):
    lines, say = told()
    done = run(open_dataset(folder), perfect, IDS, say)
    found = [(e.scene_id, e.im_id, e.obj_id, e.score, e.time) for e in done.estimates]
    assert found == [(1, i, n, s, -1.0) for i in (0, 4) for n, s in ((1, 0.9), (2, 0.8))]
    assert lines == [f"{i}/2 scene 1, image {n}: 2 estimates, 1 without a BOP number" for i, n in ((1, 0), (2, 4))]
    assert (done.wrong, done.frames, sorted(done.cameras)) == ((), 2, [(1, 0), (1, 4)])


def test_times_are_one_an_image(folder):
    done = run(open_dataset(folder), perfect, IDS, lambda _: None, timed=True)
    assert [e.time for e in done.estimates[::2]] == [e.time for e in done.estimates[1::2]]
    assert all(e.time >= 0 for e in done.estimates)


def test_an_image_that_takes_long_is_named_and_nothing_else_changes(folder, tmp_path, monkeypatch):
    soon = command(folder, tmp_path / "soon.csv", as_json=True)
    monkeypatch.setattr(progress, "SELDOM", 0.01)
    monkeypatch.setattr(progress, "TICK", 0.01)
    monkeypatch.setattr(sys, "stderr", stream := io.StringIO())

    def slow(image, camera):
        before, end = stream.getvalue().count("so far"), monotonic() + 10.0
        while stream.getvalue().count("so far") == before and monotonic() < end:
            sleep(0.005)
        return perfect(image, camera)

    late = command(folder, tmp_path / "late.csv", look=slow, as_json=True)
    told = stream.getvalue().splitlines()
    for name in ("1/2 scene 1, image 0", "2/2 scene 1, image 4"):
        assert f"{name}: perceiving; 0 s so far" in told
    assert late[0] == soon[0].replace("soon.csv", "late.csv")
    assert late[1][:-1] == soon[1][:-1]
    assert (tmp_path / "late.csv").read_bytes() == (tmp_path / "soon.csv").read_bytes()


def test_images_that_are_soon_done_tell_nothing_new(folder, tmp_path, monkeypatch):
    monkeypatch.setattr(sys, "stderr", stream := io.StringIO())
    command(folder, tmp_path / "out.csv")
    assert stream.getvalue() == ""


class Told(Stopwatch):
    """Keeps what it was at."""

    def at(self, part):
        """As of a stopwatch."""
        super().at(part)
        self.seconds[self.here] = 0.0


def test_the_perceiver_of_the_knowledge_base_tells_its_stages_and_counts_types(monkeypatch):
    clock, gamma = Told(), read_gamma(str(FIRST))
    monkeypatch.setattr(bop_module, "detectable", lambda _: True)
    monkeypatch.setattr(bop_module, "detect", lambda *_: gamma)
    assert look_of(kb_of("first"), clock)(None, gamma.camera)
    assert {"detect", "search", "worlds"} <= clock.seconds.keys()
    assert "search, 0 of 1 type" in clock.seconds
    assert clock.here == ""


def bad_program(image, camera):
    raise ProgramError("two\nlines")


def broken(image, camera):
    raise ZeroDivisionError("division by zero")


def crooked(image, camera):
    return [("t1", 2 * np.eye(4), 1.0)]


def unsure(image, camera):
    return [("t1", np.eye(4), float("nan"))]


@pytest.mark.parametrize(
    ("look", "words"),
    [
        (bad_program, "program: two lines"),
        (broken, "internal error: ZeroDivisionError: division by zero"),
        (crooked, "t1: the perceiver gave no rigid pose with a finite score"),
        (unsure, "t1: the perceiver gave no rigid pose with a finite score"),
    ],
)
def test_a_bad_frame_is_a_line_and_never_a_stop(folder, look, words):
    seen = []

    def once(image, camera):
        seen.append(image)
        return look(image, camera) if len(seen) == 1 else perfect(image, camera)

    lines, say = told()
    done = run(open_dataset(folder), once, IDS, say)
    assert lines[0] == f"1/2 scene 1, image 0: {words}"
    assert list(done.wrong) == lines[:1]
    assert len(done.estimates) == 2


def test_bad_files_are_lines_too(folder):
    (folder / "test/000001/rgb/000000.png").write_bytes(b"\x89PNG no")
    put(folder / "test/000002/scene_camera.json", "{")
    lines, say = told()
    done = run(open_dataset(folder), perfect, IDS, say)
    assert "000002/scene_camera.json:1:2: is no JSON" in lines[0]
    assert "000000.png" in lines[1]
    assert (len(done.wrong), len(done.estimates), done.frames) == (2, 2, 2)


def test_a_bad_frame_is_missed_in_the_scores(folder):
    (folder / "test/000001/rgb/000000.png").unlink()
    done = run(open_dataset(folder), perfect, IDS, lambda _: None)
    views, wrong = views_of(open_dataset(folder), done)
    assert (wrong, [(len(v.truths), len(v.estimates), v.camera is None) for v in views]) == (
        [],
        [(1, 0, True), (2, 2, False)],
    )


def test_the_csv_and_the_scores(folder, tmp_path):
    text, lines, _ = command(folder, tmp_path / "r.csv")
    assert [e.obj_id for e in read_results(tmp_path / "r.csv")] == [1, 2, 1, 2]
    rows = {words[0]: words[1:] for words in (line.split() for line in text.splitlines()[:-2]) if words}
    assert rows["all"] == ["3", "1.000", "1.000", "1.000", "1.000"]
    assert (rows["1"][0], rows["2"][0]) == ("2", "1")
    assert "AR_MSSD" in text
    assert "mean of the two" in text
    assert "2 images, 4 estimates, 1 of them of objects that are not in their image" in text
    assert "AR_VSD is not computed" in text
    assert lines[-1] == f"wrote {tmp_path / 'r.csv'}"


def test_no_average_is_called_ar_alone(folder, tmp_path):
    document = json.loads(command(folder, tmp_path / "r.csv", as_json=True)[0])
    assert set(document["scores"]["recalls"][0]) == {
        "object",
        "targets",
        "AR_MSSD",
        "AR_MSPD",
        "mean of the two",
        "ADD(-S) recall",
    }
    assert (document["format"], document["frames"], document["perceived"], document["estimates"]) == ("bop/1", 2, 2, 4)


def test_the_same_input_gives_the_same_bytes(folder, tmp_path):
    for name in ("a.csv", "b.csv"):
        command(folder, tmp_path / name)
    assert (tmp_path / "a.csv").read_bytes() == (tmp_path / "b.csv").read_bytes()


def test_a_dash_is_stdout(folder):
    text, lines, written = command(folder, "-")
    assert (text, written[0].splitlines()[0], len(written[0].splitlines())) == ("", HEADER, 5)
    assert "AR_MSSD" in lines[-1]
    with pytest.raises(InputError, match="both be on stdout"):
        command(folder, "-", as_json=True)


def test_without_truth_or_models_there_are_no_scores(folder, tmp_path):
    (folder / "models/obj_000002.ply").unlink()
    assert "not scored" in command(folder, tmp_path / "r.csv")[0]
    (folder / "models/models_info.json").unlink()
    assert command(folder, tmp_path / "r.csv")[0] == "not scored: there are no models (models/models_info.json)"
    (folder / "test/000001/scene_gt.json").unlink()
    assert command(folder, tmp_path / "r.csv")[0] == "not scored: no image has ground truth (scene_gt.json)"
    assert len(read_results(tmp_path / "r.csv")) == 4


def test_bad_truth_is_a_line_and_the_csv_is_written(folder, tmp_path):
    put(folder / "test/000001/scene_gt.json", {"0": [truth(1)], "4": [{"obj_id": 1}]})
    text, lines, _ = command(folder, tmp_path / "r.csv")
    assert any(re.search(r"scene_gt\.json:1:\d\d+: 4\.0\.cam_R_m2c: is missing", line) for line in lines)
    assert "1 images" in text


@pytest.mark.parametrize("options", [{"out": "no/such/r.csv"}, {"look": broken}, {"ids": None}, {"ids": "none.json"}])
def test_nothing_is_written_where_nothing_can_be_done(folder, tmp_path, options):
    before = sorted(tmp_path.rglob("*"))
    with pytest.raises(Exception, match=r"cannot be written|none of its 2 images|none of its types|cannot be read"):
        command(folder, tmp_path / options.pop("out", "r.csv"), **options)
    assert sorted(tmp_path.rglob("*")) == before


def test_ids_by_name_and_by_file(tmp_path):
    assert ids_of(["obj_000005", "obj_12", "mug", "box"], {"mug": 3, "obj_12": 7, "ghost": 9}) == {
        "obj_000005": 5,
        "obj_12": 7,
        "mug": 3,
    }
    assert unknown(["mug", "box"], {"mug": 3}, {"mug": 3, "ghost": 9}, [1]) == [
        "box: has no BOP number: what is found of it is left out (name it obj_000001, or give --ids)",
        "ghost: has a BOP number, but the knowledge base has no such type",
        "mug: the dataset has no object 3",
    ]
    with pytest.raises(InputError, match="obj_3 and mug are both BOP object 3"):
        ids_of(["obj_3", "mug"], {"mug": 3})
    for content, words in (
        ([], "must be an object of numbers"),
        ({"a": "1"}, "a: must be a whole number"),
        ("{", "is no JSON"),
    ):
        put(tmp_path / "ids.json", content)
        with pytest.raises(InputError, match=words):
            read_ids(str(tmp_path / "ids.json"))


def test_types_are_known_by_the_names_in_the_datasets_models(folder, tmp_path):
    """No numbers are given: ``models_info.json`` says which is which; a number that is given counts more."""
    file = folder / "models" / "models_info.json"
    info = json.loads(file.read_text())
    info["1"]["name"], info["2"]["name"] = "t1", "t2"
    put(file, info)
    command(folder, tmp_path / "named.csv", ids=None)
    assert [row.obj_id for row in read_results(tmp_path / "named.csv")] == [1, 2, 1, 2]
    put(tmp_path / "ids.json", {"t1": 2, "t2": 1})
    command(folder, tmp_path / "stated.csv")
    assert [row.obj_id for row in read_results(tmp_path / "stated.csv")] == [2, 1, 2, 1]


def test_the_command_itself(folder, tmp_path):
    """With the KB's own perceiver, on grey pictures: nothing is found, nothing is wrong."""
    run = CliRunner().invoke(
        bop,
        [str(folder), "--kb", "towers", "-o", str(tmp_path / "r.csv"), "--ids", str(tmp_path / "ids.json"), "--json"],
    )
    assert run.exit_code == 0, run.output
    document = json.loads(run.stdout)
    assert (document["estimates"], document["wrong"], document["scores"]["recalls"][0]["AR_MSSD"]) == (0, [], 0.0)
    assert "1/2 scene 1, image 0: 0 estimates" in run.stderr
    assert (tmp_path / "r.csv").read_text() == HEADER + "\n"


def test_its_help():
    text = CliRunner().invoke(bop, ["--help"]).output
    assert all(option in text for option in ("--kb", "--out", "--ids", "--times", "--json"))
