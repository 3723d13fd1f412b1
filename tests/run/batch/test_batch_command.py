"""``plogic batch`` as a user runs it: the same bytes as ``plogic perceive``, whoever works."""

from __future__ import annotations

import json
import os
import re
from pathlib import Path

import pytest
from bop_folders import K, dataset
from console import good, plogic
from small_frames import CAMERA, KB, NAMES

from benchmarks.batch.cluster import loopback
from plogic.run.batch.frame_lines import short


def lines_of(path):
    return path.read_bytes().splitlines(keepends=True)


def test_every_frame_has_its_line_in_the_order_of_names(alone):
    run, out = alone
    rows = [json.loads(line) for line in lines_of(out)]
    assert [row["input"] for row in rows] == [f"frames/{name}" for name in NAMES]
    assert [row["status"] for row in rows] == ["error", "error", "done", "done", "done", "done", "done", "error"]
    assert {row["format"] for row in rows} == {"frame/1"}
    assert run.returncode == 1


def test_off_a_terminal_stderr_has_the_bad_frames_and_one_line_at_the_end(alone):
    lines = alone[0].stderr.splitlines()
    assert [line.split(":")[0] for line in lines] == [
        "frames/alone.png",
        "frames/bad.json",
        "frames/torn/image.png",
        "nothing found in 5 frames, first frames/g0.json (plogic perceive frames/g0.json, with the same KB and camera, tells why)",
        "alone.jsonl",
    ]
    assert lines[-1] == "alone.jsonl: 8 frames, 3 bad"


def test_frames_with_nothing_in_them_are_counted_and_the_first_is_named(frames, tmp_path):
    gamma = json.loads((frames / "frames" / NAMES[2]).read_text(encoding="utf-8"))
    for name in ("c.json", "b.json"):
        (tmp_path / name).write_text(json.dumps(gamma | {"appearances": []}), encoding="utf-8")
    run = plogic("batch", "b.json", "c.json", "--kb", str(frames / KB), "-o", "out.jsonl", cwd=tmp_path)
    assert run.stderr.splitlines() == [
        "nothing found in 2 frames, first b.json (plogic perceive b.json, with the same KB and camera, tells why)",
        "out.jsonl: 2 frames",
    ]


@pytest.mark.parametrize("number", [3, 6], ids=lambda i: NAMES[i])
def test_an_interpretation_is_the_bytes_of_perceive(frames, alone, number):
    place = f"frames/{NAMES[number]}"
    camera = ["--camera", "frames/shot/camera.json"] if place.endswith(".png") else []
    text = good("perceive", place, "--kb", KB, *camera, cwd=frames)
    assert lines_of(alone[1])[number].endswith(b'"interpretation":' + text.strip().encode() + b"}\n")


@pytest.mark.parametrize("number", [1, 7], ids=lambda i: NAMES[i])
def test_an_error_is_what_perceive_says(frames, alone, number):
    place = f"frames/{NAMES[number]}"
    camera = ["--camera", "frames/torn/camera.json"] if place.endswith(".png") else []
    said = plogic("perceive", place, "--kb", KB, *camera, cwd=frames).stderr
    assert [f"plogic: {line}" for line in json.loads(lines_of(alone[1])[number])["error"].splitlines()] == [
        line
        for line in said.splitlines()
        if line.startswith("plogic: ")  # others are about the knowledge base
    ]


def test_two_processes_write_the_same_bytes_for_a_list_on_stdin(frames, alone):
    listed = "frames\nframes/g1.json\n./frames/g*.json\n"
    run = plogic("batch", "-", "--kb", KB, "--jobs", 2, "--full", cwd=frames, stdin=listed)
    assert run.returncode == 1
    assert run.stdout.encode() == alone[1].read_bytes()


OFTEN = """\
import plogic.base.alarm as alarm
alarm.TICK = 0.001
import plogic.face.shown.progress as progress
progress.SELDOM = 0.0
"""
"""Read by Python as it starts, in the workers as well: every frame takes long, and is told of at once."""


@pytest.mark.parametrize("jobs", [1, 2])
def test_frames_that_take_long_are_named_with_what_is_done_to_them_and_the_answer_is_the_same(
    frames, alone, tmp_path, jobs
):
    (tmp_path / "sitecustomize.py").write_text(OFTEN)
    path = os.pathsep.join([str(tmp_path), *filter(None, [os.environ.get("PYTHONPATH")])])
    run = plogic(
        "batch", "frames", "--kb", KB, "--jobs", jobs, "--full", cwd=frames, PYTHONPATH=path, PYTHONHASHSEED="0"
    )
    assert run.stdout.encode() == alone[1].read_bytes()
    told = [line for line in run.stderr.splitlines() if line.endswith(" s so far")]
    stage = re.compile(r"\d of 8 frames(, \d bad)?(, about \d+ s left)?(, 2 at work)?; frames/\S+: \w+.*; \d+ s so far")
    assert any(map(stage.fullmatch, told)), run.stderr
    said = [line for line in run.stderr.splitlines() if " of 8 frames" not in line and not line.startswith("reading ")]
    assert said[:-1] == alone[0].stderr.splitlines()[:-1]
    assert "\r" not in run.stderr


