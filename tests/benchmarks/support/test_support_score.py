"""What ``plogic bench support`` counts: planes, who is said to stand on what, depths, and both sides."""

import numpy as np
import pytest
from standing_towers import standing_towers

from benchmarks.photos.answers import Shown
from benchmarks.photos.score import Counts, Posed, Told
from benchmarks.photos.table import Measure
from benchmarks.photos.told import NAMED, STANDS, Forecast
from benchmarks.support import bench, table
from benchmarks.support.arranged import Stance
from benchmarks.support.bench import groups_of, resting, shared
from benchmarks.support.pictures import grid, with_grid
from benchmarks.support.said import Said, said_of
from benchmarks.support.scenes import FIRST, Stood
from benchmarks.support.score import Judged, Thing, judged, same_plane
from geometry.bodies.resting import Plane
from geometry.camera import Camera
from geometry.visibility.rays import RayMesh
from kb.files.read import read_kb
from plogic.base.errors import InputError
from plogic.face.authoring.kb_types import new_command
from plogic.run.bop.models import Model

CORNERS = np.array([[x, y, z] for x in (-0.05, 0.05) for y in (-0.05, 0.05) for z in (-0.05, 0.05)])
QUADS = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
FACES = [t for a, b, c, d in QUADS for t in ((a, b, c), (a, c, d))]
CUBE = Model(CORNERS, 0.1 * 3**0.5, np.eye(4)[None])
MEASURE = Measure(
    dict.fromkeys((1, 2, 3), CUBE), dict.fromkeys((1, 2, 3), RayMesh(CORNERS, FACES)), {1: "a", 2: "b", 3: "c"}
)
CAMERA = Camera(320, 240, [[300, 0, 159.5], [0, 300, 119.5], [0, 0, 1]])
GROUPS = {"printed, ycb": (1, 2), "plain, ycb": (3,)}
TRUE = Plane(np.array([0.0, -0.8, -0.6]), 0.6)
"""37° to the view; a cube's middle on it is 5 cm above."""


def at(x, z, height=0.05):
    """A cube whose middle is so high above the plane."""
    place = np.array([x, 0.0, z])
    place[1] = (TRUE.offset - height - 0.6 * z) / 0.8
    pose = np.eye(4)
    pose[:3, 3] = place
    return pose


STANDING, STACKED, HELD = Posed(1, at(-0.2, 1.0)), Posed(2, at(-0.2, 1.0, 0.15)), Posed(3, at(0.2, 1.0, 0.3))
STOOD = Stood(
    Shown("7", np.full((240, 320, 3), 99, np.uint8), CAMERA, (STANDING, STACKED, HELD)),
    TRUE,
    (Stance("standing"), Stance("stacked", 0), Stance("free")),
)
ANSWERS = {"h1": STANDING, "h2": STACKED, "h3": Posed(3, at(0.2, 1.02, 0.3))}
SAID = Said(
    {"s1": TRUE, "s2": Plane(TRUE.up, 0.8)},
    {("h1", "s1"): 0.9, ("h1", "s2"): 0.05, ("h2", "s2"): 0.2},
    {("h2", "h1"): 0.7, ("h1", "ground"): 0.9},
    {"h1": 0.05, "h2": 0.1, "h3": 0.8},
)


def asked(monkeypatch, said, answers=ANSWERS):
    monkeypatch.setattr("benchmarks.support.score.said_of", lambda _: said)
    return judged(STOOD, {}, answers, MEASURE, GROUPS)


def test_a_plane_is_right_within_its_turn_and_its_distance():
    place = np.array([0.0, 0.0, 1.0])
    plane = Plane(np.array([0.0, 0.0, -1.0]), 1.0)

    def turned(degrees, offset):
        return Plane(np.array([0.0, -np.sin(np.radians(degrees)), -np.cos(np.radians(degrees))]), offset)

    assert same_plane(plane, plane, place)
    assert same_plane(turned(2.9, np.cos(np.radians(2.9))), plane, place)
    assert not same_plane(turned(3.1, np.cos(np.radians(3.1))), plane, place)
    assert same_plane(turned(0, 1.019), plane, place)
    assert not same_plane(turned(0, 1.021), plane, place)


