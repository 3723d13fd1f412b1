import json
import re

import numpy as np
import pytest
from geometry_bodies import LENS

from geometry.camera import camera_to_dict
from geometry.errors import CameraError
from geometry.files.camera_files import read_camera

PLAIN = camera_to_dict(LENS)
ROS = """
image_width: 640
image_height: 480
camera_name: front
camera_matrix: {rows: 3, cols: 3, data: [600, 0, 320, 0, 590, 240, 0, 0, 1]}
distortion_model: plumb_bob
distortion_coefficients: {rows: 1, cols: 5, data: [-0.25, 0.08, 0.001, -0.002, 0.01]}
rectification_matrix: {rows: 3, cols: 3, data: [1, 0, 0, 0, 1, 0, 0, 0, 1]}
"""
ROS_TOPIC = """
header: {seq: 1, frame_id: front}
height: 480
width: 640
distortion_model: plumb_bob
D: [-0.25, 0.08, 0.001, -0.002, 0.01]
K: [600.0, 0.0, 320.0, 0.0, 590.0, 240.0, 0.0, 0.0, 1.0]
"""
OPENCV4 = """%YAML:1.0
---
image_width: 640
image_height: 480
camera_matrix: !!opencv-matrix
   rows: 3
   cols: 3
   dt: d
   data: [ 600., 0., 320., 0., 590., 240., 0., 0., 1. ]
distortion_coefficients: !!opencv-matrix
   rows: 1
   cols: 5
   dt: d
   data: [ -2.5e-01, 8.0e-02, 1.0e-03, -2.0e-03, 1.0e-02 ]
"""
COLMAP = """# Camera list with one line of data per camera:
1 SIMPLE_PINHOLE 640 480 600 320.5 240.5
2 FULL_OPENCV 640 480 600 590 320.5 240.5 -0.25 0.08 0.001 -0.002 0.01 0 0 0
"""


def written(folder, name, content):
    path = folder / name
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(content if isinstance(content, str) else json.dumps(content))
    return path


@pytest.mark.parametrize(
    ("content", "frame"),
    [
        (PLAIN, None),
        ({"format": "gamma/1", "camera": PLAIN, "appearances": []}, None),
        (ROS, None),
        (ROS_TOPIC, None),
        (OPENCV4, None),
        (COLMAP, 2),
        (COLMAP, "2"),
    ],
)
def test_every_kind_of_file_gives_the_same_camera(tmp_path, content, frame):
    camera = read_camera(written(tmp_path, "camera", content), frame)
    points = np.array([[0.3, 0.2, 2], [-0.5, 0.1, 3]])
    assert (camera.width, camera.height) == (640, 480)
    assert np.allclose(camera.project(points), LENS.project(points), atol=1e-9)


OPENCV_XML = """<?xml version="1.0"?>
<opencv_storage>
<calibration_time>"Thu 26 Nov 2026"</calibration_time>
<image_width>640</image_width>
<image_height>480</image_height>
<camera_matrix type_id="opencv-matrix">
  <rows>3</rows>
  <cols>3</cols>
  <dt>d</dt>
  <data>
    600. 0. 320. 0. 590. 240. 0. 0. 1.</data></camera_matrix>
<distortion_coefficients type_id="opencv-matrix">
  <rows>5</rows>
  <cols>1</cols>
  <dt>d</dt>
  <data>
    -2.5e-01 8.0e-02 1.0e-03 -2.0e-03 1.0e-02</data></distortion_coefficients>
</opencv_storage>
"""
MATRIX = {"type_id": "opencv-matrix", "rows": 3, "cols": 3, "dt": "d", "data": [600, 0, 320, 0, 590, 240, 0, 0, 1]}
LENS_ROW = {"type_id": "opencv-matrix", "rows": 1, "cols": 5, "dt": "d", "data": list(PLAIN["dist"])}
OPENCV_JSON = {"image_width": 640, "image_height": 480, "camera_matrix": MATRIX, "distortion_coefficients": LENS_ROW}
ROW = [600, 0, 320, 0, 590, 240, 0, 0, 1]


