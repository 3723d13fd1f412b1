"""``kb import`` through the console script: URDF, SDF and BOP."""

from __future__ import annotations

import json

import numpy as np
import pytest
from console import bytes_in, document, good, plogic
from made_meshes import write_box, write_painted

from kb.files.read import read_kb

URDF = """<?xml version="0.0" ?>
<robot name="arm">
  <material name="red"><color rgba="1 0 0 1"/></material>
  <link name="base"><visual><origin xyz="0 0 1"/><geometry><mesh filename="package://arm/box.obj" scale="0.1 0.1 0.2"/></geometry></visual></link>
  <link name="tip"><visual><geometry><box size="1 2 3"/></geometry><material name="red"/></visual></link>
  <joint name="j" type="revolute"><parent link="base"/><child link="tip"/><origin xyz="10 0 0" rpy="0 0 1.5707963267948966"/></joint>
</robot>
"""
SDF = """<sdf version="1.6"><world name="w"><model name="m"><pose>0 0 5 0 0 0</pose><link name="l"><pose>1 0 0 0 0 1.5707963267948966</pose>
<visual name="v"><geometry><mesh><scale>1 2 3</scale><uri>model://thing/box.obj</uri></mesh></geometry></visual></link></model></world></sdf>
"""


@pytest.fixture
def folder(tmp_path):
    """A new knowledge base."""
    good("kb", "new", tmp_path / "kb")
    return tmp_path / "kb"


def refused(folder, source):
    """The one line on stderr of an import that must fail and write nothing."""
    before = bytes_in(folder)
    done = plogic("kb", "import", source, "--kb", folder)
    assert (done.returncode, done.stdout) == (1, "")
    assert bytes_in(folder) == before
    (line,) = done.stderr.splitlines()
    return line


def bounds(kind):
    return np.array([kind.surface.vertices.min(axis=0), kind.surface.vertices.max(axis=0)])


def test_a_urdf_is_one_type_in_its_zero_pose(tmp_path, folder):
    write_box(tmp_path / "box.obj")
    (tmp_path / "arm.urdf").write_text(URDF)
    good("kb", "import", tmp_path / "arm.urdf", "--kb", folder)
    (arm,) = read_kb(folder).types
    assert arm.name == "arm"
    assert bounds(arm) == pytest.approx(np.array([[0, -0.5, -1.5], [11, 0.5, 1.5]]))
    assert arm.surface.volume == pytest.approx(6 + 0.002)


def test_links_are_parts_of_their_names(tmp_path, folder):
    """Two that hang together are one part with both names; what a name of a part may not hold is replaced."""
    boxes = {"base": 0, "tip/2": 3, "true": 6, "lid": 7}  # the last two share a side
    links = "".join(
        f'<link name="{name}"><visual><origin xyz="{x} 0 0"/><geometry><box size="1 1 1"/></geometry></visual></link>'
        for name, x in boxes.items()
    )
    (tmp_path / "robot.urdf").write_text(f'<robot name="r">{links}</robot>')
    said = good("kb", "import", tmp_path / "robot.urdf", "--kb", folder)
    assert said.count("note: ") == 1
    assert "note: the links true, lid are one part: their shapes touch" in said
    (kind,) = read_kb(folder).types
    places = {node: data["at"][0] for node, data in kind.tree.graph.nodes(data=True) if node}
    assert places == {"base": 0.0, "tip_2": 3.0, "true+lid": 6.5}


def test_joints_that_move_are_said_to_be_frozen_in_the_first_line(tmp_path, folder):
    write_box(tmp_path / "box.obj")
    (tmp_path / "arm.urdf").write_text(URDF)
    first = good("kb", "import", tmp_path / "arm.urdf", "--kb", folder).splitlines()[0]
    assert first.startswith(
        "note: 1 joint that moves is frozen in the zero pose (j), and the type is found in that pose"
    )
    still = URDF.replace("revolute", "fixed").replace("10 0 0", "1 0 0")
    (tmp_path / "still.urdf").write_text(still)
    assert "frozen" not in good("kb", "import", tmp_path / "still.urdf", "--kb", folder)


