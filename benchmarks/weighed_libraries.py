"""Measure libraries that were weighed for gaps, depths, convex parts and robot descriptions against our own code.

Run as ``python benchmarks/weighed_libraries.py`` where ``pip install python-fcl coal coacd yourdfpy defusedxml`` went
before; none of them is a dependency. The table that it prints is in docs/dependencies.md.
"""

import argparse
import time
import tracemalloc
from collections.abc import Callable, Iterator
from functools import partial
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from statistics import median
from typing import Any

import numpy as np
import shapely
import trimesh

from geometry.arrays import Floats
from geometry.bodies.depth import convex_parts, parts_of, penetration
from geometry.bodies.overlap import Solid, gap
from geometry.frames import from_rotation_translation, rotation_from_quat_xyzw
from geometry.visibility.occlusion import PosedSurface
from geometry.visibility.rays import RayMesh
from kb.errors import IntakeError
from kb.intake.robots import merged, read_xml, urdf_visuals

PEERS = {"python-fcl": "fcl", "coal": "coal", "coacd": "coacd", "yourdfpy": "yourdfpy", "defusedxml": "defusedxml"}
"""Packages and their modules."""
PAIRS = 100
"""Pairs of bodies of each kind."""


def solids(concave: bool) -> tuple[Solid, Solid]:  # noqa: FBT001 - one of two kinds
    """An L and a smaller one, or two convex bodies of 20 and 12 facets; about 10 cm."""
    if not concave:
        ball = trimesh.creation.icosahedron()
        box = trimesh.creation.box((0.1, 0.06, 0.04))
        return Solid(np.asarray(ball.vertices) * 0.06, ball.faces), Solid(box.vertices, box.faces)
    outline = shapely.Polygon([(0, 0), (0.1, 0), (0.1, 0.05), (0.05, 0.05), (0.05, 0.1), (0, 0.1)])
    shape = trimesh.creation.extrude_polygon(outline, 0.05)
    shape.apply_translation((-0.035, -0.035, -0.025))
    return Solid(shape.vertices, shape.faces), Solid(0.8 * np.asarray(shape.vertices), shape.faces)


def poses(away: float) -> Iterator[Floats]:
    """Poses (4, 4) of the second body about ``away`` m from the first, turned at random."""
    rng = np.random.default_rng(0)
    for _ in range(PAIRS):
        way = rng.normal(size=3)
        turn = rotation_from_quat_xyzw(rng.normal(size=4))
        yield from_rotation_translation(turn, away * way / np.linalg.norm(way))


def timed(call: Callable[[], float]) -> tuple[float, float]:
    """What a call gives, and its milliseconds."""
    start = time.perf_counter()
    value = call()
    return value, 1000.0 * (time.perf_counter() - start)


def own_gap(solids: tuple[Solid, Solid], one: PosedSurface, other: PosedSurface) -> float:
    """The gap by ours, m."""
    return gap(one, other, solids)


def own_depth(solids: tuple[Solid, Solid], one: PosedSurface, other: PosedSurface) -> float:
    """The depth by ours, m."""
    deep = penetration(solids[0], one.camera_from_object, solids[1], other.camera_from_object)
    return 0.0 if deep is None else deep.high


def fcl_pair(one: Solid, other: Solid) -> tuple[Callable[[Floats], float], Callable[[Floats], float]]:
    """The gap, and the greatest depth of contacts, of two triangle meshes by python-fcl, m."""
    fcl = import_module("fcl")

    def model(solid: Solid) -> Any:  # noqa: ANN401 - fcl is untyped
        mesh = fcl.BVHModel()
        mesh.beginModel(len(solid.triangles), len(solid.vertices))
        mesh.addSubModel(solid.vertices, solid.triangles)
        mesh.endModel()
        return mesh

    first, second = fcl.CollisionObject(model(one)), model(other)

    def placed(pose: Floats) -> Any:  # noqa: ANN401 - fcl is untyped
        return fcl.CollisionObject(second, fcl.Transform(pose[:3, :3].copy(), pose[:3, 3].copy()))

    def depth(pose: Floats) -> float:
        result = fcl.CollisionResult()
        fcl.collide(first, placed(pose), fcl.CollisionRequest(num_max_contacts=1000, enable_contact=True), result)
        return max((abs(contact.penetration_depth) for contact in result.contacts), default=0.0)

    return lambda pose: fcl.distance(first, placed(pose), fcl.DistanceRequest(), fcl.DistanceResult()), depth


