"""The file that is appended to: any cut of it is gone on with, and what does not agree is refused."""

from __future__ import annotations

import json
import tempfile
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from plogic.base.errors import InputError
from plogic.run.batch.frame_lines import Lines, short
from plogic.run.batch.frames import Frame, Settings
from plogic.run.batch.log import MOST, check_out, check_same, left_over, log_at

SETTINGS = Settings("towers", worlds=2)
KB = {"name": "towers", "digest": "d"}
FRAMES = [Frame(name, None, "lost", f"{name}: is ünfit") for name in ("a.png", "b.png", "c\udc80.json", "d.json")]
LINES = [Lines(SETTINGS, KB).given_up(frame, frame.at)[1] for frame in FRAMES]
WHOLE = b"".join(LINES)


@given(st.integers(0, len(WHOLE)))
@settings(deadline=None)
def test_a_file_cut_anywhere_ends_up_whole(cut):
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "out.jsonl"
        path.write_bytes(WHOLE[:cut])
        with log_at(str(path)) as log:
            left = left_over(FRAMES, log.written, in_order=True)
            check_same(FRAMES, log.written, SETTINGS, KB)
            assert path.read_bytes() == WHOLE[:cut]
            assert len(left) == len(FRAMES) - WHOLE[:cut].count(b"\n")
            log.cut()
            for frame in left:
                log.write(Lines(SETTINGS, KB).given_up(frame, frame.at)[1])
        assert path.read_bytes() == WHOLE


def written(lines):
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "out.jsonl"
        path.write_bytes(b"".join(lines))
        with log_at(str(path)) as log:
            return log.written


@given(st.permutations(range(4)), st.integers(0, 4))
def test_out_of_order_any_frames_may_be_done(order, count):
    found = written([LINES[i] for i in order[:count]])
    left = left_over(FRAMES, found, in_order=False)
    assert left == [frame for i, frame in enumerate(FRAMES) if i not in order[:count]]
    if list(order[:count]) != list(range(count)):
        with pytest.raises(InputError, match="--order done"):
            left_over(FRAMES, found, in_order=True)


def test_what_does_not_agree_is_refused():
    with pytest.raises(InputError, match=r"out.jsonl:2: is of a.png, as an earlier one is"):
        left_over(FRAMES, written([LINES[0], LINES[0]]), in_order=False)
    with pytest.raises(InputError, match=r"a.png, which is not among the inputs now"):
        left_over(FRAMES[1:], written(LINES[:1]), in_order=False)
    with pytest.raises(InputError, match=r"other options: worlds 2"):
        check_same(FRAMES, written(LINES), Settings("towers", worlds=3), KB)
    with pytest.raises(InputError, match="another knowledge base"):
        check_same(FRAMES, written(LINES), SETTINGS, {**KB, "digest": "e"})
    with pytest.raises(InputError, match=r"b.png or its camera has changed"):
        check_same([FRAMES[0], Frame("b.png", None, "lost", "otherwise"), *FRAMES[2:]], written(LINES), SETTINGS, KB)


@pytest.mark.parametrize(
    "content", [b"mine", b"mine\n", b"{}\n", b'{"format":"frame/1"}\n', b"[" * 100_000 + b"\n", b"\xff\n"]
)
def test_a_file_of_something_else_is_left_alone(tmp_path, content):
    path = tmp_path / "out.jsonl"
    path.write_bytes(content)
    with pytest.raises(InputError, match=r"out.jsonl:1: is no frame/1"), log_at(str(path)):
        pass
    assert path.read_bytes() == content


@pytest.mark.parametrize(
    ("key", "value"),
    [
        ("input", []),
        ("input", None),
        ("frame", [1]),
        ("frame", 1),
        ("status", []),
        ("status", "odd"),
        ("sha256", 1),
        ("kb", "d"),
        ("options", []),
    ],
)
def test_a_value_of_another_kind_is_refused(key, value):
    row = json.dumps({**json.loads(LINES[1]), key: value}).encode() + b"\n"
    with pytest.raises(
        InputError,
        match=rf"out.jsonl:2: is no frame/1: {key}: is of another kind\n--resume cannot go on: take these lines out",
    ):
        written([LINES[0], row])


