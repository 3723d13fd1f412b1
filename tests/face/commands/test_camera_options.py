"""The ways to tell a picture's camera, and what is guessed, doubted or refused where none is told."""

from __future__ import annotations

import hashlib
import json

import cv2
import pytest
from console import bytes_in, good, plogic
from exif_files import EQUIVALENT, FOCAL, HEIGHT, ORIENTATION, RESOLUTION, UNIT, WIDTH, exif, grey, jpeg
from refusals import assert_lines, refused

from geometry.field_of_view import DIAGONAL_35MM, fov_across
from plogic.run.cameras import WAYS

TURNED = "its orientation tag (6) is not applied: pixels, and --fov across, are of the picture as it is stored, 64x48"
"""Of a picture of 64 x 48, whose diagonal is 80 px."""
F28 = 80 * 28 / 43.266615


@pytest.fixture
def folder(tmp_path):
    cv2.imwrite(str(tmp_path / "plain.png"), grey(64, 48))
    (tmp_path / "phone.jpg").write_bytes(jpeg(grey(64, 48), exif({EQUIVALENT: 28}, {ORIENTATION: 6})))
    tags = {FOCAL: (4, 1), RESOLUTION: (20, 1), UNIT: 4, WIDTH: 64, HEIGHT: 48}
    (tmp_path / "still.jpg").write_bytes(jpeg(grey(64, 48), exif(tags)))
    (tmp_path / "cut.jpg").write_bytes(jpeg(grey(48, 48), exif({EQUIVALENT: 28, WIDTH: 64, HEIGHT: 48})))
    (tmp_path / "lens.json").write_text(json.dumps(camera(60)))  # no camera.json: that would be taken
    return tmp_path


def camera(f, width=64, height=48, dist=()):
    K = [[f, 0, (width - 1) / 2], [0, f, (height - 1) / 2], [0, 0, 1]]
    return {"width": width, "height": height, "K": K, "dist": list(dist)}


def perceived(folder, *args):
    """The camera of the interpretation, and what was said before its summary."""
    run = plogic("perceive", *args, "--kb", "towers", "-o", "out.json", cwd=folder)
    assert run.returncode == 0, run.stderr
    said = run.stderr.splitlines()
    return json.loads((folder / "out.json").read_text())["camera"], [line for line in said if line.startswith(args[0])]


@pytest.mark.parametrize(
    ("option", "value", "f"),
    [("--fov", "90", 32.0), ("--fov-diagonal", "90", 40.0), ("--focal", "60", 60.0), ("--camera", "lens.json", 60.0)],
)
def test_each_way_gives_its_focal_length_in_the_middle(folder, option, value, f):
    found, said = perceived(folder, "plain.png", option, value)
    assert said == []
    assert found["K"][0] == [pytest.approx(f), 0, 31.5]
    assert found["K"][1] == [0, pytest.approx(f), 23.5]
    assert found["dist"] == []


def test_exif_is_a_guess_that_is_said(folder):
    found, said = perceived(folder, "phone.jpg")
    assert found["K"][0][0] == pytest.approx(F28)
    guess = "camera guessed from EXIF: 28 mm equivalent, focal 52 px; no lens distortion known"
    assert said == [f"phone.jpg: {guess}", f"phone.jpg: {TURNED}"]
    found, said = perceived(folder, "still.jpg")
    assert found["K"][0][0] == pytest.approx(80.0)
    assert said == [
        f"still.jpg: {guess.replace('28 mm equivalent, focal 52', '4 mm on a sensor of 20 px/mm, focal 80')}"
    ]


def test_a_given_camera_goes_before_exif_which_may_contradict_it(folder):
    assert perceived(folder, "phone.jpg", "--camera", "lens.json") == (camera(60.0), [])
    assert perceived(folder, "phone.jpg", "--focal", str(F28 * 1.32))[1] == [f"phone.jpg: {TURNED}"]
    doubt = "has a focal length of 69 px, but EXIF tells 52 px (28 mm equivalent)"
    assert perceived(folder, "phone.jpg", "--focal", "69.1")[1][1] == f"phone.jpg: --focal {doubt}"
    (folder / "other.json").write_text(json.dumps(camera(69.1)))
    assert perceived(folder, "phone.jpg", "--camera", "other.json")[1] == [f"phone.jpg: other.json {doubt}"]
    assert "--fov has a focal length of 18 px" in perceived(folder, "phone.jpg", "--fov", "120")[1][1]


