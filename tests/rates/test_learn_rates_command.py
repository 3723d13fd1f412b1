"""``plogic kb learn-rates`` through the console script, on scenes of the simulator."""

from __future__ import annotations

import json
import re
import shutil

import numpy as np
import pytest
from console import plogic

from kb.files.folder import shipped
from kb.files.read import read_kb
from plogic.base.errors import InputError
from plogic.rates.scene_records import read_truth


@pytest.fixture(scope="module")
def scenes(tmp_path_factory):
    folder = tmp_path_factory.mktemp("scenes")
    for seed, objects in ((70_001, 2), (70_002, 1), (70_003, 2)):
        assert (
            plogic(
                "simulate", "--kb", "towers", "--objects", objects, "--seed", seed, "-o", folder / str(seed)
            ).returncode
            == 0
        )
    return folder


def own_kb(folder):
    """A copy of the shipped towers, with a comment."""
    shutil.copytree(shipped("towers"), folder / "kb")
    text = (folder / "kb" / "kb.yaml").read_text().replace("detector:", "detector: # as measured on Monday")
    (folder / "kb" / "kb.yaml").write_text(text)
    return folder / "kb"


@pytest.fixture
def my_kb(tmp_path):
    return own_kb(tmp_path)


@pytest.fixture(scope="module")
def learned(scenes, tmp_path_factory):
    """The finished process of ``learn-rates --json`` from the scenes into a knowledge base, and that one's folder."""
    kb = own_kb(tmp_path_factory.mktemp("learned"))
    return plogic("kb", "learn-rates", scenes, "--kb", kb, "--json"), kb


def test_rates_are_written_with_their_counts_and_read_back(learned, my_kb):
    before = read_kb(my_kb)
    run, my_kb = learned
    assert run.returncode == 0, run.stderr
    document = json.loads(run.stdout)
    assert (document["format"], document["scenes"]) == ("rates/1", 3)
    kb = read_kb(my_kb)
    rows = {(row["rate"], row["of"]): row for row in document["rates"]}
    assert kb.rates.hit["corner"] == rows["hit", "corner"]["learnt"] != before.rates.hit["corner"]
    hits, expected = kb.rates.counts.hit["corner"]
    assert 0 < hits <= expected
    assert kb.rates.hit["corner"] == pytest.approx((hits + 1) / (expected + 2), rel=1e-3)
    assert kb.rates.counts.clutter["l_junction"][1] == 3
    assert sum(present for present, _ in kb.rates.counts.prior.values()) == 5
    assert "# as measured on Monday" in (my_kb / "kb.yaml").read_text()
    assert (kb.rates.sigma, kb.rates.sigmas, kb.f_ref) == (before.rates.sigma, before.rates.sigmas, before.f_ref)


def test_the_same_scenes_give_the_same_bytes_and_add_doubles_the_counts(scenes, learned, tmp_path):
    assert learned[0].returncode == 0
    my_kb = shutil.copytree(learned[1], tmp_path / "kb")
    once, counts = (my_kb / "kb.yaml").read_bytes(), read_kb(my_kb).rates.counts
    assert plogic("kb", "learn-rates", scenes, "--kb", my_kb).returncode == 0
    assert (my_kb / "kb.yaml").read_bytes() == once
    assert plogic("kb", "learn-rates", scenes, "--kb", my_kb, "--add").returncode == 0
    assert read_kb(my_kb).rates.counts.hit == {name: (2 * n, 2 * of) for name, (n, of) in counts.hit.items()}


def test_what_the_truth_does_not_list_is_weighed_by_em(scenes, my_kb, tmp_path):
    """Of a two-tower scene only one tower is told: perception finds the other, whose presence EM weighs."""
    scene = tmp_path / "partly"
    shutil.copytree(scenes / "70001", scene)
    truth = json.loads((scene / "truth.json").read_text())
    assert len(truth["objects"]) == 2
    (scene / "truth.json").write_text(json.dumps({**truth, "complete": False, "objects": truth["objects"][:1]}))
    run = plogic("kb", "learn-rates", scene, "--kb", my_kb, "--json")
    assert run.returncode == 0, run.stderr
    assert "1 instances of unknown presence were weighed by EM" in run.stderr
    counts = read_kb(my_kb).rates.counts
    assert counts.clutter == {}, "what nobody caused is not known"
    told, other = truth["objects"][0]["label"], truth["objects"][1]["label"]
    assert counts.prior[told] == (1, 1)
    assert counts.prior[other] == pytest.approx((1, 1), abs=0.02), "50 sightings leave no doubt"


