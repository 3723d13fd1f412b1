"""Good inputs of each kind, small: most are made by the project's own writers, or lie in ``examples``."""

from __future__ import annotations

import json
import struct
import tempfile
from base64 import b64encode
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Sequence

ROOT = Path(__file__).resolve().parents[2]
EXAMPLES = ROOT / "examples"


def example(name: str) -> Sequence[bytes]:
    """One of ``examples/formats``."""
    return [(EXAMPLES / "formats" / name).read_bytes()]


def shipped(file: str) -> Sequence[bytes]:
    """A file of a KB that comes with plogic."""
    return [(ROOT / "kb" / file).read_bytes()]


@cache
def pictures(kind: str) -> Sequence[bytes]:
    """Pictures of 16x12 pixels: of noise, of one colour, grey, and of 16 bits where the kind has such."""
    import cv2

    noise = np.random.default_rng(0).integers(0, 256, (12, 16, 3)).astype(np.uint8)
    grey, flat = noise[:, :, 0], np.full((12, 16, 3), 90, np.uint8)
    ending = {"pnm": ".ppm"}.get(kind, f".{kind}")
    made = [cv2.imencode(ending, image)[1].tobytes() for image in (noise, flat)]
    if kind == "jpg":
        made += [
            cv2.imencode(".jpg", noise, [cv2.IMWRITE_JPEG_PROGRESSIVE, 1])[1].tobytes(),
            cv2.imencode(".jpg", grey)[1].tobytes(),
        ]
        made.append(made[0][:2] + exif() + made[0][2:])
    if kind in ("png", "tiff"):
        made.append(cv2.imencode(ending, noise.astype(np.uint16) * 257)[1].tobytes())
        made.append(cv2.imencode(ending, np.dstack([noise, grey]))[1].tobytes())
    if kind == "webp":
        made.append(cv2.imencode(ending, noise, [cv2.IMWRITE_WEBP_QUALITY, 50])[1].tobytes())
    if kind == "pnm":
        made += [cv2.imencode(".pgm", grey)[1].tobytes(), cv2.imencode(".pbm", grey)[1].tobytes()]
        made += [
            b"P3\n# a comment\n2 2\n255\n0 0 0 1 2 3 4 5 6 255 255 255\n",
            b"P2 2 2 9 0 1 2 9\n",
            b"P1 2 2\n0 1 1 0\n",
        ]
    return made


@cache
def picture_of_the_camera() -> bytes:
    """A grey box on black, of the size of the cameras' pictures."""
    import cv2

    image = np.zeros((480, 640), np.uint8)
    image[180:300, 250:400] = 120
    return bytes(cv2.imencode(".png", image)[1])


def exif() -> bytes:
    """The segment of a JPEG that tells its focal length and its orientation."""
    entries = ((0x0112, 3, 1, 1 << 16), (0x8769, 4, 1, 38))
    inner = ((0xA405, 3, 1, 28 << 16), (0xA002, 4, 1, 16), (0xA003, 4, 1, 12))
    block = b"MM\0*\0\0\0\x08" + _directory(entries) + _directory(inner)
    return b"\xff\xe1" + struct.pack(">H", len(block) + 8) + b"Exif\0\0" + block


def _directory(entries: Sequence[tuple[int, int, int, int]]) -> bytes:
    return struct.pack(">H", len(entries)) + b"".join(struct.pack(">HHII", *entry) for entry in entries) + bytes(4)


def streams() -> Sequence[bytes]:
    """Pictures one after the other."""
    return [first + b"--frame\r\n\r\n" + first for kind in ("jpg", "png", "pnm") for first in pictures(kind)[:1]]


_CODECS = {"avi": "MJPG", "mp4": "mp4v", "mkv": "FFV1"}


@cache
def videos(name: str) -> Sequence[bytes]:
    """Three frames in a container."""
    import cv2

    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, f"x.{name}")
        code = cv2.VideoWriter.fourcc(*_CODECS[name])
        file = cv2.VideoWriter(str(path), cv2.CAP_FFMPEG, code, 10.0, (64, 48))
        for grey in (20, 90, 200):
            file.write(np.full((48, 64, 3), grey, np.uint8))
        file.release()
        return [path.read_bytes()]