def test_an_unusual_size_is_doubted_with_the_likely_unit(tmp_path, folder):
    """A description is in metres; this one's mesh was drawn in millimetres."""
    write_box(tmp_path / "box.obj", (190, 80, 60))
    (tmp_path / "box.urdf").write_text(
        '<robot name="r"><link name="l"><visual><geometry><mesh filename="box.obj"/></geometry></visual></link></robot>'
    )
    lines = good("kb", "import", tmp_path / "box.urdf", "--kb", folder).splitlines()
    assert lines[0] == "note: the type is 190 m across; if the mesh is in millimetres: --units mm"


def test_an_sdf_with_poses_and_scales(tmp_path, folder):
    (tmp_path / "thing").mkdir()
    write_box(tmp_path / "thing" / "box.obj")
    (tmp_path / "thing" / "model.sdf").write_text(SDF)
    assert (
        document("kb", "import", tmp_path / "thing" / "model.sdf", "--kb", folder, "--json")["format"] == "kb_import/1"
    )
    (thing,) = read_kb(folder).types
    assert thing.name == "thing"
    assert bounds(thing) == pytest.approx(np.array([[-1, 0, 5], [1, 1, 8]]))


def test_every_mesh_that_is_not_there_is_told_and_nothing_is_written(tmp_path, folder):
    """Two of three meshes are missing, and one is no mesh: each with its link, and none goes unsaid."""
    write_box(tmp_path / "box.obj")
    (tmp_path / "torn.obj").write_text("no mesh")
    files = {"base": "box.obj", "arm": "package://robot/arm.obj", "hand": "meshes/hand.stl", "tool": "torn.obj"}
    links = "".join(
        f'<link name="{link}"><visual><geometry><mesh filename="{file}"/></geometry></visual></link>'
        for link, file in files.items()
    )
    (tmp_path / "robot.urdf").write_text(f'<robot name="r">{links}</robot>')
    before = bytes_in(folder)
    done = plogic("kb", "import", tmp_path / "robot.urdf", "--kb", folder)
    assert (done.returncode, done.stdout, bytes_in(folder)) == (1, "", before)
    arm, hand, tool = done.stderr.splitlines()
    start = f"plogic: {tmp_path / 'robot.urdf'}: link "
    assert arm.startswith(f"{start}'arm': the mesh 'package://robot/arm.obj' is missing")
    assert hand.startswith(f"{start}'hand': the mesh 'meshes/hand.stl' is missing")
    assert tool.startswith(f"{start}'tool': {tmp_path / 'torn.obj'}: ")
    assert all(line.endswith("or take the visual out") for line in (arm, hand, tool))


def shape(file):
    return (
        f'<robot name="r"><link name="l"><visual><geometry><mesh filename="{file}"/></geometry></visual></link></robot>'
    )


def test_what_is_copied_from_elsewhere_is_said(tmp_path, folder):
    """A package with its descriptions, meshes and pictures in folders side by side."""
    for name in ("urdf", "meshes/visual", "textures"):
        (tmp_path / "robot" / name).mkdir(parents=True)
    mesh = write_painted(tmp_path / "robot/meshes/visual").rename(tmp_path / "robot/meshes/visual/arm.obj")
    (mesh.parent / "paint.png").rename(tmp_path / "robot/textures/paint.png")
    (mesh.parent / "box.mtl").write_text("newmtl paint\nmap_Kd ../../textures/paint.png\n")
    (tmp_path / "robot/urdf/arm.urdf").write_text(shape("../meshes/visual/arm.obj"))
    lines = good("kb", "import", tmp_path / "robot/urdf/arm.urdf", "--kb", folder).splitlines()
    assert lines[0] == f"note: copied from outside of {tmp_path}/robot/urdf: {tmp_path}/robot/meshes/visual/arm.obj"
    assert lines[1] == f"note: copied from outside of {mesh.parent}: {tmp_path}/robot/textures/paint.png"
    (tmp_path / "robot/urdf/near.urdf").write_text(shape("package://robot/meshes/visual/arm.obj"))
    assert f"note: copied from outside of {tmp_path}/robot/urdf" in good(
        "kb", "import", tmp_path / "robot/urdf/near.urdf", "--kb", folder
    )


