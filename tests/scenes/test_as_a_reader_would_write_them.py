"""The paper's situations through the public Python face, each with the number that its formula gives.

``paper_scenes`` computes it from the estimated pose by its own projection, lobes, rays and sums.
"""

from __future__ import annotations

import numpy as np
import pytest
from paper_scenes import IDENTITY, LOOKS, SIGNS, Box, Scene, box, standing, written

from plogic import perceive

CRATE, CAN = box((0.25, 0.2, 0.15), 1), box((0.12, 0.12, 0.3), 2)
TYPES = {"crate": CRATE, "can": CAN}


def accepted(scene):
    return [h for h in scene.hypotheses if h.status == "accepted"]


def right(h, pose, turns=(IDENTITY,)):
    """Within 5° and 5 % of the distance of a pose, up to turns."""
    best = max(np.trace(h.T_camera_object[:3, :3].T @ (pose @ turn)[:3, :3]) for turn in turns)
    angle = np.degrees(np.arccos(min(1.0, (best - 1.0) / 2.0)))
    return angle < 5.0 and np.linalg.norm(h.T_camera_object[:3, 3] - pose[:3, 3]) < 0.05 * pose[2, 3]


def numbers(made, scene, mode="alone"):
    """P(ev) of every accepted hypothesis by the oracle, beside the other accepted ones in one of the modes."""
    some, data = accepted(scene), made.gamma().appearances
    posed = {h.id: (h.type, h.T_camera_object) for h in some}
    claims = {}
    for name, (kind, pose) in posed.items():
        uv, seen = made.expected(kind, pose, [other for key, other in posed.items() if key != name])
        places = [(f[1], uv[i]) for i, f in enumerate(made.types[kind].features) if seen[i]]
        claims[name] = {a.id for a in data if any(t == a.type and np.hypot(*(p - a.uv)) <= 4.0 for t, p in places)}
    shares = {}
    for name, (kind, pose) in posed.items():
        others = [other for key, other in posed.items() if key != name]
        left = [a for a in data if not any(a.id in taken for key, taken in claims.items() if key != name)]
        shares[name] = made.share(made.cells(kind, pose, others, left), mode)
    return shares


def told(scene):
    return {h.id: h.p_ev for h in accepted(scene)}


def chance(scene, goal, given=()):
    (row,) = scene.query(goal, given=given)
    return row.probability


@pytest.fixture(scope="module")
def kb(tmp_path_factory):
    return written(tmp_path_factory.mktemp("scenes") / "kb", TYPES)


def chain():
    """Three in a row: the first hides a part of the second, the second a part of the third."""
    front, middle, back = (
        standing(-0.35, 0.12, 2.0, 0.3),
        standing(-0.12, 0.0, 2.6, 0.5),
        standing(0.2, -0.05, 3.2, 0.8),
    )
    return Scene(TYPES, (("can", front), ("crate", middle), ("can", back)))


SITUATIONS = {
    "one alone": Scene(TYPES, (("crate", standing(0.1, 0.0, 2.0, 0.4)),)),
    "missed features": Scene(
        TYPES, (("crate", standing(0.1, 0.0, 2.0, 0.4)),), missed=((0, "c1"), (0, "c7"), (0, "m00"))
    ),
    "from below": Scene(TYPES, (("crate", standing(0.0, 0.1, 2.2, 0.4, lean=-0.5)),)),
    "half out of the image": Scene(TYPES, (("crate", standing(0.95, 0.1, 2.0, 0.4)),)),
    "twins": Scene(TYPES, (("can", standing(-0.4, 0.0, 2.4, 0.2)), ("can", standing(0.4, 0.0, 2.2, 1.1)))),
    "a chain of occluders": chain(),
}


