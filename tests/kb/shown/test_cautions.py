"""What is no mistake and yet matters: features that nothing sees, lobes that never meet, clouds in clouds."""

from __future__ import annotations

import pytest
from made_meshes import write_box

from kb.files.folder import shipped
from kb.files.read import read_kb
from kb.shown.cautions import cautions

KB = "name: k\nappearance_types: [spot, dot]\n"
FACES = {"left": ([0, 0.5, 0.5], [-1, 0, 0]), "right": ([1, 0.5, 0.5], [1, 0, 0]), "top": ([0.5, 0.5, 1], [0, 0, 1])}


def feature(name, at, axis, kind="spot", half="60 deg", reach="[0.2, 30]"):
    lobe = f"{{axis: {axis}, half_angle: {half}, range: {reach}}}"
    return f"  - {{feature: {name}, type: {kind}, at: {at}, appearances: [{{type: {kind}, lobe: {lobe}}}]}}\n"


def on_top(kind="spot", count=5, shift=0.0):
    places = [(0.1, 0.1), (0.9, 0.15), (0.5, 0.7), (0.2, 0.9), (0.7, 0.4)][:count]
    return "".join(
        feature(f"f{i}", [x + shift, y, 1], [0, 0, 1], kind if i else "dot") for i, (x, y) in enumerate(places)
    )


def read(folder, *, mesh=True, **types):
    """A KB of unit cubes with these features."""
    (folder / "kb.yaml").write_text(KB)
    for name, features in types.items():
        place = folder / "objects" / name
        place.mkdir(parents=True)
        write_box(place / "mesh.obj")
        text = f"object: {name}\n" + ("mesh: {file: mesh.obj, units: m}\n" if mesh else "")
        (place / "object.yaml").write_text(text + "features:\n" + features)
    return read_kb(folder)


def said(kb):
    return list(cautions(kb))


UNSEEN = "no viewpoint sees x: the lobes lie inside or behind the type's own body"
INWARD = "the lobe of x looks inward, into the type's own body: turn the axis round: it points from the feature to the viewer"


def test_a_good_type_is_not_warned_of(tmp_path):
    assert said(read(tmp_path, cube=on_top())) == []
    assert said(read_kb(shipped("towers"))) == []


def test_a_texture_that_is_missing_is_named(tmp_path):
    kb = read(tmp_path, cube=on_top())
    mesh = kb.types[0].mesh_file
    mesh.with_name("m.mtl").write_text("newmtl skin\nmap_Kd skin.png\n")
    mesh.write_text("mtllib m.mtl\nusemtl skin\n" + mesh.read_text())
    assert said(read_kb(tmp_path)) == [
        "cube: the texture 'skin.png' of its mesh is missing, so that it cannot be drawn"
    ]


@pytest.mark.parametrize(
    ("hidden", "why"),
    [
        (feature("x", [0.5, 0.5, 1], [0, 0, -1], half="30 deg"), INWARD),
        (feature("x", [0.5, 0.5, 0.5], [0, 0, 1], half="180 deg"), UNSEEN),
        (feature("x", [0.5, 0.5, 1], [0, 0, -1], half="30 deg", reach="[0.1, 0.5]"), INWARD),
    ],
    ids=["a lobe through the body", "a feature inside", "a lobe inside the body"],
)
def test_a_feature_that_no_viewpoint_sees(tmp_path, hidden, why):
    (line,) = said(read(tmp_path, cube=on_top() + hidden))
    assert line == f"cube: {why}"


def test_without_a_surface_everything_is_seen(tmp_path):
    assert said(read(tmp_path, mesh=False, cube=on_top() + feature("x", [0.5, 0.5, 1], [0, 0, -1]))) == []


def test_lobes_that_never_meet(tmp_path):
    apart = "".join(feature(name, at, axis, half="20 deg") for name, (at, axis) in FACES.items())
    apart += feature("front", [0.5, 0, 0.5], [0, -1, 0], "dot", half="20 deg")
    (line,) = said(read(tmp_path, cube=apart))
    assert line.startswith(
        "cube: its lobes never meet: no viewpoint was found that sees 4 features at once (1 at most)"
    )