@pytest.mark.parametrize(
    "name", ["/{}/box.obj", "file:///{}/box.obj", "~/box.obj", "../../../../../../../../../../{}/box.obj", "out.obj"]
)
def test_no_mesh_is_read_by_an_absolute_path_or_far_from_the_description(tmp_path, folder, monkeypatch, name):
    monkeypatch.setenv("HOME", str(tmp_path))
    (tmp_path / "robot").mkdir()
    write_box(tmp_path / "box.obj")
    (tmp_path / "robot/out.obj").symlink_to(tmp_path / "box.obj")
    (tmp_path / "robot/bad.urdf").write_text(shape(name.format(str(tmp_path)[1:])))
    said = "is an absolute path" if name[0] in "/f~" else "is missing or no plain file"
    line = refused(folder, tmp_path / "robot/bad.urdf")
    assert said in line
    assert line.endswith("or take the visual out")


BAD = {
    "no xml": ("<robot", "is no XML"),
    "another": ("<mujoco/>", "is no URDF"),
    "entities": ('<!DOCTYPE x [<!ENTITY a "b">]><robot/>', "defines entities"),
    "no shapes": ("<robot/>", "holds no visible shape"),
    "no mesh": (
        URDF.replace("box.obj", "gone.obj").replace('<box size="1 2 3"/>', ""),
        "the mesh 'package://arm/gone.obj' is missing",
    ),
    "no number": (URDF.replace("10 0 0", "10 nan 0"), "xyz: must be 3 finite numbers below 1e+09, not '10 nan 0'"),
    "no link": (URDF.replace('<child link="tip"', '<child link="top"'), "its child 'top' is no link"),
    "circle": (
        URDF.replace("</robot>", '<joint name="k"><parent link="tip"/><child link="base"/></joint></robot>'),
        "run in a circle",
    ),
    "flat": (URDF.replace("1 2 3", "1 0 3"), "sizes of a box must be above 0"),
}


@pytest.mark.parametrize("case", BAD)
def test_a_bad_urdf_writes_nothing(tmp_path, folder, case):
    content, said = BAD[case]
    (tmp_path / "bad.urdf").write_text(content)
    line = refused(folder, tmp_path / "bad.urdf")
    assert line.startswith(f"plogic: {tmp_path / 'bad.urdf'}: ")
    assert said in line


SHAPE = '<link name="a">\n  <visual>{}</visual>\n</link>'
BOX = '<geometry><box size="1 1 1"/></geometry>'
FILLED = " is for xacro or roslaunch to fill in: "
BY_PACKAGE = f"{FILLED}write package://my_arm in its place, for no absolute path, as they would write, is read"
BY_XACRO = f"{FILLED}run xacro first, and import what it writes: xacro arm.urdf > arm_filled.urdf"
TEMPLATES = {
    "find": (
        '<geometry><mesh filename="$(find my_arm)/base.stl"/></geometry>',
        f"3:37: $(find my_arm){BY_PACKAGE}",
    ),
    "file and find": (
        '<geometry><mesh filename="file://$(find my_arm)/base.stl"/></geometry>',
        f"3:37: file://$(find my_arm){BY_PACKAGE}",
    ),
    "optenv": (
        f'<!-- $(env A) -->\n<origin\n xyz="0 0 $(optenv HEIGHT 0.1)"/>{BOX}',
        f"5:11: $(optenv HEIGHT 0.1){BY_XACRO}",
    ),
    "expression": (
        '<origin xyz="0 0 0"/><geometry><box size="1 ${2 * w} 1"/></geometry>',
        f"3:55: ${{2 * w}}{BY_XACRO}",
    ),
    "macro": (f'{BOX}<xacro:wheel side="left"/>', f"3:51: <xacro:wheel>{BY_XACRO}"),
}


