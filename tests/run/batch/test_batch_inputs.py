"""What names lead to: every frame once, in a fixed order, and nothing is left out in silence."""

from __future__ import annotations

import os

import pytest
from bop_folders import dataset, put, scene

from plogic.base.errors import InputError
from plogic.run.batch.frames import Frame, digest_of, frames_of
from plogic.run.bop.json_files import numbered
from plogic.run.cameras import GivenCamera, camera_beside


def named(*inputs, listed=()):
    return [(frame.input, frame.kind) for frame in frames_of(inputs, listed)]


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    """Where the tests are: files are empty, for nothing is read yet."""
    monkeypatch.chdir(tmp_path)
    for name in (
        "b/2.PNG",
        "b/1.jpg",
        "b/camera.json",
        "b/truth.json",
        "b/.hidden/3.png",
        "b/notes.txt",
        "a.json",
        "a[1].json",
        "z/deep/g.json",
    ):
        path = tmp_path / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.touch()
    return tmp_path


def test_a_folder_is_all_that_lies_below_it():
    assert named(".") == [
        ("a.json", "gamma"),
        ("a[1].json", "gamma"),
        ("b/1.jpg", "image"),
        ("b/2.PNG", "image"),
        ("z/deep/g.json", "gamma"),
    ]


def test_what_plogic_wrote_or_drew_there_is_no_frame(folder):
    for name in (
        "own/interpretation.json",
        "own/image.png",
        "own/picture.png",
        "own/views.png",
        "own/poses.json",
        "mine/picture.png",
    ):
        (folder / name).parent.mkdir(exist_ok=True)
        (folder / name).touch()
    assert named("own", "mine") == [("own/image.png", "image"), ("mine/picture.png", "image")]
    assert named("own/picture.png") == [("own/picture.png", "image")], "what is named is tried"


def test_patterns_lists_and_files_give_each_frame_once_in_their_order():
    assert named("z", "*/*.jpg", "./b/1.jpg", "-", listed=["a.json\n", "\n", "z\r\n", "a[1].json"]) == [
        ("z/deep/g.json", "gamma"),
        ("b/1.jpg", "image"),
        ("a.json", "gamma"),
        ("a[1].json", "gamma"),
    ]
    assert named("**/g.json") == [("z/deep/g.json", "gamma")]
    assert named("b/notes.txt") == [("b/notes.txt", "image")], "what is named is tried"


def test_what_is_not_there_or_never_ends_is_lost_and_said(folder):
    os.mkfifo(folder / "pipe.json")
    lost = frames_of(["gone.png", "pipe.json"], ())
    assert [(frame.kind, frame.at) for frame in lost] == [
        ("lost", "gone.png: is missing"),
        ("lost", "pipe.json: is no plain file, but a pipe or a device"),
    ]
    assert all(digest_of(frame, GivenCamera()) for frame in lost)


def test_pipes_and_devices_in_a_folder_are_lost_and_said(folder):
    place = folder / "odd"
    place.mkdir()
    os.mkfifo(place / "a.json")
    os.mkfifo(place / "b.png")
    (place / "c.png").symlink_to("/dev/zero")
    (place / "d.png").symlink_to("d.png")
    lost = frames_of(["odd"], ())
    assert {frame.kind for frame in lost} == {"lost"}
    assert [frame.at for frame in lost] == [
        "odd/a.json: is no plain file, but a pipe or a device",
        "odd/b.png: is no plain file, but a pipe or a device",
        "odd/c.png: is no plain file, but a pipe or a device",
        "odd/d.png: is a link that leads back to itself",
    ]


def test_a_folder_that_cannot_be_read_is_lost_and_said(folder, monkeypatch):
    scandir = os.scandir

    def closed(path):
        if str(path).endswith("deep"):
            raise PermissionError(13, "Permission denied", str(path))
        return scandir(path)

    monkeypatch.setattr(os, "scandir", closed)  # root may read all
    (folder / "z/a.json").touch()
    frames = frames_of(["z"], ())
    assert [(frame.kind, frame.at) for frame in frames] == [
        ("gamma", ""),
        ("lost", "z/deep: cannot be read: Permission denied"),
    ]


def test_links_to_folders_are_followed_and_no_folder_is_looked_through_twice(folder):
    (folder / "b/again").symlink_to(folder)
    (folder / "b/again2").symlink_to(folder / "b")
    (folder / "a_link").symlink_to(folder / "z")
    assert named("b") == [
        ("b/1.jpg", "image"),
        ("b/2.PNG", "image"),
        ("b/again/a.json", "gamma"),
        ("b/again/a[1].json", "gamma"),
        ("b/again/z/deep/g.json", "gamma"),
    ]
    assert [name for name, _ in named(".")] == ["a.json", "a[1].json", "b/1.jpg", "b/2.PNG", "z/deep/g.json"]