def test_as_they_are_done_it_is_the_same_set_in_short(frames, alone):
    run = plogic("batch", "frames", "--kb", KB, "--jobs", 2, "--order", "done", "-n", 1, cwd=frames)
    found = {row["input"]: row for row in map(json.loads, run.stdout.splitlines())}
    assert len(found) == len(run.stdout.splitlines()) == len(NAMES)
    for row in map(json.loads, lines_of(alone[1])):
        mine = found[row["input"]]
        assert mine["options"].pop("worlds") == 1
        assert row["options"].pop("full")
        wanted = row | (short(row.pop("interpretation"), 1) if row["status"] == "done" else {})
        assert mine == wanted


def test_a_dask_cluster_writes_the_same_bytes(frames, alone):
    with loopback(2) as address:
        run = plogic("batch", "frames", "--kb", KB, "--dask", address, "--full", cwd=frames)
        lost = plogic("batch", "frames", "--kb", "nothing", "--dask", address, cwd=frames)
    assert run.stdout.encode() == alone[1].read_bytes()
    assert (lost.returncode, lost.stdout) == (1, "")
    assert lost.stderr.startswith("plogic: no knowledge base 'nothing'")


def test_without_the_extra_one_line_says_what_to_install(frames, tmp_path):
    (tmp_path / "distributed.py").write_text("raise ImportError\n")
    run = plogic("batch", "frames", "--kb", KB, "--dask", "tcp://127.0.0.1:1", cwd=frames, PYTHONPATH=str(tmp_path))
    assert (run.returncode, run.stdout, run.stderr) == (
        1,
        "",
        "plogic: --dask needs the package distributed: pip install 'plogic[dask]'\n",
    )


def test_the_deadline_leaves_a_frame_unfinished_and_that_is_the_status():
    examples = Path(__file__).parents[3] / "examples"
    run = plogic("batch", "first_gamma.json", "--kb", "first", "--jobs", 1, "--deadline", 1e-6, cwd=examples)
    assert (run.returncode, json.loads(run.stdout)["status"]) == (3, "unfinished")
    assert run.stderr == "1 frame, 1 unfinished\n"
    row = json.loads(run.stdout)
    assert row["worlds"] == [{"probability": 1.0, "present": [], "interval": [0.0, 1.0]}]
    assert (row["stopped"], row["unlisted_mass"]) == ("search", [0.0, 1.0])


def test_a_bop_dataset(tmp_path):
    place = dataset(tmp_path / "mini", {1: [], 2: [], 3: []})
    (place / "test/000001/rgb/000002.png").unlink()
    run = plogic("batch", "mini", "--kb", "towers", "--jobs", 1, "--full", cwd=tmp_path)
    rows = [json.loads(line) for line in run.stdout.splitlines()]
    assert [(row["input"], row["frame"], row["status"]) for row in rows] == [
        ("mini", "000001/000001", "done"),
        ("mini", "000001/000002", "error"),
        ("mini", "000001/000003", "done"),
    ]
    camera = CAMERA | {"width": 640, "height": 480, "K": [K[:3], K[3:6], K[6:]]}
    (tmp_path / "camera.json").write_text(json.dumps({"camera": camera}))
    text = good(
        "perceive", "mini/test/000001/rgb/000003.png", "--kb", "towers", "--camera", "camera.json", cwd=tmp_path
    )
    assert run.stdout.splitlines()[2].endswith(f'"interpretation":{text.strip()}}}')


@pytest.mark.parametrize(
    ("args", "says"),
    [
        (["--jobs", 1, "--dask", "tcp://h:1"], "exclude each other"),
        (["--resume"], "--resume needs a file"),
        (["--timeout", "nan"], "no number"),
        (["--timeout", "inf"], "--timeout must be finite"),
        (["--deadline", "inf"], "--deadline must be finite"),
        (["-n", "-1"], "not in the range"),
    ],
)
def test_bad_usage(frames, args, says):
    run = plogic("batch", "frames", "--kb", KB, *args, cwd=frames)
    assert run.returncode == 2
    assert says in run.stderr


def test_what_is_wrong_before_any_work_writes_nothing(frames, tmp_path):
    (tmp_path / "full.jsonl").write_text("mine\n")
    for args, says in (
        (["frames", "--kb", KB, "--camera", tmp_path / "full.jsonl", "-o", tmp_path / "new.jsonl"], "full.jsonl"),
        (
            ["frames", "--kb", KB, "--camera", tmp_path / "none.json", "-o", tmp_path / "new.jsonl"],
            "none.json: is missing",
        ),
        (
            ["frames", "--kb", KB, "--camera", "/dev/zero", "-o", tmp_path / "new.jsonl"],
            "is no plain file, but a pipe or a device",
        ),
        (["frames", "--kb", "nothing", "-o", tmp_path / "new.jsonl"], "no knowledge base 'nothing'"),
        (["-", "--kb", KB, "-o", tmp_path / "new.jsonl"], "there is no input"),
        (["frames", "--kb", KB, "-o", tmp_path / "full.jsonl"], "is there already: --resume goes on with it"),
        (["frames", "--kb", KB, "-o", tmp_path / "none" / "new.jsonl"], "cannot be written"),
    ):
        run = plogic("batch", *args, "--jobs", 1, cwd=frames)
        assert (run.returncode, run.stdout) == (1, "")
        assert run.stderr.startswith("plogic: ")
        assert says in run.stderr
    assert sorted(path.name for path in tmp_path.iterdir()) == ["full.jsonl"]
    assert (tmp_path / "full.jsonl").read_text() == "mine\n"