# -- cameras -----------------------------------------------------------------------------------------------------------

_K = [600.0, 0.0, 320.0, 0.0, 600.0, 240.0, 0.0, 0.0, 1.0]
_D = [0.1, -0.2, 0.001, 0.002, 0.0]
_ROS = """image_width: 640
image_height: 480
camera_name: front
camera_matrix: {rows: 3, cols: 3, data: [600, 0, 320, 0, 590, 240, 0, 0, 1]}
distortion_model: plumb_bob
distortion_coefficients:
  rows: 1
  cols: 5
  data: [0.1, -0.2, 0.001, 0.002, 0]
rectification_matrix: {rows: 3, cols: 3, data: [1, 0, 0, 0, 1, 0, 0, 0, 1]}
projection_matrix: {rows: 3, cols: 4, data: [600, 0, 320, 0, 0, 590, 240, 0, 0, 0, 1, 0]}
"""
_TOPIC = """header: {seq: 0, stamp: {secs: 1, nsecs: 2}, frame_id: camera}
height: 480
width: 640
distortion_model: plumb_bob
D: [0.1, -0.2, 0.001, 0.002, 0.0]
K: [600.0, 0.0, 320.0, 0.0, 590.0, 240.0, 0.0, 0.0, 1.0]
---
"""
_COLMAP = """# Camera list
1 PINHOLE 640 480 600 590 320.5 240.5
2 SIMPLE_RADIAL 640 480 600 320 240 0.1
3 OPENCV 640 480 600 590 320 240 0.1 -0.2 0.001 0.002
"""


@cache
def camera(kind: str) -> Sequence[bytes]:
    """Camera files of one format."""
    import cv2

    if kind == "json":
        flat = {"width": 640, "height": 480, "K": _K, "dist": _D}
        return [*example("camera.json"), json.dumps(flat).encode(), json.dumps({"camera": flat}).encode()]
    if kind == "bop":
        scene = {
            str(i): {"cam_K": _K, "depth_scale": 0.1, "cam_R_w2c": [1, 0, 0, 0, 1, 0, 0, 0, 1], "cam_t_w2c": [0, 0, 9]}
            for i in range(1)
        }
        alone = {"fx": 600.0, "fy": 600.0, "cx": 320.0, "cy": 240.0, "width": 640, "height": 480, "depth_scale": 1.0}
        return [json.dumps(scene).encode(), json.dumps(alone).encode()]
    if kind == "ros":
        return [_ROS.encode(), _TOPIC.encode()]
    if kind == "colmap":
        return [_COLMAP.encode()]
    if kind == "colmap-bin":
        rows = ((1, 1, (600.0, 590.0, 320.0, 240.0)), (2, 0, (600.0, 320.0, 240.0)))
        packed = [struct.pack(f"<IiQQ{len(p)}d", number, model, 640, 480, *p) for number, model, p in rows]
        return [struct.pack("<Q", len(packed[:n])) + b"".join(packed[:n]) for n in (1, 2)]
    ending = {"opencv": ".yml", "xml": ".xml", "opencv-json": ".json"}[kind]
    storage = cv2.FileStorage(ending, cv2.FILE_STORAGE_WRITE | cv2.FILE_STORAGE_MEMORY)
    storage.write("image_width", 640)
    storage.write("image_height", 480)
    storage.write("camera_matrix", np.array(_K).reshape(3, 3))
    storage.write("distortion_coefficients", np.array([_D]))
    return [storage.releaseAndGetString().encode()]


# -- knowledge ---------------------------------------------------------------------------------------------------------


@cache
def meshes(kind: str) -> Sequence[bytes]:
    """A box, as trimesh writes it; of OBJ and PLY as text one with colours or texture coordinates, too."""
    import trimesh

    box = trimesh.creation.box((0.3, 0.2, 0.1))
    made = box.export(file_type=kind)
    if kind == "gltf":
        tree = json.loads(next(data for name, data in made.items() if name.endswith(".gltf")))
        for buffer in tree["buffers"]:
            buffer["uri"] = "data:application/octet-stream;base64," + b64encode(made[buffer["uri"]]).decode()
        return [json.dumps(tree).encode()]
    found = [made.encode() if isinstance(made, str) else made]
    if kind == "ply":
        found = [box.export(file_type="ply", encoding="ascii"), *found]
    if kind == "obj":
        found.append(
            b"mtllib m.mtl\nusemtl red\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\nvn 0 0 1\nf 1/1/1 2/2/1 3/3/1\nf 1 2 3\n"
        )
    if kind == "stl":
        found.append(
            b"solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\nendsolid a\n"
        )
    return found