def test_without_any_one_line_says_what_to_do(folder):
    for name, why in (("plain.png", "its EXIF tells no focal length"), ("cut.jpg", "EXIF is of 64x48 and the picture")):
        (line,) = refused(folder, "perceive", name, "--kb", "towers", "-o", "out.json")
        assert_lines(
            [line], [f"{name}: an image needs its camera: give --camera FILE, or its field of view: --fov DEG"]
        )
        assert why in line


@pytest.mark.parametrize(
    "ways",
    [
        ("--fov", "60", "--focal", "50"),
        ("--camera", "lens.json", "--fov-diagonal", "60"),
        ("--camera", "lens.json", "--fov", "60", "--fov-diagonal", "70", "--focal", "50"),
    ],
)
@pytest.mark.parametrize("command", [("perceive",), ("batch",), ("kb", "learn", "box", "--photo")], ids=" ".join)
def test_two_ways_at_once_are_bad_usage(folder, command, ways):
    run = plogic(*command, "plain.png", "--kb", "towers", *ways, cwd=folder)
    assert (run.returncode, run.stdout) == (2, "")
    last = run.stderr.splitlines()[-1]
    assert last == f"Error: {' and '.join(ways[::2])}: each tells the camera: give one of them"


@pytest.mark.parametrize(
    "way",
    [("--fov", "0"), ("--fov", "180"), ("--fov-diagonal", "nan"), ("--focal", "-3"), ("--focal", "inf")],
    ids=" ".join,
)
def test_no_such_angle_or_length_is_bad_usage(folder, way):
    run = plogic("perceive", "plain.png", "--kb", "towers", *way, cwd=folder)
    assert (run.returncode, run.stdout) == (2, "")
    assert way[0] in run.stderr.splitlines()[-1]


@pytest.mark.parametrize(
    ("other", "wanted"),
    [
        (
            camera(120, 128, 96),
            "of the same shape; if it was scaled by 0.5, give its camera with fx 60, fy 60, cx 31.5, cy 23.5, or --focal 60",
        ),
        (
            camera(30, 32, 24, [-0.1, 0, 0, 0]),
            "scaled by 2, give its camera with fx 60, fy 60, cx 31.5, cy 23.5, dist as it is",
        ),
        (camera(60, 48, 64), "it is turned by a quarter"),
        (camera(60, 64, 64), "it is of another shape, so it was cut, or is another camera's"),
    ],
)
def test_a_picture_of_another_size_than_its_camera_says_what_to_do(folder, other, wanted):
    (folder / "other.json").write_text(json.dumps(other))
    lines = refused(folder, "perceive", "plain.png", "--camera", "other.json", "--kb", "towers", "-o", "out.json")
    size = f"{other['width']}x{other['height']}"
    assert_lines(lines, [f"other.json: the camera is {size}, but plain.png is 64x48: "])
    assert lines[0].endswith(wanted) or wanted in lines[0]


def test_batch_takes_the_same_ways_and_resumes_by_them(folder):
    names = ["plain.png", "phone.jpg"]
    (folder / "lens.json").unlink()
    good("batch", *names, "--kb", "towers", "--full", "--fov", "90", "-o", "out.jsonl", cwd=folder)
    lines = [json.loads(line) for line in (folder / "out.jsonl").read_text().splitlines()]
    assert [line["interpretation"]["camera"]["K"][0][0] for line in lines] == [pytest.approx(32.0)] * 2
    assert [line["options"]["fov"] for line in lines] == [90.0, 90.0]
    again = plogic(
        "batch", *names, "--kb", "towers", "--full", "--fov", "91", "--resume", "-o", "out.jsonl", cwd=folder
    )
    assert again.returncode == 1
    assert "was made by other options: fov 90.0" in again.stderr


