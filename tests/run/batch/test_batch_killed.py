"""What is killed, by whomever: a run goes on where it ended, and a worker costs its frame at most."""

from __future__ import annotations

import json
import os
import shutil
import signal
import subprocess
import time
from contextlib import contextmanager

import pytest
from console import BIN, plogic
from hostile_pictures import DIES, DIES_ONCE, WAITS, hostile
from small_frames import CAMERA, KB, NAMES, picture

PATIENCE = 90


@contextmanager
def running(folder, out, *args, **env):
    """``plogic batch`` over ``frames`` in a process group of its own, ended at last."""
    command = [str(BIN / "plogic"), "batch", "frames", "--kb", str(KB), "-o", out, *args]
    pipe = subprocess.PIPE
    with subprocess.Popen(
        command, cwd=folder, stdin=pipe, stdout=pipe, stderr=pipe, start_new_session=True, env=os.environ | env
    ) as child:
        try:
            yield child
        finally:
            if child.poll() is None:
                os.killpg(child.pid, signal.SIGKILL)
            child.wait()


def wait_for_lines(path, count):
    end = time.monotonic() + PATIENCE
    while not path.exists() or path.read_bytes().count(b"\n") < count:
        assert time.monotonic() < end, "the lines do not come"
        time.sleep(0.05)


def group_members(group):
    """Living processes of a group."""
    found = subprocess.run(
        ["ps", "-o", "stat=", "-g", str(group)], capture_output=True, text=True, check=False
    ).stdout.split()
    return [state for state in found if not state.startswith("Z")]


@pytest.fixture(scope="module")
def waiting(frames, tmp_path_factory):
    """The frames again, with one more that is waited over for ever where the detector is there.

    And the variables by which it is.
    """
    root = tmp_path_factory.mktemp("killed")
    shutil.copytree(frames / "frames", root / "frames")
    picture(root / "frames" / "shot" / "late.png", WAITS)
    return root, hostile(root / "detector")


@pytest.fixture(scope="module")
def whole(waiting):
    """What one process writes about the same frames, where nobody waits."""
    return plogic("batch", "frames", "--kb", KB, "--jobs", 1, cwd=waiting[0]).stdout.encode()


@pytest.mark.parametrize(("number", "status"), [(signal.SIGINT, 1), (signal.SIGTERM, 143), (signal.SIGKILL, -9)])
def test_a_run_that_was_ended_goes_on_with_nothing_lost_and_nothing_twice(waiting, whole, number, status):
    root, env = waiting
    out = root / f"{number}.jsonl"
    with running(root, out, "--jobs", "2", "--order", "done", **env) as child:
        wait_for_lines(out, len(NAMES))
        (os.killpg if number == signal.SIGKILL else os.kill)(child.pid, number)
        said = child.communicate()[1].decode()
        assert child.returncode == status, said
        assert "Traceback" not in said
        end = time.monotonic() + PATIENCE
        while group_members(child.pid):
            assert time.monotonic() < end, "a worker is left"
            time.sleep(0.05)
    before = out.read_bytes()
    assert before.count(b"\n") == len(NAMES)
    if number != signal.SIGKILL:
        return
    out.write_bytes(before + b'{"format":"frame/1","input":"frames/shot/la')
    assert (
        plogic(
            "batch", "frames", "--kb", KB, "-o", out, "--resume", "--jobs", 1, "--order", "done", cwd=root
        ).returncode
        == 1
    )
    assert out.read_bytes().startswith(before)
    assert sorted(out.read_bytes().splitlines()) == sorted(whole.splitlines())