def coal_pair(one: Solid, other: Solid) -> tuple[Callable[[Floats], float], Callable[[Floats], float]]:
    """The gap and the depth by coal, m: of triangle meshes the gap, of the hulls of both the depth."""
    coal = import_module("coal")

    def mesh(solid: Solid) -> Any:  # noqa: ANN401 - coal is untyped
        model = coal.BVHModelOBBRSS()
        model.beginModel(len(solid.triangles), len(solid.vertices))
        points = coal.StdVec_Vec3s()
        points.extend(np.array(place) for place in solid.vertices)
        corners = coal.StdVec_Triangle()
        corners.extend(coal.Triangle(*map(int, row)) for row in solid.triangles)
        model.addSubModel(points, corners)
        model.endModel()
        return model

    def hull(solid: Solid) -> Any:  # noqa: ANN401 - coal is untyped
        model = mesh(solid)
        model.buildConvexHull(True, "Qt")  # noqa: FBT003 - positional in coal
        return model.convex

    meshes, hulls, still = (mesh(one), mesh(other)), (hull(one), hull(other)), coal.Transform3s()

    def asked(pair: tuple[Any, Any], pose: Floats) -> float:
        there = coal.Transform3s(pose[:3, :3].copy(), pose[:3, 3].copy())
        request, result = coal.DistanceRequest(), coal.DistanceResult()
        request.enable_signed_distance = True
        return float(coal.distance(pair[0], still, pair[1], there, request, result))

    return lambda pose: max(asked(meshes, pose), 0.0), lambda pose: max(-asked(hulls, pose), 0.0)


def pairs() -> Iterator[str]:
    """Lines about gaps and depths."""
    for concave in (False, True):
        first, second = solids(concave)
        bodies = [(solid, RayMesh(solid.vertices, solid.triangles)) for solid in (first, second)]
        peers = {"python-fcl": fcl_pair(first, second), "coal": coal_pair(first, second)}
        kind = "an L and a smaller L" if concave else "two convex bodies"
        for number, (what, away) in enumerate((("gap", 0.2), ("depth", 0.05))):
            told: dict[str, list[tuple[float, float]]] = {name: [] for name in ("ours", *peers)}
            for pose in poses(away):
                posed = [
                    PosedSurface(solid.vertices, solid.triangles, rays, at)
                    for (solid, rays), at in zip(bodies, (np.eye(4), pose), strict=True)
                ]

                told["ours"].append(timed(partial(own_gap if what == "gap" else own_depth, (first, second), *posed)))
                for name, calls in peers.items():
                    told[name].append(timed(partial(calls[number], pose)))
            right = np.array([value for value, _ in told["ours"]])
            for name, rows in told.items():
                off = np.abs(np.array([value for value, _ in rows]) - right)
                free = remaining(first, second, [value for value, _ in rows]) if what == "depth" and concave else ""
                yield f"{what} of {kind}: {name}: {median(ms for _, ms in rows):.3f} ms, at most {1000 * off.max():.3g} mm from ours{free}"


def remaining(first: Solid, second: Solid, depths: list[float]) -> str:
    """How many of the depths are too small: no move by so much, in any of 2,000 directions, leaves the bodies free."""
    ways = np.random.default_rng(1).normal(size=(2000, 3))
    ways /= np.linalg.norm(ways, axis=1, keepdims=True)
    short = 0
    for pose, depth in zip(poses(0.05), depths, strict=True):
        if not first.shared(pose, second) > 0.0:
            continue
        moves = (from_rotation_translation(pose[:3, :3], pose[:3, 3] + 1.02 * depth * way) for way in ways)
        short += all(first.shared(move, second) > 0.0 for move in moves)
    return f", {short} of {len(depths)} free nothing when moved by 1.02 of them"


def parts() -> Iterator[str]:
    """Lines about convex parts: how many, how far their volumes together are from the body's, and the time."""
    coacd = import_module("coacd")
    coacd.set_log_level("off")
    ring = trimesh.creation.annulus(0.03, 0.05, 0.02, sections=16)
    foot, wall = trimesh.creation.box((0.1, 0.1, 0.03)), trimesh.creation.box((0.03, 0.1, 0.1))
    wall.apply_translation((0.035, 0.0, 0.035))
    union = trimesh.boolean.union([foot, wall])
    bodies = {
        "an L": solids(concave=True)[0],
        "two boxes made one": Solid(union.vertices, union.faces),
        "a ring of 16 sides": Solid(ring.vertices, ring.faces),
    }
    for name, solid in bodies.items():
        parts_of.cache_clear()
        start = time.perf_counter()
        own = convex_parts(solid.body)
        yield told_parts(f"{name}: ours, exact: {own.exact}", own.parts, solid, time.perf_counter() - start)
        start = time.perf_counter()
        found = coacd.run_coacd(coacd.Mesh(solid.vertices, solid.triangles), threshold=0.01)
        yield told_parts(f"{name}: coacd", [corners for corners, _ in found], solid, time.perf_counter() - start)


def told_parts(name: str, found: Any, solid: Solid, seconds: float) -> str:  # noqa: ANN401 - of either
    """A line about convex parts."""
    volume = sum(trimesh.convex.convex_hull(np.asarray(corners)).volume for corners in found)
    return f"parts of {name}: {len(found)}, {100 * (volume / solid.volume - 1):+.2f} % of the volume, {1000 * seconds:.1f} ms"