@pytest.mark.parametrize(
    "content",
    [
        OPENCV_XML,
        "\ufeff" + OPENCV_XML,
        OPENCV_XML.replace("camera_matrix", "Camera_Matrix").replace("distortion_coeff", "Distortion_Coeff"),
        OPENCV_JSON,
        {"width": 640, "height": 480, "K": ROW, "dist": PLAIN["dist"]},
        {"camera": {"width": 640, "height": 480, "K": ROW, "dist": PLAIN["dist"]}},
        {"width": 640, "height": 480, "k": ROW, "d": PLAIN["dist"], "distortion_model": "plumb_bob"},
        {"width": 640, "height": 480, "K": ROW, "D": PLAIN["dist"]},
        f"width: 640\nheight: 480\nK: {ROW}\ndist: {PLAIN['dist']}\n",
        f"image_width: 640\nimage_height: 480\ncamera_matrix: {ROW}\ndist_coeffs: {PLAIN['dist']}\n",
    ],
)
def test_what_opencv_and_ros_write_as_xml_and_json_and_nine_numbers_in_a_row(tmp_path, content):
    assert camera_to_dict(read_camera(written(tmp_path, "camera", content))) == PLAIN


@pytest.mark.parametrize("suffix", ["yml", "xml", "json"])
def test_opencvs_own_writer_is_read_in_each_of_its_formats(tmp_path, suffix):
    cv2 = pytest.importorskip("cv2")
    path = tmp_path / f"camera.{suffix}"
    store = cv2.FileStorage(str(path), cv2.FILE_STORAGE_WRITE)
    for name, value in (("image_width", 640), ("image_height", 480), ("camera_matrix", np.array(LENS.K))):
        store.write(name, value)
    store.write("distortion_coefficients", np.array(LENS.dist)[:, None])
    store.write("calibration_time", "Tue 1 Jan: <new> & shiny")
    store.release()
    assert camera_to_dict(read_camera(path)) == PLAIN
    renamed = tmp_path / "camera"  # the text tells the kind, not the name
    renamed.write_bytes(b"\xef\xbb\xbf" + path.read_bytes())
    assert camera_to_dict(read_camera(renamed)) == PLAIN


def test_a_pose_beside_a_row_of_nine_is_kept_and_strange_keys_are_mistakes(tmp_path):
    pose = [[1, 0, 0, 2], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]
    whole = {"width": 640, "height": 480, "K": ROW, "T_world_camera": pose}
    assert read_camera(written(tmp_path, "camera", whole)).world_from_camera[0, 3] == 2
    with pytest.raises(CameraError, match="fov"):
        read_camera(written(tmp_path, "strange", whole | {"fov": 60}))


def test_a_size_that_is_not_stated_is_the_pictures(tmp_path):
    text = OPENCV_XML.replace("<image_width>640</image_width>", "")
    assert read_camera(written(tmp_path, "camera", text), size=(640, 480)).width == 640


def test_k_alone_has_the_pictures_size(tmp_path):
    """As numpy.savetxt writes it, with its comment."""
    K = np.array([[600.5, 0.0, 320.0], [0.0, 601.0, 240.0], [0.0, 0.0, 1.0]])
    np.savetxt(tmp_path / "K.txt", K, header="camera matrix")
    camera = read_camera(tmp_path / "K.txt", size=(640, 480))
    assert (camera.width, camera.height, camera.dist.size) == (640, 480, 0)
    assert (camera.K == K).all()
    with pytest.raises(CameraError, match=r"K\.txt: states no width and height"):
        read_camera(tmp_path / "K.txt")


