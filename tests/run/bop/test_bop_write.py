"""Simulated scenes as a BOP dataset, read back."""

import json
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest
import trimesh
from results_reader import read_results

from geometry.camera import Camera
from geometry.frames import from_rotation_translation, inverse, look_at, rotation_from_quat_xyzw
from geometry.visibility.rays import RayMesh
from plogic.base.errors import InputError
from plogic.face.commands.bop import bop_command
from plogic.face.commands.simulate import Wanted, simulate_command
from plogic.face.shown.options import Scoring
from plogic.run.bop.dataset import open_dataset
from plogic.run.bop.models import read_models
from plogic.run.bop.recalls import View, score
from plogic.run.bop.results_file import Estimate, results_text
from plogic.run.bop.write import Kind, box_of, diameter, gt_info, model_info, silhouette, write_dataset
from sensing.errors import SensingError
from sensing.simulated.body import Body, TexturedMesh
from sensing.simulated.camera import Sensor
from sensing.simulated.scene import Scene, box, default_camera
from sensing.simulated.surroundings import Light, Surroundings


def turn(degrees, t=(0, 0, 0)):
    half = np.radians(degrees) / 2
    return from_rotation_translation(rotation_from_quat_xyzw((0, 0, np.sin(half), np.cos(half))), t)


def kinds():
    rng = np.random.default_rng(0)
    half = np.array([np.eye(4), turn(180)])
    return [
        Kind(
            "crate",
            TexturedMesh(*unwrapped((0.4, 0.2, 0.3)), texture=rng.integers(0, 255, (64, 64, 3)).astype(np.uint8)),
            half,
        ),
        Kind("brick", box(np.array([0.3, 0.3, 0.6]), rng, painted=False)),
    ]