def test_batch_without_any_camera_fails_at_once_in_the_words_of_perceive_and_blocks_nothing(folder):
    (folder / "lens.json").unlink()
    (folder / "more").mkdir()
    for number in range(3):
        (folder / "more" / f"{number}.png").write_bytes((folder / "plain.png").read_bytes())
    before = bytes_in(folder)
    command = ("batch", "more", "--kb", "towers", "-o", "out.jsonl")
    run = plogic(*command, cwd=folder)
    alone = plogic("perceive", "more/0.png", "--kb", "towers", cwd=folder)
    assert (run.returncode, run.stdout, run.stderr) == (alone.returncode, "", alone.stderr)
    assert run.stderr.startswith("plogic: more/0.png: an image needs its camera: give --camera FILE")
    assert bytes_in(folder) == before
    good(*command, "--fov", "90", cwd=folder)
    assert len((folder / "out.jsonl").read_text().splitlines()) == 3


def test_batch_takes_a_camera_file_that_states_no_size(folder):
    (folder / "K.yaml").write_text("camera_matrix: [60, 0, 32, 0, 60, 24, 0, 0, 1]\n")
    good("batch", "plain.png", "--kb", "towers", "--camera", "K.yaml", "-o", "out.jsonl", cwd=folder)
    assert json.loads((folder / "out.jsonl").read_text())["status"] == "done"


def test_batch_guesses_by_exif_and_its_lines_say_so(folder):
    (folder / "lens.json").unlink()
    run = plogic("batch", "plain.png", "phone.jpg", "--kb", "towers", "-o", "out.jsonl", cwd=folder)
    assert run.returncode == 1
    wrong, guessed = (json.loads(line) for line in (folder / "out.jsonl").read_text().splitlines())
    assert wrong["error"].startswith("plain.png: an image needs its camera")
    assert guessed["notes"] == [
        "camera guessed from EXIF: 28 mm equivalent, focal 52 px; no lens distortion known",
        TURNED,
    ]
    assert (
        run.stderr.splitlines()[-1]
        == "out.jsonl: 2 frames, 1 bad, 1 with a guessed or doubtful camera (notes, camera_doubt)"
    )


@pytest.fixture
def rig(folder):
    """A reconstruction of two pictures by two cameras, and pictures that are of neither."""
    (folder / "lens.json").unlink()
    (folder / "rig").mkdir()
    lines = "1 SIMPLE_PINHOLE 64 48 60 32 24\n2 SIMPLE_PINHOLE 64 48 70 32 24\n"
    (folder / "rig/cameras.txt").write_text(f"# cameras\n{lines}")
    (folder / "rig/images.txt").write_text("1 1 0 0 0 0 0 0 1 a.png\n\n2 1 0 0 0 0 0 0 2 shots/b.png\n1 2 -1\n")
    for name in ("a.png", "b.png", "000007.png"):
        cv2.imwrite(str(folder / name), grey(64, 48))
    entry = {"cam_K": [90, 0, 31.5, 0, 90, 23.5, 0, 0, 1], "width": 64, "height": 48}
    (folder / "scene_camera.json").write_text(json.dumps({"5": {**entry, "cam_K": [1] * 9}, "7": entry}))
    return folder


@pytest.mark.parametrize(
    ("name", "given", "f"),
    [
        ("a.png", "rig", 60.0),
        ("b.png", "rig", 70.0),
        ("b.png", "rig/cameras.txt", 70.0),
        ("b.png", "rig#1", 60.0),
        ("plain.png", "rig/cameras.txt#2", 70.0),
        ("000007.png", "scene_camera.json", 90.0),
        ("plain.png", "scene_camera.json#7", 90.0),
    ],
)
def test_one_camera_of_many_is_told_by_the_picture_or_by_its_name(rig, name, given, f):
    assert perceived(rig, name, "--camera", given) == (camera(f), [])