@pytest.mark.parametrize(
    "text",
    [
        "600.5, 0, 320\n0, 601, 240\n0, 0, 1\n",
        "600.5;0;320\n0;601;240\n0;0;1",
        "[[600.5   0.  320. ]\n [  0.  601.  240. ]\n [  0.    0.    1. ]]\n",
        "[[600.5, 0, 320], [0, 601, 240], [0, 0, 1]]",
        "6.005e2 0 320 0 601 240 0 0 1  # a row",
    ],
)
def test_k_alone_in_rows_or_one_whatever_parts_its_numbers(tmp_path, text):
    camera = read_camera(written(tmp_path, "K.txt", text), size=(640, 480))
    assert camera.K.tolist() == [[600.5, 0, 320], [0, 601, 240], [0, 0, 1]]


@pytest.mark.parametrize(
    ("text", "lengths"), [("600 0 320\n0 600 240", "[3, 3]"), ("600 0\n0 600 240 1\n0 0 1", "[2, 4, 3]")]
)
def test_numbers_alone_that_are_no_k_are_told_as_such(tmp_path, text, lengths):
    with pytest.raises(CameraError, match=re.escape(f"or nine in one row, not {lengths}")):
        read_camera(written(tmp_path, "K.txt", text), size=(640, 480))


def test_colmaps_principal_point_is_half_a_pixel_off_ours(tmp_path):
    assert read_camera(written(tmp_path, "cameras.txt", COLMAP), 1).K.tolist() == [
        [600, 0, 320],
        [0, 600, 240],
        [0, 0, 1],
    ]


def test_bop_scenes_are_in_millimetres_and_take_their_size_from_the_dataset(tmp_path):
    frame = {
        "cam_K": [600, 0, 320, 0, 600, 240, 0, 0, 1],
        "cam_R_w2c": np.eye(3).ravel().tolist(),
        "cam_t_w2c": [0, 0, 2000],
    }
    scene = written(tmp_path, "test/000001/scene_camera.json", {"0": frame, "17": frame})
    with pytest.raises(CameraError, match="states no width and height"):
        read_camera(scene, 17)
    assert read_camera(scene, 17, size=(320, 200)).width == 320
    intrinsics = written(tmp_path, "camera.json", {"fx": 1, "fy": 2, "cx": 3, "cy": 4, "width": 640, "height": 480})
    camera = read_camera(scene, "000017")
    assert (camera.width, camera.height) == (640, 480)
    assert camera.world_from_camera[:3, 3].tolist() == [0, 0, -2]
    assert read_camera(intrinsics).K.tolist() == [[1, 0, 3], [0, 2, 4], [0, 0, 1]]
    with pytest.raises(CameraError, match=r"has 2 cameras; say which frame: 0, 17 \(FILE#0\)"):
        read_camera(scene)
    with pytest.raises(CameraError, match="has no frame 3"):
        read_camera(scene, 3)