@pytest.mark.parametrize("name", SITUATIONS)
def test_all_are_found_and_ev_is_the_formulas(kb, name):
    made = SITUATIONS[name]
    scene = perceive(made.gamma(), kb)
    some = accepted(scene)
    assert all(any(h.type == kind and right(h, pose) for h in some) for kind, pose in made.objects)
    assert len(some) == len(made.objects)
    assert told(scene) == pytest.approx(numbers(made, scene), abs=1e-9)
    measures = {m.id: m for m in scene.measures()}
    for mode in ("to_B", "drop"):
        beside = {name: 2.0 * share - 1.0 for name, share in numbers(made, scene, mode).items()}
        assert {h.id: getattr(measures[h.id], f"ev_{mode}") for h in some} == pytest.approx(beside, abs=1e-9)


def test_in_a_chain_each_probability_is_that_beside_its_own_occluders(kb):
    made = chain()
    scene = perceive(made.gamma(), kb)
    front, middle, back = (next(h for h in accepted(scene) if right(h, pose)) for _, pose in made.objects)
    posed = {h.id: (h.type, h.T_camera_object) for h in (front, middle, back)}

    def hidden(h, by):
        alone, beside = made.expected(*posed[h.id])[1], made.expected(*posed[h.id], [posed[by.id]])[1]
        return int((alone & ~beside).sum())

    assert hidden(middle, front) > 0
    assert hidden(back, middle) > 0
    assert (hidden(front, middle), hidden(front, back), hidden(middle, back)) == (0, 0, 0)
    share = numbers(made, scene, "to_B")
    all_three = [f"present({front.id})", f"present({middle.id})"]
    assert chance(scene, f"present({back.id})", all_three) == pytest.approx(share[back.id], abs=1e-9)
    assert chance(scene, f"present({middle.id})", all_three[:1]) == pytest.approx(share[middle.id], abs=1e-9)
    assert chance(scene, f"present({front.id})") == pytest.approx(share[front.id], abs=1e-9)


def before():
    """A can before a crate, some features of each missed, so that nothing is certain."""
    front, back = standing(-0.02, 0.1, 2.0, 0.3), standing(0.12, 0.0, 2.8, 0.5)
    return Scene(TYPES, (("can", front), ("crate", back)), missed=((0, "c1"), (1, "c3")), extra=(("disc", 60.0, 60.0),))


@pytest.mark.parametrize("mode", ["to_B", "drop", "reassign"])
def test_an_occluder_that_is_retracted_gives_back_the_ev_of_the_hypothesis_alone(kb, mode):
    made = before()
    scene = perceive(made.gamma(), kb, reconsider=mode)
    front, back = (next(h for h in accepted(scene) if right(h, pose)) for _, pose in made.objects)
    with_it, without = numbers(made, scene, mode)[back.id], numbers(made, scene)[back.id]
    p_front = numbers(made, scene)[front.id]
    assert with_it > without
    assert chance(scene, f"present({back.id})", [f"present({front.id})"]) == pytest.approx(with_it, abs=1e-9)
    assert chance(scene, f"present({back.id})", [f"\\+present({front.id})"]) == pytest.approx(without, abs=1e-9)
    mixed = p_front * with_it + (1.0 - p_front) * without
    assert chance(scene, f"present({back.id})") == pytest.approx(mixed, abs=1e-9)


def test_an_unknown_occluder_costs_what_it_hides_and_nothing_else(kb):
    """Something that the knowledge base does not know hides a corner region: its features are C."""
    pose = standing(0.1, 0.0, 2.0, 0.4)
    uv, seen = Scene(TYPES, ()).expected("crate", pose)
    left = [f[0] for f, place, there in zip(CRATE.features, uv, seen, strict=True) if there and place[0] < 345.0]
    assert len(left) >= 3
    made = Scene(TYPES, (("crate", pose),), missed=tuple((0, name) for name in left))
    scene = perceive(made.gamma(), kb)
    (h,) = accepted(scene)
    assert sorted(name for name, case in h.cases.items() if case == "C") == sorted(left)
    dv = made.dv()
    kinds = {f[0]: f[1] for f in CRATE.features}
    inside = [name for name, case in h.cases.items() if case is not None]
    lost = sum(dv[kinds[name]] for name in left) / sum(dv[kinds[name]] for name in inside)
    assert h.p_ev == pytest.approx(1.0 - lost, abs=1e-9)