def test_a_picture_that_tells_no_camera_of_many_says_which_there_are(rig):
    lines = refused(rig, "perceive", "plain.png", "--camera", "rig", "--kb", "towers", "-o", "out.json")
    wanted = (
        "rig/cameras.txt: has 2 cameras; say which camera: 1, 2 (FILE#1); images.txt tells no one camera for plain.png"
    )
    assert_lines(lines, [wanted])
    lines = refused(rig, "perceive", "plain.png", "--camera", "rig#3", "--kb", "towers", "-o", "out.json")
    assert_lines(lines, ["rig/cameras.txt: has no camera 3; it has 1, 2"])


def test_batch_takes_each_picture_s_own_camera_and_sees_when_that_changes(rig):
    args = ("batch", "a.png", "b.png", "plain.png", "--kb", "towers", "--full", "--camera", "rig", "-o", "out.jsonl")
    assert plogic(*args, cwd=rig).returncode == 1
    a, b, other = (json.loads(line) for line in (rig / "out.jsonl").read_text().splitlines())
    assert [row["interpretation"]["camera"]["K"][0][0] for row in (a, b)] == [60.0, 70.0]
    assert "tells no one camera for plain.png" in other["error"]
    cameras = (rig / "rig/cameras.txt").read_bytes()
    assert b["sha256"] == hashlib.sha256((rig / "b.png").read_bytes() + cameras + b"#2").hexdigest()
    good("batch", "a.png", "b.png", "--kb", "towers", "--camera", "rig", "-o", "two.jsonl", cwd=rig)
    images = rig / "rig/images.txt"
    images.write_text(images.read_text().replace("2 shots/b.png", "1 shots/b.png"))
    again = plogic(
        "batch", "a.png", "b.png", "--kb", "towers", "--camera", "rig", "--resume", "-o", "two.jsonl", cwd=rig
    )
    assert again.returncode == 1
    assert "b.png or its camera has changed" in again.stderr


def test_a_topic_that_was_echoed_is_a_camera(folder):
    message = "header:\n  stamp:\n    sec: 1\nheight: 48\nwidth: 64\nd: []\nk:\n" + "".join(
        f"- {number}\n" for number in (60.0, 0.0, 31.5, 0.0, 60.0, 23.5, 0.0, 0.0, 1.0)
    )
    (folder / "info.yaml").write_text(f"{message}---\n{message}---\n")
    assert perceived(folder, "plain.png", "--camera", "info.yaml") == (camera(60.0), [])


def test_a_camera_that_is_of_no_use_is_told(folder):
    gamma = {"format": "gamma/1", "camera": camera(60), "appearances": []}
    (folder / "g.json").write_text(json.dumps(gamma))
    found, said = perceived(folder, "g.json", "--fov", "90")
    assert (found, said) == (camera(60.0), ["g.json: a Γ has a camera of its own: --fov is not used"])
    pair = {"format": "stereo/1", "T_right_left": [[1, 0, 0, -0.1], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]}
    (folder / "stereo.json").write_text(json.dumps(pair))
    both = (
        "perceive",
        "g.json",
        "g.json",
        "--stereo",
        "stereo.json",
        "--focal",
        "50",
        "--kb",
        "towers",
        "-o",
        "out.json",
    )
    assert_lines(refused(folder, *both), ["--focal: --stereo tells both cameras; leave one of the two out"])


def test_the_angles_of_phones_that_are_named_are_those_of_24_to_28_mm():
    angles = [round(fov_across(DIAGONAL_35MM, mm)) for mm in (28, 24)]
    assert f"{angles[0]} to {angles[1]} of most phones' main cameras" in WAYS


def test_a_file_that_lies_beside_the_picture_and_is_no_camera_is_told_to_be_that(folder):
    (folder / "camera.json").write_text('{"type": "PerspectiveCamera"}')
    (line,) = refused(folder, "perceive", "phone.jpg", "--kb", "towers", "-o", "out.json")
    assert line.endswith("; it lies beside the picture, and no camera was given: give one, or move it")
    (folder / "camera.json").write_text(json.dumps(camera(60)))
    assert perceived(folder, "phone.jpg")[0] == camera(60.0)