@cache
def clouds() -> Sequence[bytes]:
    """A learned cloud of four features and six appearances, which is that of no object."""
    from kb.clouds.learned import LearnedCloud, cloud_bytes

    rng = np.random.default_rng(0)
    axis = rng.normal(size=(6, 3))
    axis /= np.linalg.norm(axis, axis=1, keepdims=True)
    up = np.cross(axis, [0.0, 0.0, 1.0])
    up /= np.linalg.norm(up, axis=1, keepdims=True)
    cloud = LearnedCloud(
        at=rng.uniform(-0.1, 0.1, (4, 3)),
        sigma=np.full(4, 1e-3),
        normal=axis[:4],
        word=np.array([0, 1, 2, 0]),
        feature=np.array([0, 1, 2, 2, 3, 3]),
        lobe_word=np.array([0, 1, 2, 0, 0, 1]),
        descriptor=rng.integers(0, 256, (6, 128), np.uint8),
        axis=axis,
        half_angle=np.full(6, 0.4),
        r_min=np.full(6, 0.3),
        r_max=np.full(6, 2.0),
        hit=np.full(6, 0.6),
        up=up,
        size=np.full(6, 0.01),
    )
    return [cloud_bytes(cloud)]


def points() -> Sequence[bytes]:
    """Correspondences as YAML."""
    return [b"units: mm\npoints:\n- [10, 20, 0, 0, 0]\n- {pixel: [30, 40.5], at: [100, 0, 0]}\n- [1, 2, 3, 4, 5]\n"]


def point_rows() -> Sequence[bytes]:
    """Correspondences as a table."""
    return [b"u,v,x,y,z\n10,20,0,0,0\n30,40.5,0.1,0,0 # a corner\n1;2;3;4;5\n"]


def moves() -> Sequence[bytes]:
    """Moves from the present camera, and in the world."""
    document = json.loads(example("moves.json")[0])
    return [json.dumps(document | {"moves": some}).encode() for some in (document["moves"][:1], document["moves"])]


def trajectory() -> Sequence[bytes]:
    """A trajectory of the TUM format."""
    return [b"# time x y z qx qy qz qw\n1.5 0 0 1 0 0 0 1\n2.5 0.1 0 1 0 0 0.7071 0.7071\ngamma.json 1 2 3 0 1 0 0\n"]


@cache
def log() -> Sequence[bytes]:
    """A batch's lines: the mutated one stands alone."""
    return [json.dumps(json.loads(example("frame.json")[0])).encode() + b"\n"]


# -- logic -------------------------------------------------------------------------------------------------------------


def programs() -> Sequence[bytes]:
    """The corpus of the tests, and two of the examples."""
    files = sorted((ROOT / "tests" / "logic" / "programs").rglob("*.pl"))
    return [path.read_bytes() for path in (EXAMPLES / "alarm.pl", EXAMPLES / "rules.pl", *files)]


def rules() -> Sequence[bytes]:
    """Rules of an author."""
    return [
        (EXAMPLES / "rules.pl").read_bytes(),
        b"0.3::odd(H) :- present(H), object(H, box).\npair(X, Y) :- present(X), present(Y), X \\== Y.\n",
        b"tall(H) :- findall(F, expected(H, F), L), length(L, N), N > 3.\n",
    ]


def goals() -> Sequence[bytes]:
    """What may be asked of an interpretation."""
    return [
        b"present(h1)", b"partially_occludes(X, Y)", b"object(H, Type)", b"cause(A, H, F)", b"\\+ present(h1)", b"noise(A)",
        b"present(h1), case(h1, F, 'AC')", b"(present(h1) ; noise(a1))", b"ev(H, V)", b"part(P, H)", b"left_of(X, Y)",
        b"expected(h1, 'top_sw')", b"why(h1, F, C)", b"findall(H, present(H), L)", b"behind(X, Y), X \\== Y",
    ]  # fmt: skip