@pytest.mark.parametrize("name", ["nothing*", "gone[1].json", "b/.hidden/none*", "empty"])
def test_what_leads_nowhere_is_lost_and_stops_no_other(folder, name):
    (folder / "empty").mkdir()
    lost, good = frames_of([name, "a.json"], ())
    assert (lost.input, lost.kind, lost.at) == (name, "lost", f"{name}: leads to no picture and no Γ")
    assert (good.input, good.kind) == ("a.json", "gamma")


def test_a_dataset_that_cannot_be_told_is_lost_and_stops_no_other(folder):
    for split in ("test_one", "test_two"):
        scene(folder / "bop" / split / "000001", {1: []})
    lost, good = frames_of(["bop", "a.json"], ())
    assert (lost.kind, lost.at) == ("lost", "bop: give one of its splits: test_one, test_two")
    assert good.kind == "gamma"


def test_no_input_at_all_is_an_error():
    with pytest.raises(InputError, match="there is no input"):
        frames_of(["-"], ["\n"])


def test_a_dataset_its_split_and_its_scene(folder):
    dataset(folder / "bop", {3: [], 1: []})
    keys = [("000001/000001", "bop"), ("000001/000003", "bop")]
    for name in ("bop", "bop/test", "bop/test/000001"):
        assert [(frame.input, frame.frame, frame.kind) for frame in frames_of([name], ())] == [
            (name, *key) for key in keys
        ]


def test_a_scene_that_cannot_be_read_is_one_lost_frame(folder):
    dataset(folder / "bop", {1: []})
    put(folder / "bop/test/000002/scene_camera.json", "[")
    frames = frames_of(["bop"], ())
    assert [frame.kind for frame in frames] == ["bop", "lost"]
    assert "000002/scene_camera.json" in frames[1].at


def test_scenes_without_cameras_and_of_a_number_that_is_taken_are_lost(folder):
    dataset(folder / "bop", {1: []})
    scene(folder / "bop/test/1", {5: []})
    (folder / "bop/test/000002/gray").mkdir(parents=True)
    (folder / "bop/test/000003").mkdir()
    first, lost = frames_of(["bop"], ())
    assert (first.frame, first.kind, first.at) == ("000001/000001", "bop", str(folder.resolve() / "bop/test/000001"))
    assert lost.kind == "lost"
    assert lost.at.splitlines() == [
        f"{folder.resolve()}/bop/test/1: is scene 1, as 000001/ beside it is, which is taken",
        f"{folder.resolve()}/bop/test/000002/scene_camera.json: is missing",
    ]


def test_the_digest_is_of_all_that_is_read(folder):
    frame = Frame("b/1.jpg", None, "image")
    assert camera_beside(frame.input, GivenCamera()) == GivenCamera("b/camera.json")
    assert camera_beside(frame.input, GivenCamera("a.json")) == GivenCamera("a.json")
    assert camera_beside("a.json", GivenCamera()) == GivenCamera()
    seen = {digest_of(frame, GivenCamera())}
    for name in ("b/1.jpg", "b/camera.json"):
        (folder / name).write_text("more")
        seen.add(digest_of(frame, GivenCamera()))
    assert len(seen) == 3
    (folder / "b/1.jpg").unlink()
    assert digest_of(frame, GivenCamera()) is None


def test_the_digest_of_a_bop_frame_is_of_its_own_camera(folder):
    place = scene(folder / "s/000001", {1: [], 2: []})
    first, second = frames_of([str(place)], ())
    before = digest_of(first, GivenCamera()), digest_of(second, GivenCamera())
    cameras = (place / "scene_camera.json").read_text()
    put(place / "scene_camera.json", cameras.replace('"depth_scale": 1.0', '"depth_scale": 2.0', 1))
    assert digest_of(first, GivenCamera()) != before[0]
    assert digest_of(second, GivenCamera()) == before[1]


def test_a_scenes_cameras_are_parsed_once_until_they_change(folder, monkeypatch):
    parsed = []
    monkeypatch.setattr("plogic.run.bop.dataset.numbered", lambda path: parsed.append(path) or numbered(path))
    place = scene(folder / "s/000001", {i: [] for i in range(9)})
    frames = frames_of([str(place)], ())
    parsed.clear()
    assert len({digest_of(frame, GivenCamera()) for frame in frames}) == 1, "all are of one picture and one camera"
    assert len(parsed) == 1
    put(place / "scene_camera.json", (place / "scene_camera.json").read_text() + " ")
    assert digest_of(frames[0], GivenCamera())
    assert len(parsed) == 2