@pytest.mark.parametrize(
    ("content", "message"),
    [
        ("", "must be a camera in JSON, YAML, XML or COLMAP's text"),
        ("{", ":1:2: is no JSON"),
        ('{"width": 3,\n "K" 4}', ":2:6: is no JSON"),
        ('{"width": 1, "width": 2}', "'width' is given twice in one object"),
        ('{"width": ' + "9" * 5000 + "}", "more digits than can be read"),
        ({**PLAIN, "width": 0}, r"camera.txt:1:\d+: width: 0 is not a whole number from 1 to 65536"),
        ('{"width": 64, "height": 48, "K": [[NaN, 0, 0], [0, 1, 0], [0, 0, 1]]}', ":1:34: K: must be a 3x3 matrix"),
        ("[1, 2]", ":1:1: must be an object with the keys"),
        ({"appearances": []}, "has none of the keys of a camera"),
        ('{"a":' * 100_000, "nested too deeply"),
        ("[" * 100_000, "nested too deeply"),
        ("a: " + "[" * 2_000, "nested too deeply|nested deeper than 20 levels"),
        ("a: !!python/object/apply:os.system [ls]", ":1: is not plain YAML: could not determine a constructor"),
        ("width: 1\nwidth: 2", ":2: is not plain YAML: found duplicate key"),
        ("width: 640\nheight: 480", "camera_matrix: is missing"),
        (ROS.replace("plumb_bob", "equidistant"), ":6: distortion_model: must be"),
        (ROS.replace("image_width: 640", ""), "states no width and height"),
        (ROS.replace("image_width: 640", "image_width: 0"), ":2: camera.width: 0 is not a whole number"),
        (ROS.replace("600, 0, 320", "600, 0"), ":5: camera_matrix: must hold 9 numbers, not 8"),
        (ROS.replace("600, 0, 320", "six, 0, 320"), ":5: camera.K"),
        (ROS.replace("640", "9" * 5000), ":2: holds a whole number of more digits than can be read"),
        (OPENCV_JSON | {"binning_x": 10**4000}, "must be numbers of sensible size"),
        (ROS.replace("0.08, 0.001", "0.08, x"), ":7: camera.dist: must be a list of"),
        ('{"camera_matrix": [1],\n"distortion_model":\n"fisheye"}', ":2: distortion_model: must be"),
        (OPENCV_XML.replace("</opencv_storage>", ""), ":19: is no XML"),
        (
            '<!DOCTYPE a [<!ENTITY b SYSTEM "file:///etc/passwd">]><opencv_storage><camera_matrix>&b;</camera_matrix></opencv_storage>',
            "defines entities, which no calibration needs",
        ),
        ("<robot/>", "is no OpenCV FileStorage: its first element is <robot>, not <opencv_storage>"),
        ("<opencv_storage>" + "<a>" * 100 + "</a>" * 100 + "</opencv_storage>", "nested deeper than 60 levels"),
        ("<opencv_storage/>", "camera_matrix: is missing"),
        (OPENCV_XML.replace("600. 0. 320.", "600. 0."), ":6: camera_matrix: must hold 9 numbers, not 8"),
        (OPENCV_XML.replace("600. 0. 320.", "six 0. 320."), ":6: camera.K: must be a 3x3 matrix of finite numbers"),
        (OPENCV_XML.replace(">640<", ">many<"), ":4: camera.width: 'many' is not a whole number"),
        (OPENCV_XML.replace(">640<", f">{'9' * 5000}<"), ":4: camera.width: inf is not a whole number"),
        (OPENCV_XML.replace("<opencv", "<!DOCTYPE a>\n<opencv", 1), ":2: defines entities, which no calibration needs"),
        ("<opencv_storage>" + " " * 2**20, "must be a calibration of at most 100000 characters"),
        (OPENCV_XML.replace("<image_width>640</image_width>", ""), "states no width and height"),
        (OPENCV_JSON | {"camera_matrix": MATRIX | {"data": [1, 2]}}, "camera_matrix: must hold 9 numbers, not 2"),
        ({"width": 640, "height": 480, "K": [1, 2, 3]}, "K: must be a 3x3 matrix"),
        ("1 FISHEYE 640 480 1 2 3 4", ":1: COLMAP's model must be one of"),
        ("# c\n1 PINHOLE 640 480 600 600 320", ":2: PINHOLE must be followed by"),
    ],
)
def test_what_is_no_camera_is_one_clear_line(tmp_path, content, message):
    path = written(tmp_path, "camera.txt", content)
    with pytest.raises(CameraError, match=message) as caught:
        read_camera(path)
    assert str(caught.value).startswith(str(path))
    assert "\n" not in str(caught.value)
    assert len(str(caught.value)) < 400


def test_files_that_cannot_be_read_are_named(tmp_path):
    with pytest.raises(CameraError, match="cannot be read: No such file"):
        read_camera(tmp_path / "none.json")
    with pytest.raises(CameraError, match="cannot be read"):
        read_camera(tmp_path)
    (tmp_path / "image.png").write_bytes(b"\x89PNG\r\n\x1a\n")
    with pytest.raises(CameraError, match="is no camera: byte 0 is no UTF-8"):
        read_camera(tmp_path / "image.png")
