"""Mistakes of authors, each made on purpose in a folder of its own: the first line printed names the cause."""

from __future__ import annotations

import re

import pytest
from in_process import told
from spoiled_box import MESH, TYPE, texts, written


def edited(name, *pairs):
    """A spoiler: in a file, each text replaced by the next."""

    def spoil(files):
        for old, new in pairs:
            assert old in files[name], old
            files[name] = files[name].replace(old, new)

    return spoil


def scaled(name, factor):
    """A spoiler: the numbers of all vertices, or of all places, times a factor."""

    def spoil(files):
        head, end = ("v ", "") if name == MESH else ("at: [", "]")
        row = re.compile(rf"^( *{re.escape(head)})([-\d., ]+)({re.escape(end)})$", re.MULTILINE)
        gap = " " if name == MESH else ", "

        def times(found):
            numbers = [f"{factor * float(x):g}" for x in re.split(r"[ ,]+", found[2].strip())]
            return found[1] + gap.join(numbers) + found[3]

        files[name], count = row.subn(times, files[name])
        assert count

    return spoil


def kept(count):
    """A spoiler: the first features alone."""

    def spoil(files):
        rows = files[TYPE].split("  - feature:")
        files[TYPE] = "  - feature:".join(rows[: count + 1]) if count else rows[0].replace("features:", "features: []")
        files["kb.yaml"] = files["kb.yaml"].replace("  hit: {corner: 0.9, sticker: 0.9}\n", "")

    return spoil


def kept_last(count):
    """A spoiler: a corner and the last features alone."""

    def spoil(files):
        rows = files[TYPE].split("  - feature:")
        files[TYPE] = "  - feature:".join([*rows[:2], *rows[1 - count :]])

    return spoil


def inward(files):
    files[TYPE] = re.sub(r"axis: \[([^\]]+)\]", lambda m: f"axis: {[-float(x) for x in m[1].split(',')]}", files[TYPE])


def on_a_line(files):
    places = iter(range(100))
    files[TYPE] = re.sub(
        r"(?<=    at: )\[[^\]]+\]", lambda _: f"[{-0.15 + 0.02 * next(places):g}, -0.1, 0]", files[TYPE]
    )


def in_parts(*, again):
    """A spoiler: the box as a body and a lid, which is a part at the top; ``again``: its places have the offset too."""

    def spoil(files):
        head, *rows = files[TYPE].removesuffix("\n").split("\n  - feature:")
        lid = [row for row in rows if row.startswith(" top")]
        own = [row if again else row.replace("0.16]", "0]") for row in lid]
        parts = [("body", "0", [row for row in rows if row not in lid]), ("lid", "0.16", own)]
        text = head.removesuffix("features:") + "parts:\n"
        for name, high, some in parts:
            text += f"  - part: {name}\n    at: [0, 0, {high}]\n    features:\n"
            text += "".join(f"      - feature:{row}\n".replace("\n    ", "\n        ") for row in some)
        files[TYPE] = text

    return spoil


def open_mesh(files):
    files[MESH] = "\n".join([row for row in files[MESH].splitlines() if row.startswith("v")] + ["f 1 2 3", "f 1 3 4"])


def three_on_an_edge(files):
    files[MESH] += "v 0 0 0.5\n" + f"f 1 2 {sum(row.startswith('v ') for row in files[MESH].splitlines()) + 1}\n"


def second_box(files):
    files["objects/other/object.yaml"] = files[TYPE]
    files["objects/other/mesh.obj"] = files[MESH]


def without(name):
    def spoil(files):
        files[name] = None

    return spoil


def with_rules(text):
    def spoil(files):
        files["rules.pl"] = text

    return spoil