def test_who_stands_on_what_is_told_right(monkeypatch):
    one = asked(monkeypatch, SAID)
    assert [(thing.kind, thing.says, thing.told) for thing in one.things] == [
        ("standing", "standing", True),
        ("stacked", "stacked", True),
        ("free", "free", True),
    ]
    assert one.plane is True
    assert one.standing == 1
    assert one.counts == {"printed, ycb": Counts(2, 2, 2, 2, 0), "plain, ycb": Counts(1, 0, 1, 1, 0)}
    assert [thing.depth for thing in one.things] == pytest.approx([0.0, 0.0, 0.02])
    assert one.tilt == pytest.approx(np.degrees(np.arcsin(0.6)))
    claimed = {forecast.claim for forecast in one.claimed}
    assert claimed == {STANDS}
    assert [(f.p, f.true) for f in one.claimed] == [(0.9, True), (0.2, False), (0.0, False)]


def test_what_stands_on_a_thing_that_is_not_found_is_not_told(monkeypatch):
    one = asked(monkeypatch, SAID, {"h2": STACKED})
    assert [(thing.row.found, thing.told) for thing in one.things] == [(False, None), (True, None), (False, None)]
    assert one.things[1].says == "stacked"


def test_another_below_and_another_kind_are_wrong(monkeypatch):
    wrong = SAID._replace(rests={("h2", "h3"): 0.7}, free={"h1": 0.95, "h3": 0.1}, stands={})
    assert [thing.told for thing in asked(monkeypatch, wrong).things] == [False, False, True]
    first = SAID._replace(planes={"s2": SAID.planes["s2"], "s1": TRUE})
    assert asked(monkeypatch, first).plane is False
    assert asked(monkeypatch, SAID._replace(planes={})).plane is False


def test_nothing_is_judged_of_a_document_that_says_nothing(monkeypatch):
    assert said_of({"format": "interpretation/1"}) is None
    one = asked(monkeypatch, None)
    assert (one.plane, one.claimed) == (None, ())
    assert {thing.told for thing in one.things} == {None}
    assert table.missing({table.WITH: [one], table.WITHOUT: [one]})
    bars = {claim.claim.partition(",")[0]: claim for claim in table.claims({table.WITH: [one], table.WITHOUT: [one]})}
    assert bars["plane first"].value is None
    assert bars["plane first"].met is False
    assert bars["plane first"].document()["value"] is None


def test_a_document_is_asked_for_planes_and_stances():
    _, ranking, document = standing_towers("posterior")
    said = said_of(document)
    assert list(said.planes) == ["s1", "s2"]
    assert said.planes["s1"].height(np.array([0.0, 0.0, 1.25 / 0.6])) == pytest.approx(0.0)
    rows = {h["id"]: h for h in document["hypotheses"] if h["status"] != "rejected"}
    for name, h in rows.items():
        assert said.free.get(name, 0.0) == pytest.approx(h["free"], abs=1e-9)
        for on in ("s1", "s2", "h1"):
            told = sum(s["probability"] for s in h["stances"] if s["on"] == on)
            asked = (said.rests if on == "h1" else said.stands).get((name, on), 0.0)
            assert asked == pytest.approx(told, abs=1e-9)
    assert said.kind("h1") == said.kind("h2") == ("standing", "s1")
    assert said.stood("h1")[0] <= ranking.marginals["h1"] + 1e-9


def thing(group, how, depth=None, kind="standing"):
    error, overlap = {"right": (0.01, 0.9), "found": (0.5, 0.9), "missed": (None, None)}[how]
    return Thing("7", group, kind, Told(1, error, overlap), depth)