def unwrapped(size):
    """Vertices, triangles and texture coordinates of a box, each face the whole texture."""
    mesh = trimesh.creation.box(size)
    corners = np.asarray(mesh.vertices)[np.asarray(mesh.faces)].reshape(-1, 3)
    return corners, np.arange(len(corners)).reshape(-1, 3), np.tile([[0.0, 0], [1, 0], [1, 1]], (len(corners) // 3, 1))


def scene(placed, away=2.0, camera=None):
    """Bodies as placed, seen from ``away`` m along x and a bit from above."""
    view = replace(camera or default_camera(), world_from_camera=inverse(look_at((away, 0, 0.6), (0, 0, 0.2))))
    bodies = tuple(Body(label, mesh, pose) for label, mesh, pose in placed)
    return Scene(bodies, view, Light(), Surroundings(), Sensor(), (1.0,) * len(bodies))


def scenes():
    crate, brick = (kind.mesh for kind in kinds())
    first = [
        ("crate", crate, turn(20, (0, -0.4, 0.15))),
        ("brick", brick, turn(0, (0, 0.3, 0.3))),
        (None, brick, turn(0, (0.5, 0.35, 0.1))),
    ]
    return [
        scene(first),
        scene([("brick", brick, turn(30, (0, 0, 0.3))), ("brick", brick, turn(70, (-0.6, 0.2, 0.3)))], away=7.5),
    ]


@pytest.fixture(scope="module")
def written(tmp_path_factory):
    folder = tmp_path_factory.mktemp("bop") / "new" / "simulated"
    write_dataset(scenes(), kinds(), folder, supersample=1)
    return folder


def document(written, name):
    return json.loads((written / name).read_text())


def test_every_file_is_there(written):
    names = sorted(str(p.relative_to(written)) for p in written.rglob("*") if p.is_file())
    masks = [
        f"test/000001/{kind}/{im:06d}_{i:06d}.png" for kind in ("mask", "mask_visib") for im in (0, 1) for i in (0, 1)
    ]
    pictures = [f"test/000001/{kind}/{im:06d}.png" for kind in ("rgb", "depth") for im in (0, 1)]
    listed = [f"test/000001/{name}.json" for name in ("scene_camera", "scene_gt", "scene_gt_info")]
    model = [f"models/{name}" for name in ("obj_000001.ply", "obj_000001.png", "obj_000002.ply", "models_info.json")]
    painted = ["models/obj_000002.png"] if kinds()[1].mesh.texture is not None else []
    assert names == sorted(
        [*masks, *pictures, *listed, *model, *painted, "camera.json", "ids.json", "test_targets_bop19.json"]
    )
    assert not list(written.parent.glob(".*"))


def test_the_truth_scores_one(written, tmp_path):
    """Read back as any dataset is, its ground truth through a results file as estimates."""
    opened = open_dataset(written)
    names, wrong = opened.listed()
    assert (names, wrong) == ([(1, 0), (1, 1)], [])
    views, rows = [], []
    for scene_id, im_id in names:
        truths = opened.scene(scene_id).truths(im_id)
        rows += [Estimate(scene_id, im_id, t.obj_id, 1.0, t.camera_from_object) for t in truths]
        views.append((truths, opened.scene(scene_id).frame(im_id).camera, opened.targets[scene_id, im_id]))
    (tmp_path / "r.csv").write_text(results_text(rows))
    back = read_results(tmp_path / "r.csv")
    models = read_models(opened.models, (1, 2))
    scores = score([View(t, tuple(e for e in back if e.im_id == i), c, w) for i, (t, c, w) in enumerate(views)], models)
    assert (scores.together.targets, scores.together.mean_of_the_two, scores.together.add) == (4, 1.0, 1.0)


def test_poses_are_the_scenes(written):
    made = scenes()
    assert len(made) > 1
    for im_id, one in enumerate(made):
        truths = open_dataset(written).scene(1).truths(im_id)
        labelled = [pose for pose, body in zip(one.camera_from_bodies, one.bodies, strict=True) if body.label]
        assert [t.camera_from_object for t in truths] == [pytest.approx(pose, abs=1e-12) for pose in labelled]
        frame = open_dataset(written).scene(1).frame(im_id)
        assert frame.camera.world_from_camera == pytest.approx(one.camera.world_from_camera, abs=1e-12)
        assert frame.camera.K.tolist() == one.camera.K.tolist()
        assert (frame.image == one.photograph(1).image).all()


def test_depth_is_millimetres_by_its_scale(written):
    """The nearest body of the second image stands beyond what 0.1 mm reach."""
    entries = document(written, "test/000001/scene_camera.json")
    assert [entries[str(i)]["depth_scale"] for i in (0, 1)] == [0.1, 1.0]
    for im_id, one in enumerate(scenes()):
        steps = cv2.imread(str(written / f"test/000001/depth/{im_id:06d}.png"), cv2.IMREAD_UNCHANGED)
        rendered = one.photograph(1)
        seen = rendered.segmentation >= 0
        scale = entries[str(im_id)]["depth_scale"]
        assert steps.dtype == np.uint16
        assert np.abs(steps[seen] * scale / 1000 - rendered.depth[seen]).max() <= scale / 1000
        assert (steps[~np.isfinite(rendered.depth)] == 0).all()
        assert seen.any()


def test_masks_boxes_and_fractions(written):
    infos, folder = document(written, "test/000001/scene_gt_info.json"), written / "test/000001"
    for im_id, rows in infos.items():
        for i, info in enumerate(rows):
            name = f"{int(im_id):06d}_{i:06d}.png"
            whole, visible = (
                cv2.imread(str(folder / kind / name), cv2.IMREAD_UNCHANGED) > 0 for kind in ("mask", "mask_visib")
            )
            assert not (visible & ~whole).any()
            assert (info["px_count_all"], info["px_count_visib"]) == (whole.sum(), visible.sum())
            assert info["visib_fract"] == pytest.approx(visible.sum() / whole.sum())
            v, u = np.nonzero(visible)
            assert info["bbox_visib"] == [u.min(), v.min(), np.ptp(u), np.ptp(v)]
            v, u = np.nonzero(whole)
            assert np.abs(np.array(info["bbox_obj"]) - [u.min(), v.min(), np.ptp(u), np.ptp(v)]).max() <= 1
    fractions = [info["visib_fract"] for info in infos["0"]]
    assert fractions[0] > 0.97
    assert 0.3 < fractions[1] < 0.95, "the decoy stands before it, and is annotated nowhere"


def test_targets_name_what_is_visible(written):
    assert document(written, "test_targets_bop19.json") == [
        {"im_id": 0, "inst_count": 1, "obj_id": 1, "scene_id": 1},
        {"im_id": 0, "inst_count": 1, "obj_id": 2, "scene_id": 1},
        {"im_id": 1, "inst_count": 2, "obj_id": 2, "scene_id": 1},
    ]
    assert document(written, "ids.json") == {"crate": 1, "brick": 2}


def test_models_are_millimetres(written):
    infos = document(written, "models/models_info.json")
    assert infos["1"]["diameter"] == pytest.approx(1000 * np.sqrt(0.4**2 + 0.2**2 + 0.3**2))
    assert [infos["1"][key] for key in ("min_x", "size_y", "size_z")] == pytest.approx([-200, 200, 300])
    assert infos["1"]["symmetries_discrete"] == [pytest.approx(turn(180).ravel(), abs=1e-9)]
    assert "symmetries_discrete" not in infos["2"]
    models = read_models(written / "models", (1, 2))
    assert models[1].symmetric
    for i, kind in enumerate(kinds(), 1):
        assert models[i].points == pytest.approx(kind.mesh.vertices, abs=1e-6)
    mesh = trimesh.load(written / "models/obj_000001.ply", process=False)
    assert len(mesh.faces) == 12
    assert (np.einsum("ti,ti->t", mesh.vertex_normals[::3], mesh.face_normals) > 0.99).all()
    assert b"comment TextureFile obj_000001.png" in (written / "models/obj_000001.ply").read_bytes()[:200]


def test_a_symmetry_of_any_turn_is_continuous():
    group = np.array([turn(5 * i) for i in range(72)])
    (entry,) = model_info(Kind("can", kinds()[1].mesh, group))["symmetries_continuous"]
    assert (entry["axis"], entry["offset"]) == (pytest.approx([0, 0, 1], abs=1e-9), [0, 0, 0])
    few = model_info(Kind("can", kinds()[1].mesh, group[::18]))
    assert len(few["symmetries_discrete"]) == 3


def test_symmetries_beside_the_origin_are_millimetres():
    group = np.array([np.eye(4), turn(180, (0.2, 0, 0))])
    assert model_info(Kind("x", kinds()[1].mesh, group))["symmetries_discrete"][0][3] == pytest.approx(200)


def test_a_flat_model_has_a_diameter():
    assert diameter(np.array([[0.0, 0, 0], [3, 0, 0], [3, 4, 0], [0, 4, 0]])) == pytest.approx(5)


CAMERA = Camera(100, 80, np.array([[100.0, 0, 50], [0, 100, 40], [0, 0, 1]]))
PLATE = RayMesh([[-0.1, -0.1, 0], [0.1, -0.1, 0], [0.1, 0.1, 0], [-0.1, 0.1, 0]], [[0, 1, 2], [0, 2, 3]])


def at(x, z):
    return from_rotation_translation(np.eye(3), (x, 0, z))


def test_a_silhouette_by_hand():
    """A plate of 0.2 m at 0.995 m: 20.1 px, from column 40 to 60 and from row 30 to 50."""
    whole = silhouette(PLATE, at(0, 0.995), CAMERA)
    assert (whole.pixels, whole.box, whole.mask.sum()) == (21 * 21, [40, 30, 20, 20], 21 * 21)
    v, u = np.nonzero(whole.mask)
    assert box_of(u, v) == whole.box


def test_what_the_border_cuts_off_is_hidden():
    """Its middle at column 0: eleven of its 21 columns are in the image."""
    whole = silhouette(PLATE, at(-0.5 * 0.995, 0.995), CAMERA)
    assert (whole.pixels, whole.mask.sum(), whole.box) == (441, 11 * 21, [-10, 30, 20, 20])
    info = gt_info(whole, whole.mask, np.zeros_like(whole.mask))
    assert (info["visib_fract"], info["px_count_valid"]) == (pytest.approx(11 / 21), 0)


def test_behind_the_camera_is_nothing():
    whole = silhouette(PLATE, at(0, -1), CAMERA)
    info = gt_info(whole, whole.mask, whole.mask)
    assert (whole.pixels, info["visib_fract"], info["bbox_obj"], info["bbox_visib"]) == (0, 0.0, [-1] * 4, [-1] * 4)


def test_nothing_is_left_of_a_dataset_that_failed(tmp_path):
    stranger = scene([("ghost", kinds()[0].mesh, turn(0, (0, 0, 0.15)))])
    with pytest.raises(InputError, match="body 'ghost': is none of the dataset's models: crate, brick"):
        write_dataset([scenes()[0], stranger], kinds(), tmp_path / "d", supersample=1)
    with pytest.raises(InputError, match="needs a scene"):
        write_dataset([], kinds(), tmp_path / "d")
    assert list(tmp_path.iterdir()) == []
    (tmp_path / "full").mkdir()
    (tmp_path / "full" / "x").touch()
    with pytest.raises(SensingError, match="not an empty folder"):
        write_dataset(scenes(), kinds(), tmp_path / "full")


def test_simulate_writes_a_dataset_that_bop_perceives(tmp_path):
    """The towers, simulated, as BOP, through the KB's own perceiver: both images' towers are found."""
    simulate_command("towers", Wanted(1), 3, tmp_path / "s", say=[].append, bop=tmp_path / "d", bop_images=2)
    assert sorted(p.name for p in (tmp_path / "s").iterdir()) == ["camera.json", "image.png", "truth.json"]
    same = [cv2.imread(str(path)) for path in (tmp_path / "s/image.png", tmp_path / "d/test/000001/rgb/000000.png")]
    assert (same[0] == same[1]).all()
    options = Scoring(as_json=True)  # its ids.json is taken as it lies there
    text = bop_command(
        str(tmp_path / "d"), "towers", str(tmp_path / "r.csv"), options, say=lambda _: None, write=lambda _: None
    )
    row = json.loads(text)["scores"]["recalls"][0]
    assert (row["targets"], row["AR_MSSD"] > 0.8, row["ADD(-S) recall"]) == (2, True, 1.0)


def test_simulate_wants_two_folders(tmp_path):
    for bop in (tmp_path / "s", tmp_path / "s/d", tmp_path):
        with pytest.raises(InputError, match="is named for two outputs"):
            simulate_command("towers", Wanted(1), 0, tmp_path / "s", say=[].append, bop=Path(bop))
    assert list(tmp_path.iterdir()) == []