def described() -> Iterator[str]:
    """Lines about robot descriptions: those that pybullet brings, and hostile ones."""
    yourdfpy = import_module("yourdfpy")
    folder = Path(str(import_module("pybullet_data").getDataPath()))
    files = sorted(folder.glob("**/*.urdf"))
    counts = {
        "read by both, of one extent": 0,
        "read by both, of another extent": 0,
        "ours alone": 0,
        "yourdfpy alone": 0,
    }
    times: tuple[list[float], list[float]] = ([], [])
    for file in files:
        mine, own = timed_extent(partial(own_extent, file))
        theirs, its = timed_extent(partial(peer_extent, yourdfpy, file))
        if mine is not None and theirs is not None:
            alike = bool(np.allclose(mine, theirs, rtol=1e-3, atol=1e-4))
            counts["read by both, of one extent" if alike else "read by both, of another extent"] += 1
            times[0].append(own)
            times[1].append(its)
        elif mine is not None or theirs is not None:
            counts["ours alone" if theirs is None else "yourdfpy alone"] += 1
    yield f"{len(files)} URDFs of pybullet_data: {counts}; median ours {median(times[0]):.0f} ms, yourdfpy {median(times[1]):.0f} ms"
    yield from hostile(yourdfpy)


def own_extent(file: Path) -> Floats:
    """The sides (3,) of the box, m, by ours."""
    return np.ptp(merged(file, urdf_visuals(file)).whole[0], axis=0)


def peer_extent(yourdfpy: Any, file: Path) -> Floats:  # noqa: ANN401 - untyped
    """The sides (3,) of the box, m, by yourdfpy."""
    robot = yourdfpy.URDF.load(str(file), build_collision_scene_graph=False)
    return np.asarray(robot.scene.extents, float).reshape(3)


def timed_extent(call: Callable[[], Floats]) -> tuple[Floats | None, float]:
    """What a call gives, None where it fails, and its milliseconds."""
    start = time.perf_counter()
    try:
        found = call()
    except Exception:  # noqa: BLE001 - whatever a peer raises
        found = None
    return found, 1000.0 * (time.perf_counter() - start)


BOMB = '<!DOCTYPE r [<!ENTITY a "{}">{}]><robot name="&z;"><link name="a"/></robot>'
HOSTILE = {
    "entities": BOMB.format("a" * 100, '<!ENTITY z "' + "&a;" * 2000 + '">'),
    "50,000 levels": "<robot>" + "<link>" * 50_000 + "</link>" * 50_000 + "</robot>",
    "joints in a circle": '<robot name="r"><link name="a"/><link name="b"/>'
    + "".join(
        f'<joint name="{p}{c}" type="fixed"><parent link="{p}"/><child link="{c}"/></joint>' for p, c in ("ab", "ba")
    )
    + "</robot>",
    "a size that is no number": '<robot name="r"><link name="a"><visual><geometry><box size="1 nan 1"/></geometry></visual></link></robot>',
}


def hostile(yourdfpy: Any) -> Iterator[str]:  # noqa: ANN401 - untyped
    """Lines about what each makes of hostile descriptions."""
    defused = import_module("defusedxml.ElementTree")
    for name, text in HOSTILE.items():
        file = Path("hostile.urdf").absolute()
        file.write_text(text)
        calls: dict[str, Callable[[], object]] = {
            "ours": lambda: merged(file, urdf_visuals(file)),  # noqa: B023 - called at once
            "yourdfpy": lambda: yourdfpy.URDF.load(str(file)),  # noqa: B023 - called at once
            "our XML": lambda: read_xml(file),  # noqa: B023 - called at once
            "defusedxml": lambda: defused.fromstring(text),  # noqa: B023 - called at once
        }
        try:
            yield f"{name}: " + ", ".join(f"{who}: {answer(call)}" for who, call in calls.items())
        finally:
            file.unlink()


def answer(call: Callable[[], object]) -> str:
    """Read or refused, in a word and MB at most."""
    tracemalloc.start()
    try:
        call()
        said = "read"
    except IntakeError:
        said = "refused with the reason"
    except Exception as error:  # noqa: BLE001 - whatever a peer raises
        said = type(error).__name__
    most = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    return f"{said} ({most / 1e6:.1f} MB)"


def main() -> None:
    """Print all lines, or name what is not installed."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.parse_args()
    missing = [package for package, module in PEERS.items() if find_spec(module) is None]
    if missing:
        parser.error(f"needs packages that are not installed: pip install {' '.join(missing)}")
    for lines in (pairs(), parts(), described()):
        for line in lines:
            print(line, flush=True)  # noqa: T201 - a script


if __name__ == "__main__":
    main()