MISTAKES = {
    "no kb.yaml": (without("kb.yaml"), "the folder holds no kb.yaml"),
    "an empty kb.yaml": (lambda files: files.update({"kb.yaml": ""}), "kb.yaml:1:1: the file is empty"),
    "a misspelt key": (edited(TYPE, ("opaque:", "opaqe:")), "object.yaml:3:1: opaqe: unknown key"),
    "no lobe": (
        edited(
            TYPE,
            ("{type: corner, lobe: {axis: [-1, -1, -1], half_angle: 126 deg, range: [0.2 m, 5 m]}}", "{type: corner}"),
        ),
        "missing key 'lobe'",
    ),
    "degrees that are taken for radians": (edited(TYPE, ("126 deg", "126")), "half_angle: "),
    "plain degrees, told in what was written": (
        edited(TYPE, ("126 deg", "126")),
        "must be above 0 and at most 3.14159 rad, not 126 rad; a plain number is in rad: for degrees write '126 deg'",
    ),
    "radians that are called degrees": (
        edited(TYPE, ("75 deg", "1.3 deg")),
        "so narrow a cone; was 1.3 rad meant? write '1.3 rad' or '74.5 deg'",
    ),
    "the offset of a part applied twice": (
        in_parts(again=True),
        "off the mesh, and on it without the part's own at, [0, 0, 0.16]: is it applied twice?",
    ),
    "a corner that looks inward through a wide cone": (
        edited(TYPE, ("axis: [-1, -1, -1], half_angle: 126 deg", "axis: [0.2, 0.1, 1], half_angle: 120 deg")),
        "the lobe of base_sw looks inward",
    ),
    "a range shorter than the type": (edited(TYPE, ("[0.2 m, 5 m]", "[0.2 m, 0.3 m]")), "the range ends 0.3 m away"),
    "one range that ends where the whole is not seen": (
        edited(
            TYPE,
            (
                "axis: [1, 0, 0], half_angle: 75 deg, range: [0.2 m, 5 m]",
                "axis: [1, 0, 0], half_angle: 75 deg, range: [0.1 m, 0.25 m]",
            ),
        ),
        "the range of east ends 0.25 m away, and the whole is seen from 0.394 m to 5 m: never expected with the others",
    ),
    "one range that begins where no other reaches": (
        edited(
            TYPE,
            (
                "axis: [1, 0, 0], half_angle: 75 deg, range: [0.2 m, 5 m]",
                "axis: [1, 0, 0], half_angle: 75 deg, range: [6 m, 9 m]",
            ),
        ),
        "the range of east begins 6 m away",
    ),
    "a range that ends before it begins": (edited(TYPE, ("[0.2 m, 5 m]", "[5 m, 0.2 m]")), "range"),
    "a mesh without its unit": (edited(TYPE, (", units: m", "")), "no mesh format carries its unit"),
    "a mesh that is not there": (without(MESH), "the mesh 'mesh.obj' is missing"),
    "a mesh of two facets": (open_mesh, "warning: box: the mesh is not closed"),
    "a mesh that is not manifold": (three_on_an_edge, "warning: box: the mesh is not closed"),
    "a mesh in millimetres stated as metres": (scaled(MESH, 1000), "its features measure"),
    "places in millimetres stated as metres": (scaled(TYPE, 1000), "its features measure"),
    "one place in centimetres": (edited(TYPE, ("[0.04, 0.1, 0.09]", "[4, 10, 9]")), "north is off the mesh by"),
    "all lobes look inward": (inward, "look inward"),
    "one lobe looks inward": (edited(TYPE, ("axis: [1, 0, 0]", "axis: [-1, 0, 0]")), "the lobe of east looks inward"),
    "an unknown appearance type": (
        edited(TYPE, ("{type: sticker", "{type: stiker")),
        "unknown appearance type 'stiker'",
    ),
    "two types of one name": (second_box, "'box' is also the object of objects/box/object.yaml"),
    "two features of one name": (
        edited(TYPE, ("feature: north", "feature: east")),
        "'east' is the name of another feature",
    ),
    "no features": (kept(0), "box: has no features, so it is never found"),
    "three features": (kept_last(3), "has 3 features, and a pose is taken from 4"),
    "one feature type": (kept(8), "every feature is of type 'corner'"),
    "lobes that never meet": (edited(TYPE, ("126 deg", "5 deg"), ("75 deg", "5 deg")), "its lobes never meet"),
    "ranges in centimetres stated as metres": (edited(TYPE, ("[0.2 m, 5 m]", "[200 m, 500 m]")), "smaller than"),
    "ranges that end within the type": (edited(TYPE, ("[0.2 m, 5 m]", "[2 mm, 50 mm]")), "range ends"),
    "features on one line": (on_a_line, "on one line"),
    "a prior of no type": (edited("kb.yaml", ("priors: {box", "priors: {bux")), "bux"),
    "an axis without a direction": (edited(TYPE, ("axis: [0, 0, 1]", "axis: [0, 0, 0]")), "axis"),
    "noise beyond the tolerance": (edited("kb.yaml", ("sigma: 1.0", "sigma: 12")), "sigma"),
    "rules that exclude everything": (with_rules("constraint(never).\n"), "constraint(never)"),
    "rules that do not parse": (with_rules("near(X) :- .\n"), "rules.pl:1:"),
}


def test_there_are_many():
    assert len(MISTAKES) == 37


def test_a_part_at_its_own_place_is_warned_of_nothing(tmp_path):
    files = texts()
    in_parts(again=False)(files)
    assert told("kb", "check", written(tmp_path / "kb", files))[0].endswith("no mistakes")


@pytest.mark.parametrize("name", MISTAKES)
def test_the_first_line_names_the_cause(name, tmp_path):
    spoil, cause = MISTAKES[name]
    files = texts()
    spoil(files)
    lines = told("kb", "check", written(tmp_path / "kb", files))
    assert cause in lines[0], "\n".join(lines)


def test_the_box_as_shipped_is_warned_of_nothing(tmp_path):
    assert told("kb", "check", written(tmp_path / "kb", texts()))[0].endswith("no mistakes")
