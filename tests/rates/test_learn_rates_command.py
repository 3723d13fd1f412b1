"""``plogic kb learn-rates`` through the console script, on scenes of the simulator."""

from __future__ import annotations

import json
import shutil

import pytest
from console import plogic

from kb.files.folder import shipped
from kb.files.read import read_kb


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


@pytest.fixture
def my_kb(tmp_path):
    shutil.copytree(shipped("towers"), tmp_path / "kb")
    text = (tmp_path / "kb" / "kb.yaml").read_text().replace("detector:", "detector: # as measured on Monday")
    (tmp_path / "kb" / "kb.yaml").write_text(text)
    return tmp_path / "kb"


def test_rates_are_written_with_their_counts_and_read_back(scenes, my_kb):
    before = read_kb(my_kb)
    run = plogic("kb", "learn-rates", scenes, "--kb", my_kb, "--json")
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


def test_the_same_scenes_give_the_same_bytes_and_add_doubles_the_counts(scenes, my_kb):
    assert plogic("kb", "learn-rates", scenes, "--kb", my_kb).returncode == 0
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
    assert len(lines) == 3, "all mistakes at once"
    assert any("no_pose/truth.json: objects.0.T_camera_object: should be a rigid motion" in line for line in lines)
    assert (my_kb / "kb.yaml").read_bytes() == before


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