def test_in_the_order_of_the_inputs_the_file_is_the_same_after_a_kill(waiting, whole):
    root, env = waiting
    out, beside = root / "ordered.jsonl", root / "ordered.jsonl.waiting"
    with running(root, out, "--jobs", "2", **env) as child:
        wait_for_lines(out, NAMES.index("torn/image.png"))  # the late one is before it
        second = plogic("batch", "frames", "--kb", KB, "-o", out, "--resume", cwd=root)
        assert (second.returncode, second.stderr) == (1, f"plogic: {out}: another run is writing it\n")
        wait_for_lines(beside, 1)
        os.killpg(child.pid, signal.SIGKILL)
    assert [json.loads(line)["input"] for line in beside.read_bytes().splitlines()] == ["frames/torn/image.png"]
    fresh = plogic("batch", "frames", "--kb", KB, "-o", out, cwd=root)
    assert fresh.returncode == 1
    run = plogic("batch", "frames", "--kb", KB, "-o", out, "--resume", "--jobs", 2, cwd=root)
    assert run.stderr.splitlines()[-1] == f"{out}: 9 frames, 8 of them before, 3 bad"
    assert out.read_bytes() == whole
    assert not beside.exists()


def test_where_only_the_first_frame_is_late_nothing_is_lost_either(waiting, tmp_path):
    root, env = waiting
    (tmp_path / "frames").symlink_to(root / "frames")
    out, beside = tmp_path / "out.jsonl", tmp_path / "out.jsonl.waiting"
    args = ("frames/shot/late.png", "frames/g0.json", "frames/g1.json", "--kb", KB, "-o", out)
    command = [str(BIN / "plogic"), "batch", *map(str, args), "--jobs", "2"]
    with subprocess.Popen(
        command, cwd=tmp_path, stderr=subprocess.PIPE, start_new_session=True, env=os.environ | env
    ) as child:
        wait_for_lines(beside, 2)
        os.killpg(child.pid, signal.SIGKILL)
    assert out.read_bytes() == b""
    fresh = plogic("batch", *args, cwd=tmp_path)
    assert (fresh.returncode, fresh.stderr) == (
        1,
        f"plogic: {beside}: is there already: --resume goes on with it; else remove it, or name another\n",
    )
    run = plogic("batch", *args, "--resume", cwd=tmp_path)
    assert run.stderr == (
        "nothing found in 3 frames, first frames/g0.json (plogic perceive frames/g0.json, with the same KB and camera, "
        f"tells why)\n{out}: 3 frames, 2 of them before\n"
    )
    assert [json.loads(line)["input"] for line in out.read_bytes().splitlines()] == [*args[:3]]
    assert not beside.exists()


def test_a_worker_that_dies_or_hangs_costs_its_frame_alone(tmp_path):
    env = hostile(tmp_path / "detector")
    place = tmp_path / "frames"
    place.mkdir()
    (place / "camera.json").write_text(json.dumps({"camera": CAMERA}))
    for name, kind in {"a": 90, "b": DIES, "c": 90, "d": WAITS, "e": DIES_ONCE, "f": 90}.items():
        picture(place / f"{name}.png", kind)
    run = plogic("batch", "frames", "--kb", KB, "--jobs", 2, "--timeout", 4, cwd=tmp_path, **env)
    rows = [json.loads(line) for line in run.stdout.splitlines()]
    wrong = {row["input"][7]: row["error"] for row in rows if row["status"] == "error"}
    assert [row["input"][7] for row in rows] == list("abcdef")
    assert wrong == {
        "b": "the process that perceives it dies (signal 9, as for lack of memory)",
        "d": "took longer than 4 s",
    }
    assert run.returncode == 1
    assert (tmp_path / "detector" / "once").exists()
    assert "what a library says" not in run.stdout


def test_a_changed_kb_is_refused_and_nothing_is_cut(frames, tmp_path):
    shutil.copytree(KB, tmp_path / "kb")
    out = tmp_path / "out.jsonl"
    args = ("batch", "frames/g1.json", "frames/g2.json", "--kb", tmp_path / "kb", "--jobs", 1, "-o", out)
    assert plogic(*args, cwd=frames).returncode == 0
    torn = out.read_bytes()[:-5]
    out.write_bytes(torn)
    rules = tmp_path / "kb" / "rules.pl"
    rules.write_text((rules.read_text() if rules.exists() else "") + "\nmine(h1).\n")
    run = plogic(*args, "--resume", cwd=frames)
    assert run.returncode == 1
    assert f"{out}:1: was made with another knowledge base" in run.stderr
    assert out.read_bytes() == torn