def evidence() -> Sequence[bytes]:
    """Lines of evidence."""
    return [b"object(h1, box)\n", b"present(h1)\n\\+ noise(a1)\n", b"cause(a1, h1, F)\n"]


# -- others' formats ---------------------------------------------------------------------------------------------------

_EYE = [1.0, 0, 0, 0, 1.0, 0, 0, 0, 1]
_BOP: dict[str, Any] = {
    "test/000001/scene_camera.json": {"0": {"cam_K": [20.0, 0, 8, 0, 20.0, 6, 0, 0, 1], "depth_scale": 1.0}},
    "test/000001/scene_gt.json": {"0": [{"obj_id": 1, "cam_R_m2c": _EYE, "cam_t_m2c": [0, 0, 1000.0]}]},
    "test/000001/scene_gt_info.json": {"0": [{"visib_fract": 0.9, "px_count_all": 12, "bbox_obj": [1, 2, 3, 4]}]},
    "test_targets_bop19.json": [{"scene_id": 1, "im_id": 0, "obj_id": 1, "inst_count": 1}],
}


def bop(file: str) -> Sequence[bytes]:
    """One of the JSON files of a BOP dataset."""
    return [json.dumps(_BOP[file]).encode()]


def bop_dataset(folder: Path) -> None:
    """A BOP dataset of one picture."""
    for file, document in _BOP.items():
        place = folder / "dataset" / file
        place.parent.mkdir(parents=True, exist_ok=True)
        place.write_text(json.dumps(document), encoding="utf-8")
    picture = folder / "dataset" / "test" / "000001" / "rgb" / "000000.png"
    picture.parent.mkdir(exist_ok=True)
    picture.write_bytes(pictures("png")[0])


def bop_models_info() -> Sequence[bytes]:
    """Two models, with every kind of symmetry."""
    turn = [-1.0, 0, 0, 0, 0, -1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]
    rows = {"1": {"diameter": 374.0, "name": "box", "symmetries_discrete": [turn]}}
    rows |= {"2": {"diameter": 374.0, "symmetries_continuous": [{"axis": [0, 0, 1], "offset": [0, 0, 0]}]}}
    return [json.dumps(rows).encode()]


def bop_models(folder: Path) -> None:
    """Their meshes."""
    (folder / "models").mkdir()
    for number in (1, 2):
        (folder / "models" / f"obj_{number:06d}.ply").write_bytes(meshes("ply")[0])


def robot_mesh(folder: Path) -> None:
    """What a robot's description names."""
    (folder / "box.obj").write_bytes(meshes("obj")[0])


def urdf() -> Sequence[bytes]:
    """Two links and a joint."""
    return [
        (
            b'<?xml version="1.0"?><robot name="r"><material name="red"><color rgba="1 0 0 1"/></material><link name="base"><visual>'
            b'<origin xyz="0 0 1" rpy="0 0 0"/><geometry><mesh filename="package://r/box.obj" scale="1 1 1"/></geometry><material name="red"/>'
            b'</visual></link><link name="tip"><visual><geometry><box size="1 2 3"/></geometry></visual><visual><geometry>'
            b'<cylinder radius="0.1" length="2"/></geometry></visual></link><joint name="j" type="revolute"><parent link="base"/>'
            b'<child link="tip"/><origin xyz="1 0 0" rpy="0 1.57 0"/><axis xyz="0 0 1"/></joint></robot>'
        )
    ]


def sdf() -> Sequence[bytes]:
    """A model of two links."""
    return [
        (
            b'<sdf version="1.6"><world name="w"><model name="m"><pose>0 0 5 0 0 0</pose><link name="l"><pose>1 0 0 0 0 1.57</pose>'
            b'<visual name="v"><geometry><mesh><scale>1 2 3</scale><uri>model://m/box.obj</uri></mesh></geometry></visual></link>'
            b'<link name="k"><visual name="s"><geometry><sphere><radius>0.5</radius></sphere></geometry></visual></link></model></world></sdf>'
        )
    ]