def test_glass_hides_nothing_and_occludes_nothing(tmp_path):
    glass = {**TYPES, "can": box((0.12, 0.12, 0.3), 2, opaque=False)}
    kb, made = written(tmp_path / "kb", glass), before()
    made = Scene(glass, made.objects)
    scene = perceive(made.gamma(), kb)
    front, back = (next(h for h in accepted(scene) if right(h, pose)) for _, pose in made.objects)
    assert told(scene) == pytest.approx(numbers(made, scene), abs=1e-9)
    measures = {m.id: m for m in scene.measures()}
    assert measures[back.id].ev_to_B == measures[back.id].ev
    assert all(case in ("A", "B", None) for case in back.cases.values()), "what is behind glass is seen"
    for relation in ("occludes", "partially_occludes", "totally_occludes"):
        assert not any(row.probability for row in scene.query(f"{relation}({front.id}, {back.id})"))


def turned_alike(symmetries):
    """A box that looks the same after half a turn about z: marks in pairs on its sides, and on its top."""
    half = (0.25, 0.15, 0.15)
    corners = [(f"c{i}", "corner", tuple(s * half), tuple(s), 120.0) for i, s in enumerate(SIGNS)]
    pairs = [
        ((0.25, 0.05, 0.02), (1.0, 0.0, 0.0)),
        ((0.1, 0.15, -0.06), (0.0, 1.0, 0.0)),
        ((0.2, 0.1, 0.15), (0.0, 0.0, 1.0)),
    ]
    marks = [
        (f"m{i}{k}", LOOKS[i], (s * x, s * y, z), (s * a, s * b, c), 78.0)
        for i, ((x, y, z), (a, b, c)) in enumerate(pairs)
        for k, s in enumerate((1, -1))
    ]
    return Box(half, (*corners, *marks), symmetries=symmetries)


def test_a_symmetry_that_is_stated_or_not_changes_no_ev(tmp_path):
    half_turn, found = np.diag([-1.0, -1.0, 1.0, 1.0]), {}
    for stated in ("[]", "[{axis: [0, 0, 1], fold: 2}]"):
        types = {"block": turned_alike(stated)}
        made = Scene(types, (("block", standing(0.05, 0.0, 1.8, 0.4)),), missed=((0, "c1"),))
        scene = perceive(made.gamma(), written(tmp_path / str(len(found)), types))
        (h,) = accepted(scene)
        assert right(h, made.objects[0][1], (IDENTITY, half_turn))
        assert told(scene) == pytest.approx(numbers(made, scene), abs=1e-9)
        found[stated] = h.p_ev
        alike = [
            o for o in scene.hypotheses if o.status == "rival" and right(o, made.objects[0][1], (IDENTITY, half_turn))
        ]
        assert not alike or stated == "[]", "a turn that a stated symmetry makes is the same hypothesis"
    assert len(set(found.values())) == 1


def test_an_exact_tie_is_shared_evenly_and_the_first_by_name_is_accepted(tmp_path):
    """Two types that differ in name alone: each world holds one, P = p / (1 + p) of each, the same by symmetry."""
    types = {"alpha": CRATE, "beta": CRATE}
    made = Scene(types, (("alpha", standing(0.1, 0.0, 2.0, 0.4)),), missed=((0, "c1"), (0, "m00")))
    scene = perceive(made.gamma(), written(tmp_path / "kb", types))
    (h,) = accepted(scene)
    assert h.type == "alpha"
    p = numbers(made, scene)[h.id]
    assert h.p_ev == pytest.approx(p, abs=1e-9)
    rivals = [o for o in scene.hypotheses if o.type == "beta" and o.status == "rival"]
    assert len(rivals) == 1
    assert rivals[0].p_ev == pytest.approx(p, abs=1e-9)
    assert (h.probability, rivals[0].probability) == pytest.approx((p / (1 + p), p / (1 + p)), abs=1e-9)
    assert chance(scene, f"(present({h.id}), present({rivals[0].id}))") == 0.0