def test_mistakes_are_told_together_up_to_some_number():
    with pytest.raises(InputError) as told:
        written([LINES[0], b"{}\n", LINES[1], b"[]\n"])
    assert [line.split(":")[1] for line in str(told.value).splitlines()[:-1]] == ["2", "4"]
    with pytest.raises(InputError) as told:
        written([b"{}\n"] * 1000)
    assert len(str(told.value).splitlines()) == MOST + 2
    with pytest.raises(InputError) as told:
        left_over(FRAMES[2:], written(LINES[:2]), in_order=True)
    assert [line.split(":")[1] for line in str(told.value).splitlines()[:-1]] == ["1", "2"]
    others = [Frame(frame.input, None, "lost", "otherwise") for frame in FRAMES]
    with pytest.raises(InputError) as told:
        check_same(others, written(LINES), SETTINGS, KB)
    assert len(str(told.value).splitlines()) == len(LINES) + 1


def test_two_runs_cannot_write_one_file(tmp_path):
    place = str(tmp_path / "out.jsonl")
    with log_at(place), pytest.raises(InputError, match="another run is writing it"), log_at(place):
        pass


def test_what_another_run_has_written_since_the_places_were_checked_is_not_taken_for_a_run_to_go_on_with(tmp_path):
    place = tmp_path / "out.jsonl"
    check_out([place], resume=False)
    place.write_bytes(LINES[0])
    with (
        pytest.raises(InputError, match="is there already: --resume goes on with it"),
        log_at(str(place), resume=False),
    ):
        pass
    with log_at(str(place), resume=True) as log:
        assert len(log.written) == 1
    assert place.read_bytes() == LINES[0]


def test_what_the_deadline_cut_short_is_told():
    document = {"appearances": [], "worlds": [], "unlisted_mass": [0.0, 1.0], "hypotheses": []}
    assert Lines(SETTINGS, KB).perceived(FRAMES[0], document, None)[0] == "done"
    status, line = Lines(SETTINGS, KB).perceived(FRAMES[0], document | {"unfinished": True}, "d")
    assert status == json.loads(line)["status"] == "unfinished"


def test_in_short_the_intervals_of_what_is_unfinished_stay_and_no_others_come():
    kept = {"type": "t1", "T_camera_object": [], "ev": 0.5, "ev_reconsidered": 0.5, "probability": 0.5, "more": 1}
    rows = [{"id": "h1", "status": "accepted", **kept}]
    worlds = [{"probability": p, "present": ["h1"], "causes": {}} for p in (0.5, 0.25)]
    done = {"appearances": [], "worlds": worlds, "unlisted_mass": [0.25, 0.25], "hypotheses": rows}
    late = done | {"unfinished": True, "stopped": "worlds", "unlisted_mass": [0.0, 0.9]}
    late["hypotheses"] = [rows[0] | {"interval": [0.4, 0.6]}]
    late["worlds"] = [
        world | {"interval": [world["probability"] - 0.1, world["probability"] + 0.1]} for world in worlds
    ]
    assert "interval" not in json.dumps(short(done, 1))
    assert "stopped" not in short(done, 1)
    told = short(late, 1)
    assert (told["stopped"], told["hypotheses"][0]["interval"], told["worlds"][0]["interval"]) == (
        "worlds",
        [0.4, 0.6],
        [0.4, 0.6],
    )
    assert told["unlisted_mass"] == [pytest.approx(0.15), 1.0]
    assert short(done, 1)["unlisted_mass"] == [0.5, 0.5]


def test_a_name_that_is_no_text_comes_back():
    assert json.loads(LINES[2])["input"] == FRAMES[2].input
    assert "ünfit".encode() in LINES[0]


WORLD = st.tuples(st.floats(0.001, 1.0), st.lists(st.sampled_from(["h1", "h2", "h3"]), unique=True))


@given(st.lists(WORLD, min_size=1, max_size=6), st.integers(0, 7), st.floats(0.0, 0.3))
def test_in_short_no_mass_is_lost_and_every_name_is_told(worlds, number, unlisted):
    total = sum(p for p, _ in worlds) / (1.0 - unlisted)
    kept = {"T_camera_object": [], "ev": 0.5, "ev_reconsidered": 0.5, "probability": 0.5, "type": "t1", "more": 1}
    document = {
        "appearances": [1, 2],
        "worlds": [{"probability": p / total, "present": names, "causes": {}} for p, names in worlds],
        "unlisted_mass": [unlisted, unlisted],
        "hypotheses": [
            {"id": name, "status": "accepted" if name == "h1" else "rejected", **kept}
            for name in ("h1", "h2", "h3", "h4")
        ],
    }
    told = short(document, number)
    names = {h["id"] for h in told["hypotheses"]}
    assert sum(world["probability"] for world in told["worlds"]) + told["unlisted_mass"][0] == pytest.approx(1.0)
    assert names == {"h1"} | {name for world in told["worlds"] for name in world["present"]}
    assert len(told["worlds"]) == min(number, len(worlds))
    assert all("more" not in h for h in told["hypotheses"])