def test_narrow_lobes_that_meet_are_found(tmp_path):
    spots = [
        ([0.4, 0.4, 1], [0.1, 0.1, 3]),
        ([0.6, 0.4, 1], [-0.1, 0.1, 3]),
        ([0.4, 0.6, 1], [0.1, -0.1, 3]),
        ([0.6, 0.6, 1], [-0.1, -0.1, 3]),
    ]
    narrow = "".join(
        feature(f"f{i}", at, axis, "dot" if i else "spot", half="4 deg") for i, (at, axis) in enumerate(spots)
    )
    assert said(read(tmp_path, cube=narrow)) == []


def test_few_features(tmp_path):
    (line,) = said(read(tmp_path, cube=on_top(count=3)))
    assert line == "cube: has 3 features, and a pose is taken from 4: it is never found"


def test_one_sort_of_feature_has_no_dv(tmp_path):
    (line,) = said(read(tmp_path, cube=on_top(kind="dot")))
    assert "so that every dv is 0" in line


def test_a_cloud_in_another(tmp_path):
    more = on_top(shift=0.05) + feature("y", [0.5, 0.2, 1], [0, 0, 1])
    assert said(read(tmp_path, small=on_top(), large=more)) == [
        "small: its cloud is contained in that of large: wherever large stands, small fits as well"
    ]


def test_the_same_cloud_twice_is_said_once(tmp_path):
    assert said(read(tmp_path, one=on_top(), two=on_top(shift=0.05))) == [
        "one: its cloud is the same as that of two: nothing tells them apart"
    ]


def test_of_many_that_are_the_same_one_sentence_is_said(tmp_path):
    kinds = {f"k{i}": on_top(shift=0.01 * i) for i in range(8)}
    more = on_top(shift=0.05) + feature("y", [0.5, 0.2, 1], [0, 0, 1])
    assert said(read(tmp_path, large=more, **kinds)) == [
        "k0: its cloud is the same as that of k1, k2, k3, k4, k5 and 2 more: nothing tells them apart",
        "k0, k1, k2, k3, k4 and 3 more: its cloud is contained in that of large: wherever large stands, each of these fits as well",
    ]


def test_a_mirrored_cloud_is_another(tmp_path):
    chiral = on_top() + feature("high", [0.3, 0.3, 1.4], [0, 0, 1])
    mirrored = chiral.replace("[0.3, 0.3, 1.4]", "[0.3, 0.3, 0.6]")
    assert said(read(tmp_path, mesh=False, one=chiral, two=mirrored)) == []


def scaled(share):
    """Five features of a cube of that side."""
    places = [(0, 0, 0), (1, 1, 1), (0.9, 0.15, 1), (0.2, 0.9, 1), (0.7, 0.4, 1)]
    return "".join(
        feature(f"f{i}", [share * x for x in place], [0, 0, 1], "spot" if i else "dot", reach="[0.002, 3000]")
        for i, place in enumerate(places)
    )


@pytest.mark.parametrize(
    ("share", "hint"),
    [
        (0.001, "is the mesh in mm? write it so, as in mesh: {units: mm}"),
        (0.01, "is the mesh in cm? write it so, as in mesh: {units: cm}"),
        (100.0, "is a feature's at in cm? write it so, as in [15 cm, 0 m, 2 cm]"),
        (1000.0, "is a feature's at in mm? write it so, as in [15 mm, 0 m, 2 mm]"),
    ],
)
def test_a_hint_of_another_unit_shows_how_that_unit_is_written(tmp_path, share, hint):
    """The mesh is a cube of 1 m."""
    (line,) = [line for line in said(read(tmp_path, cube=scaled(share))) if "in different units" in line]
    assert line.endswith(f"they are in different units: {hint}")