def test_of_two_that_share_volume_one_is_believed_and_no_world_holds_both(kb):
    """The features of two boxes, one through the other, all seen as if they were glass: no world can hold that (A4)."""
    inner, outer = standing(0.0, 0.0, 2.0, 0.3), standing(0.05, 0.0, 2.0, 0.9)
    glass = {name: Box(kind.half, kind.features, opaque=False) for name, kind in TYPES.items()}
    scene = perceive(Scene(glass, (("can", inner), ("crate", outer)), missed=((1, "c1"),)).gamma(), kb)
    (h,) = accepted(scene)
    assert right(h, outer)
    other = next(o for o in scene.hypotheses if o.type == "can" and right(o, inner))
    assert other.probability == 0.0
    assert any("A4" in step["why"] for step in scene.document["trace"] if step["type"] == "can")
    assert not [world for world in scene.worlds() if len(world.present) > 1]
    assert h.probability == pytest.approx(h.p_ev)


def test_touching_bodies_share_one_world(kb):
    """A can on a crate: their faces meet, and nothing excludes them."""
    low, on_top = standing(0.0, 0.25, 2.4, 0.4), np.eye(4)
    on_top[:3, 3] = 0.05, 0.03, CRATE.half[2] + CAN.half[2]
    made = Scene(TYPES, (("crate", low), ("can", low @ on_top)), missed=((0, "c1"), (1, "c3")))
    scene = perceive(made.gamma(), kb)
    some = accepted(scene)
    assert all(any(right(h, pose) for h in some) for _, pose in made.objects)
    share = numbers(made, scene, "to_B")
    assert len(share) == 2
    assert chance(scene, f"(present({some[0].id}), present({some[1].id}))") == pytest.approx(
        np.prod(list(share.values())), abs=1e-6
    )


def test_noise_alone_is_the_empty_world(kb):
    rng = np.random.default_rng(5)
    rows = tuple((str(rng.choice(("corner", *LOOKS))), *rng.uniform((0, 0), (639, 479))) for _ in range(40))
    scene = perceive(Scene(TYPES, (), extra=rows).gamma(), kb)
    assert not accepted(scene)
    (world,) = scene.worlds()
    assert (world.probability, world.present) == (1.0, ())
    assert set(world.causes.values()) == {"noise"}


@pytest.mark.parametrize(("f", "far"), [(600.0, 1.3), (1200.0, 2.6)])
def test_ranges_of_lobes_scale_by_f_over_f_ref(tmp_path, f, far):
    """Lobes reach 1.3 m at f_ref: of a box there the near features are expected, and at twice f at twice."""
    types = {"crate": box((0.25, 0.2, 0.15), 1, reach=1.3)}
    made = Scene(types, (("crate", standing(0.0, 0.0, far, 0.4)),), f=f)
    _, seen = made.expected("crate", made.objects[0][1])
    wide = Scene({"crate": CRATE}, made.objects, f=f)
    assert 4 <= seen.sum() < wide.expected("crate", made.objects[0][1])[1].sum()
    scene = perceive(made.gamma(), written(tmp_path / "kb", types))
    assert len(accepted(scene)) == 1
    assert told(scene) == pytest.approx(numbers(made, scene), abs=1e-9)


def test_ev_follows_dv_when_another_type_joins_sigma(tmp_path):
    """The same Γ, the same pose: with more corners in Σo a corner that is missed costs less."""
    made = Scene({"crate": CRATE}, (("crate", standing(0.1, 0.0, 2.0, 0.4)),), missed=((0, "c1"),))
    more = Scene({"crate": CRATE, "peg": box((0.03, 0.03, 0.2), 7, marks=0)}, made.objects, missed=made.missed)
    values = []
    for one in (made, more):
        scene = perceive(one.gamma(), written(tmp_path / str(len(values)), one.types))
        (h,) = accepted(scene)
        assert h.p_ev == pytest.approx(numbers(one, scene)[h.id], abs=1e-9)
        values.append(h.p_ev)
    assert values[1] > values[0]
    assert more.dv()["corner"] < made.dv()["corner"]