def test_an_interpretation_with_ground_truth_tells_the_same(scenes, my_kb, tmp_path):
    scene = tmp_path / "interpreted"
    scene.mkdir()
    shutil.copy(scenes / "70001" / "truth.json", scene)
    image, camera = scenes / "70001" / "image.png", scenes / "70001" / "camera.json"
    assert (
        plogic("perceive", image, "--camera", camera, "--kb", "towers", "-o", scene / "interpretation.json").returncode
        == 0
    )
    rows = [
        json.loads(plogic("kb", "learn-rates", folder, "--kb", my_kb, "--dry-run", "--json").stdout)["rates"]
        for folder in (scene, scenes / "70001")
    ]
    assert rows[0] == rows[1]


def test_a_dry_run_and_bad_scenes_write_nothing(scenes, my_kb, tmp_path):
    before = (my_kb / "kb.yaml").read_bytes()
    assert plogic("kb", "learn-rates", scenes, "--kb", "towers", "--dry-run").returncode == 0
    for name, text in (
        ("no_json", "{"),
        ("no_truth", "{}"),
        ("no_pose", '{"format": "truth/1", "objects": [{"label": "t1"}]}'),
    ):
        (tmp_path / "bad" / name).mkdir(parents=True)
        (tmp_path / "bad" / name / "truth.json").write_text(text)
    run = plogic("kb", "learn-rates", scenes, tmp_path / "bad", "--kb", my_kb)
    assert run.returncode == 1
    lines = [line for line in run.stderr.splitlines() if line.startswith("plogic: ")]
    assert [sum(f"/{name}/" in line for line in lines) for name in ("no_json", "no_truth", "no_pose")] == [1, 2, 1]
    assert any("no_pose/truth.json:1:35: objects.0.T_camera_object: is missing" in line for line in lines)
    assert (my_kb / "kb.yaml").read_bytes() == before


POSE = np.eye(4).tolist()
MIRROR = np.diag([1.0, 1.0, -1.0, 1.0]).tolist()


@pytest.mark.parametrize(("entry", "said"), [
    ({"T_camera_object": POSE}, "objects.1.label: is missing: should be a text or null; null is the label of what the KB does not know"),
    ({"label": "t3", "T_camera_object": POSE}, "objects.1.label: 't3' is no type of the KB (t1, t2); null is the label of"),
    ({"label": 1, "T_camera_object": POSE}, "objects.1.label: 1 is no text"),
    ({"lable": "t1", "label": "t1", "T_camera_object": POSE}, "objects.1.lable: unknown key"),
    ({"label": "t1", "T_camera_object": MIRROR}, "objects.1.T_camera_object: should be a rigid motion"),
    ({"label": "t1", "T_camera_object": POSE, "visible_fraction": 1.5}, "objects.1.visible_fraction: 1.5 is not a number from 0.0 to 1.0"),
    ({"label": "t1", "T_camera_object": [[10**400] * 4] * 4}, "objects.1.T_camera_object: should be a rigid 4x4"),
])  # fmt: skip
def test_a_truth_is_checked_as_a_gamma_is(tmp_path, entry, said):
    """Each mistake has its place, and an object without a label is one: it was left out in silence."""
    good = {"label": "t1", "T_camera_object": POSE}
    (tmp_path / "truth.json").write_text(json.dumps({"format": "truth/1", "objects": [good, entry]}))
    with pytest.raises(InputError) as error:
        read_truth(tmp_path / "truth.json", {"t1", "t2"})
    place = re.compile(rf"{tmp_path / 'truth.json'}:1:\d+: objects\.1\.")
    assert all(place.match(line) for line in str(error.value).splitlines())
    assert said in str(error.value)


def test_an_object_that_the_kb_does_not_know_is_told_by_null(tmp_path):
    rows = [{"label": "t1", "T_camera_object": POSE}, {"label": None, "T_camera_object": POSE}]
    (tmp_path / "truth.json").write_text(json.dumps({"format": "truth/1", "objects": rows, "complete": False}))
    truth = read_truth(tmp_path / "truth.json", {"t1"})
    assert [o.label for o in truth.objects] == ["t1", None]
    assert not truth.complete


@pytest.mark.parametrize(("arguments", "said"), [
    (("{scenes}", "--kb", "towers"), "is shipped with plogic"),
    (("{nowhere}", "--kb", "{kb}"), "is no scene"),
])  # fmt: skip
def test_what_cannot_be_learned_is_said(scenes, my_kb, tmp_path, arguments, said):
    places = {"scenes": scenes, "kb": my_kb, "nowhere": tmp_path / "nowhere"}
    run = plogic("kb", "learn-rates", *(argument.format(**places) for argument in arguments))
    assert (run.returncode, run.stdout) == (1, "")
    assert said in run.stderr
    assert "Traceback" not in run.stderr