@pytest.mark.parametrize("case", TEMPLATES)
def test_a_template_is_told_where_it_is_one_and_what_to_do(tmp_path, folder, case):
    visual, said = TEMPLATES[case]
    text = f'<?xml version="1.0"?><robot name="ü">\n{SHAPE.format(visual)}\n</robot>'
    (tmp_path / "arm.urdf").write_text(text, encoding="utf-8")
    done = plogic("kb", "import", "arm.urdf", "--kb", folder, cwd=tmp_path)
    assert (done.returncode, done.stdout, done.stderr) == (1, "", f"plogic: arm.urdf:{said}\n")


def test_a_template_of_sdf_has_its_substitution_in_a_text(tmp_path, folder):
    (tmp_path / "thing.sdf").write_text(SDF.replace("model://thing", "file://$(find thing)"))
    line = refused(folder, tmp_path / "thing.sdf")
    assert (
        f"thing.sdf:2:{SDF.splitlines()[1].index('model://') + 1}: file://$(find thing){FILLED}write package://thing in"
        in line
    )


def test_a_xacro_file_is_sent_to_xacro(tmp_path, folder):
    (tmp_path / "arm.urdf.xacro").write_text("<robot/>")
    done = plogic("kb", "import", "arm.urdf.xacro", "--kb", folder, cwd=tmp_path)
    assert done.stderr == (
        "plogic: arm.urdf.xacro: is a template of a description: run xacro first, and import what it writes: "
        "xacro arm.urdf.xacro > arm.urdf\n"
    )


def test_what_is_not_read_may_stay_a_template(tmp_path, folder):
    unread = '<collision><geometry><mesh filename="$(find a)/b.stl"/></geometry></collision>'
    plugin = "<gazebo><plugin><uri>$(find a)/c.yaml</uri></plugin></gazebo><!-- <xacro:arm/> -->"
    link = f'<link name="${{side}}_arm">{unread}<visual>{BOX}</visual></link>'
    (tmp_path / "arm.urdf").write_text(f'<robot name="r">{link}{plugin}</robot>')
    good("kb", "import", tmp_path / "arm.urdf", "--kb", folder)
    (arm,) = read_kb(folder).types
    assert arm.surface.volume == pytest.approx(1.0)


def test_a_mesh_is_sent_to_kb_add(tmp_path, folder):
    assert "plogic kb add NAME --mesh" in refused(folder, write_box(tmp_path / "box.obj"))
    assert "there is no such file or folder" in refused(folder, tmp_path / "gone")


INFO = {
    "1": {"diameter": 374.2, "symmetries_discrete": [[-1, 0, 0, 100, 0, -1, 0, 200, 0, 0, 1, 0, 0, 0, 0, 1]]},
    "2": {"symmetries_continuous": [{"axis": [0, 0, 2], "offset": [50, 50, 0]}]},
}


def bop(folder, info=INFO):
    folder.mkdir()
    for number in (1, 2, 10):
        write_box(folder / "box.obj", (100, 200, 300)).rename(folder / "mesh.obj")
        import trimesh

        trimesh.load(folder / "mesh.obj").export(folder / f"obj_{number:06d}.ply")
    (folder / "mesh.obj").unlink()
    if info is not None:
        (folder / "models_info.json").write_text(info if isinstance(info, str) else json.dumps(info))
    return folder


def test_bop_models_are_in_millimetres_and_keep_their_symmetries(tmp_path, folder):
    good("kb", "import", bop(tmp_path / "models"), "--kb", folder)
    types = read_kb(folder).types
    assert [kind.name for kind in types] == ["obj_000001", "obj_000002", "obj_000010"]
    assert np.ptp(types[0].surface.vertices, axis=0) == pytest.approx([0.1, 0.2, 0.3])
    assert [len(kind.symmetries) for kind in types] == [2, 72, 1]
    assert types[0].symmetries[1] @ [0, 0, 0, 1] == pytest.approx([0.1, 0.2, 0, 1])
    assert types[1].symmetries[1] @ [0.05, 0.05, 0.3, 1] == pytest.approx([0.05, 0.05, 0.3, 1])


GLUE = [-0.999633, 0.026679, 0.00479336, -0.262139, -0.0266744, -0.999644, 0.00100504, -0.197966, 0.00481847, 0.000876815,
        0.999988, 0.0321652, 0, 0, 0, 1]  # fmt: skip