def one(*things, plane=None, claimed=()):
    counts = {
        group: Counts(len(own), sum(t.row.right for t in own), sum(t.row.found for t in own))
        for group in dict.fromkeys(t.group for t in things)
        if (own := [t for t in things if t.group == group])
    }
    return Judged(40.0, counts, things, plane, claimed, 1.0)


def test_claims_set_both_sides_beside_each_other():
    printed, plain = "printed, ycb", "plain, ycb"
    same = thing(plain, "right")
    rests = one(thing(printed, "right", 0.002), same, same, thing(plain, "missed", kind="free"), plane=True)
    without = one(thing(printed, "right", 0.01), same, thing(plain, "found"), thing(plain, "found", kind="free"))
    claimed = [Forecast("7", STANDS, 1.0, true) for true in (True, True, True, False)]
    claimed.append(Forecast("7", NAMED, 1.0, true=True))
    sides = {table.WITH: [rests._replace(claimed=tuple(claimed))], table.WITHOUT: [without]}
    values = [claim.value for claim in table.claims(sides)]
    assert values == [1.0, None, 0.25, 0.0, 2.0, pytest.approx(0.2), 1]
    assert table.lost(sides) == [{"picture": "7", "number": 1, "of": plain}]
    lines = {line["row"]: line for line in table.rows(sides)}
    assert lines["plain, ycb, without"]["free"] == "1 of 1"
    assert lines["plain, ycb, with support"]["free"] == "0 of 1"
    assert lines["all, with support"]["depth off, mm"] == 2.0
    [by_tilt] = table.more(sides)["by tilt"]
    assert by_tilt["degrees"] == "30 to 55"
    assert (by_tilt["there"], by_tilt["found, with support"], by_tilt["found, without"]) == (4, 3, 4)


def test_of_four_scenes_three_are_of_the_first_set(tmp_path, monkeypatch):
    monkeypatch.setattr(bench.photos, "FOLDER", tmp_path)
    notes = []
    with pytest.raises(InputError, match="PLOGIC_PHOTOS"):
        shared(8, 0, notes.append, quick=True)
    (tmp_path / "lmo/models").mkdir(parents=True)
    assert {name: len(some) for name, some in shared(8, 0, notes.append, quick=False).items()} == {"lmo": 8}
    assert "ycb: has no models: their scenes are left out" in notes[-1]
    (tmp_path / "ycb/models").mkdir(parents=True)
    both = shared(10, 2, notes.append, quick=False)
    assert sum(map(len, both.values())) == 10
    assert both["ycb"] == range(FIRST + 2000, FIRST + 2008)
    assert both["lmo"][0] == FIRST + 2500
    assert list(shared(10, 0, notes.append, quick=True)) == ["ycb"]


def test_groups_are_of_types_that_have_models():
    assert groups_of("lmo", MEASURE) == {"plain, lmo": (1, 2, 3)}
    assert groups_of("ycb", MEASURE) == {"printed, ycb": (1, 2, 3)}
    with pytest.raises(InputError, match="none of the types"):
        groups_of("ycb", Measure({}, {}, {}))


def test_both_sides_differ_in_gravity_alone(tmp_path):
    new_command(tmp_path / "kb", None)
    file = tmp_path / "kb/kb.yaml"
    file.write_text(file.read_text().replace("gravity: maybe", "gravity:\n  unknown_support: 0.2\n  ground: 0 m"))
    kb = read_kb(tmp_path / "kb")
    assert kb.gravity
    assert resting(kb, maybe=True).rests == pytest.approx(0.9)
    assert resting(kb, maybe=False).rests is None
    assert resting(kb, maybe=True).ground is None


def test_the_grid_lies_on_the_plane():
    lines = grid(STOOD)
    assert len(lines) == 50
    assert all(np.isfinite(line).all() for line in lines)
    picture = with_grid(STOOD)
    assert picture.shape == STOOD.shown.image.shape
    assert (picture != STOOD.shown.image).any()