"""LM-O's own: a half turn that was fitted to a scan, and closes no group."""


def test_a_published_turn_that_is_not_exact_is_the_one_that_it_means(tmp_path, folder):
    good("kb", "import", bop(tmp_path / "models", {"1": {"symmetries_discrete": [GLUE]}}), "--kb", folder)
    same, turn = read_kb(folder).types[0].symmetries
    assert np.array_equal(same, np.eye(4))
    assert turn @ turn == pytest.approx(np.eye(4), abs=1e-8)
    assert turn[:3, :3] == pytest.approx(np.array(GLUE).reshape(4, 4)[:3, :3], abs=0.03)
    assert turn[:2, 3] == pytest.approx([-0.262139e-3, -0.197966e-3], abs=2e-5)


def test_names_in_models_info_are_the_types_names(tmp_path, folder):
    info = {"1": {"name": "ape"}, "2": {"name": "can"}, "10": {"name": "003_cracker_box"}}
    good("kb", "import", bop(tmp_path / "models", info), "--kb", folder)
    assert [kind.name for kind in read_kb(folder).types] == ["003_cracker_box", "ape", "can"]


@pytest.mark.parametrize("third", [{}, {"name": "ape"}, {"name": "../out"}, {"name": 3}])
def test_where_not_all_have_a_name_of_their_own_they_keep_their_numbers(tmp_path, folder, third):
    info = {"1": {"name": "ape"}, "2": {"name": "can"}, "10": third}
    good("kb", "import", bop(tmp_path / "models", info), "--kb", folder)
    assert [kind.name for kind in read_kb(folder).types] == ["obj_000001", "obj_000002", "obj_000010"]


def test_symmetries_of_six_digits_close(tmp_path, folder):
    c, s = 0.964966, 0.262375
    turn = [-c, s, 0, 0, s, c, 0, 0, 0, 0, -1, 0, 0, 0, 0, 1]
    other = [c, -s, 0, 0, -s, -c, 0, 0, 0, 0, -1, 0, 0, 0, 0, 1]
    good("kb", "import", bop(tmp_path / "models", {"1": {"symmetries_discrete": [turn, other]}}), "--kb", folder)
    assert len(read_kb(folder).types[0].symmetries) == 4


@pytest.mark.parametrize(
    ("info", "said"),
    [
        ("{", "is no JSON"),
        ("[]", "must map the models' numbers"),
        ({"1": {"symmetries_discrete": [[1, 2]]}}, "must be 16 finite numbers"),
        ({"1": {"symmetries_discrete": [[2, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]]}}, "must be a rigid motion"),
        ({"1": {"symmetries_continuous": [{"axis": [0, 0, 0]}]}}, "an axis must have a direction"),
        ({"1": {"symmetries_continuous": [{"axis": [0, 0, 1]}, {"axis": [0, 1, 0]}]}}, "more than 400 motions"),
    ],
)
def test_bad_models_info_writes_nothing(tmp_path, folder, info, said):
    assert said in refused(folder, bop(tmp_path / "models", info))


def test_a_folder_without_models(tmp_path, folder):
    (tmp_path / "empty").mkdir()
    assert "holds no obj_000001.ply" in refused(folder, tmp_path / "empty")


def test_a_knowledge_base_that_is_missing_is_made_as_by_kb_add_and_said(tmp_path):
    mesh = write_box(tmp_path / "box.obj")
    (tmp_path / "arm.urdf").write_text(URDF)
    (tmp_path / "empty").mkdir()
    imports = ("kb", "import", tmp_path / "arm.urdf")
    adds = ("kb", "add", "box", "--mesh", mesh, "--units", "m")
    for args, folder in ((imports, tmp_path / "one"), (adds, tmp_path / "two")):
        assert f"made a new knowledge base: {folder}" in good(*args, "--kb", folder).splitlines()
        assert len(read_kb(folder).types) == 1
        assert "holds no kb.yaml" in plogic(*args, "--kb", tmp_path / "empty").stderr
    bad = tmp_path / "none.urdf"
    assert plogic("kb", "import", bad, "--kb", tmp_path / "three").returncode == 1
    assert not (tmp_path / "three").exists()
