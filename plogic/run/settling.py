"""``plogic settle``: the best worlds of an interpretation, let go by physics: who stays, falls, tips, slides.

A world that is right stays as it is. Its bodies are the meshes that the interpretation carries, as convex parts where
they can be cut into them exactly, else their hulls (``plogic.cycle.placing.shape_in``). What the world says stands is
first put on what it stands on (``plogic.run.seating``); then bodies are moved out of each other and out of the floor,
then left to gravity for two seconds (``sensing.simulated.settling``). What is free in a world, held by nothing that it
knows, stays where it is unless it is dropped.

* ``Floor(plane, "support plane s1")``: what is below, and who says so
* ``ObjectRow``: one object's verdict, and how far it was moved, in ``settled/1``
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from types import MappingProxyType
from typing import Annotated, Literal, NamedTuple, TypedDict

import numpy as np

from geometry.arrays import Floats
from geometry.bodies.columns import level_axes
from geometry.bodies.resting import Plane, RestingFaces, resting_faces
from geometry.camera_row import Pose
from geometry.frames import inverse, transform_points
from kb.errors import SurfaceError
from kb.surfaces.surface import Surface
from plogic.base.errors import InputError
from plogic.cycle.placing import shape_in
from plogic.cycle.planes import STANDS
from plogic.cycle.support import plane_under
from plogic.facts.carried_rows import MeshRow
from plogic.facts.document import HypothesisRow, Interpretation
from plogic.facts.fact_rows import PlaneRow
from plogic.facts.interpretation import situation_of
from plogic.facts.situation import Situation
from plogic.facts.stances import FREE
from plogic.run.seating import seated
from plogic.scene.readings.standing import Standing
from sensing.simulated.physics import INSTALL, NO_PHYSICS, has_physics
from sensing.simulated.settling import SECONDS, Fate, Loose, filled, let_go

SLACK, SHARE = 0.005, 0.02
"""Metres, and share of the distance from the camera, that an object may move and stand all the same: what poses that
were estimated are off by."""
TILT = 0.26
"""Radians, 15 degrees, by which an object may tilt and stand all the same."""
SINK = 0.6
"""Share of that by which it may sink: heights are off by less than distances (``benchmarks/let_go.py``)."""
NO_UP = (
    "nobody knows which way is up: the interpretation has no support plane, its camera no T_world_camera, "
    "and no two of its objects stand on one plane"
)
DIGITS = 6

Verdict = Literal["stands", "falls", "tips", "slides", "pushed out", "held"]


class ObjectRow(TypedDict):
    """What became of one object; metres and radians."""

    id: Annotated[str, "The hypothesis."]
    type: Annotated[str, "Its object type."]
    verdict: Verdict
    moved: Annotated[float, "How far its middle of mass is from where it was."]
    seated: Annotated[float, "Of that, how far it was put on what it is said to stand on."]
    turned: Annotated[float, "The angle by which it was turned to stand flush there."]
    pushed: Annotated[float, "How far it was pushed out of others or the floor then, before it was let go."]
    fell: Annotated[float, "How much lower its lowest place is than where it was, what it was pushed aside."]
    slid: Annotated[float, "How far its middle of mass went level, likewise."]
    tilted: Annotated[float, "The angle by which it tilted, in all."]
    allowed: Annotated[float, "How far it may move and stand all the same."]
    still: Annotated[bool, "Whether it had come to rest."]
    T_camera_object: Annotated[Pose, "Its pose in the end."]


class LeftOutRow(TypedDict):
    """A hypothesis that physics says nothing of."""

    id: str
    why: str


class FloorRow(TypedDict):
    """What is below, and who says so."""

    plane: PlaneRow
    told_by: str


class SettledWorld(TypedDict):
    """One world, let go."""

    probability: float
    present: list[str]
    floor: FloorRow
    objects: list[ObjectRow]
    left_out: list[LeftOutRow]


class Settled(TypedDict):
    """The document ``settled/1``."""

    format: Literal["settled/1"]
    seconds: float
    worlds: list[SettledWorld]


class Floor(NamedTuple):
    """``plane``, camera frame, with its normal upwards."""

    plane: Plane
    told_by: str

    @property
    def level_from_camera(self) -> Floats:
        """(4, 4) to a frame in which z is up and the floor is at 0."""
        pose = np.eye(4)
        pose[:3, :3], pose[2, 3] = level_axes(self.plane.up), self.plane.offset
        return pose

    @property
    def row(self) -> FloorRow:
        """As plain data."""
        return {
            "plane": {
                "normal": (np.round(self.plane.up, DIGITS) + 0.0).tolist(),
                "offset": round(-self.plane.offset, DIGITS) + 0.0,
            },
            "told_by": self.told_by,
        }


@dataclass(frozen=True)
class Placed:
    """A hypothesis with a body; ``parts`` (V, 3) m, convex, object frame. ``Standing`` of ``plogic.cycle.support``."""

    row: HypothesisRow
    surface: Surface
    parts: tuple[Floats, ...]

    @property
    def pose(self) -> Floats:
        """(4, 4) camera_from_object."""
        return np.array(self.row["T_camera_object"], float)

    @property
    def vertices(self) -> Floats:
        """(V, 3) m, camera frame."""
        return transform_points(self.pose, self.surface.vertices)

    @property
    def corners(self) -> Floats:
        """(V, 3) m, object frame."""
        return self.surface.vertices

    @cached_property
    def allowed(self) -> float:
        """Metres that it may move and stand all the same."""
        return SLACK + SHARE * float(np.linalg.norm(transform_points(self.pose, self.middle[None])[0]))

    @property
    def centre(self) -> Floats:
        """(3,) m, its middle, object frame."""
        return self.surface.centre

    @cached_property
    def resting(self) -> RestingFaces:
        """The faces that it can stand on."""
        return resting_faces(self.surface.vertices)

    @cached_property
    def middle(self) -> Floats:
        """(3,) m, its middle of mass, object frame."""
        mass = filled(self.parts)
        return self.centre if mass is None else mass.middle


def settled(document: Interpretation, worlds: int = 1, *, drop: bool = False) -> Settled:
    """The ``worlds`` best worlds of an interpretation, let go; ``drop``: what is free, too.

    Raises:
        InputError: there is no physics, nobody knows which way is up.
    """
    if not has_physics():
        raise InputError(f"nothing can be let go, for {NO_PHYSICS}: {INSTALL}")
    situation, bodies = situation_of(document), _bodies(document)
    plane = max(document.get("support_planes", ()), key=lambda row: row["probability"], default={"name": ""})["name"]
    listed = [(world["probability"], world["present"]) for world in document.get("worlds", [])[:worlds]]
    return {
        "format": "settled/1",
        "seconds": SECONDS,
        "worlds": [
            _settled_world(document, chance, present, bodies, stances_in(situation, present, plane), drop=drop)
            for chance, present in listed
        ],
    }


class Stances(NamedTuple):
    """``plane``: the name of what a world most probably stands on, '' where nothing says.

    ``free``: who is held there by nothing that is known. ``on``: of each other one what it stands on, as far as told.
    """

    plane: str
    free: frozenset[str]
    on: Mapping[str, str] = MappingProxyType({})


def stances_in(situation: Situation, present: Sequence[str], plane: str = "") -> Stances:
    """How a world stands, by what the interpretation says; ``plane``: where it stands on none that is named.

    It is let go on such a plane all the same, and who is free is who does not stand on that one.
    """
    gravity, support = situation.gravity, situation.support
    free = {name for name in present if gravity is not None and gravity.floating(name, present)}
    if support is None:
        return Stances("", frozenset(free))
    told = (standing := Standing(situation, support)).told(present)
    if plane and told.state not in {one.name for one in support.planes}:
        told = standing.told(present, plane)
    free |= {name for name, stance in told.stances.items() if stance == FREE}
    on = {name: stance.rpartition("/")[0] for name, stance in told.stances.items() if name not in free}
    return Stances(told.state, frozenset(free), on)


def _bodies(document: Interpretation) -> dict[str, Placed | str]:
    """Each hypothesis of Δh with its body, or why it has none."""
    meshes = document.get("assets", {}).get("meshes", {})
    rows = [row for row in document["hypotheses"] if row["status"] != "rejected"]
    shapes = {kind: _shape(meshes.get(kind)) for kind in {row["type"] for row in rows}}
    return {
        row["id"]: shape if isinstance(shape, str) else Placed(row, *shape)
        for row in rows
        for shape in [shapes[row["type"]]]
    }


def _shape(mesh: MeshRow | None) -> tuple[Surface, tuple[Floats, ...]] | str:
    """A carried mesh and its convex parts; or why it is no body."""
    if mesh is None:
        return "the interpretation carries no mesh of its type"
    try:
        surface = Surface(np.array(mesh["vertices"], float), np.array(mesh["triangles"], np.int64))
    except SurfaceError as error:
        return f"its mesh cannot be used: {error}"
    parts = tuple(part for part in shape_in(surface, np.eye(4)).parts if filled([part]) is not None)
    return (surface, parts) if parts else "its mesh has no volume"


def _settled_world(
    document: Interpretation,
    chance: float,
    present: Sequence[str],
    bodies: Mapping[str, Placed | str],
    stances: Stances,
    *,
    drop: bool,
) -> SettledWorld:
    free = frozenset() if drop else stances.free
    placed = [body for name in present if isinstance(body := bodies[name], Placed)]
    floor = floor_of(document, placed, stances.plane)
    level, back = floor.level_from_camera, inverse(floor.level_from_camera)
    before = {one.row["id"]: level @ one.pose for one in placed}
    may = {one.row["id"]: one.allowed for one in placed}
    on = {name: lower for name, lower in stances.on.items() if name in before and lower in (*before, stances.plane)}
    seats = seated({one.row["id"]: one for one in placed}, before, on, level[:3, 3], tilt=TILT, far=may)
    fates = let_go([Loose(name, one.parts, seats[name], name in free) for one in placed for name in [one.row["id"]]])
    return {
        "probability": chance,
        "present": list(present),
        "floor": floor.row,
        "objects": [
            _object(one, (before[name], seats[name]), fates[name], back, held=name in free)
            for one in placed
            for name in [one.row["id"]]
        ],
        "left_out": [{"id": name, "why": why} for name in present if isinstance(why := bodies[name], str)],
    }


def floor_of(document: Interpretation, placed: Sequence[Placed], plane: str = "") -> Floor:
    """What is below some bodies: the support plane of that name, or the likeliest; the ground; what they agree on.

    Where the camera's place is known and the ground's height is not, the ground is where the lowest of them stands.

    Raises:
        InputError: none of these is known.
    """
    planes = document.get("support_planes", [])
    if planes:
        best = max(planes, key=lambda row: (row["name"] == plane, row["probability"]))
        normal = np.array(best["plane"]["normal"], float)
        size = float(np.linalg.norm(normal))
        doubt = "" if best["probability"] >= STANDS else f", P {best['probability']:.2f}"
        return Floor(Plane(normal / size, -best["plane"]["offset"] / size), f"support plane {best['name']}{doubt}")
    world_from_camera = document["camera"].get("T_world_camera") if "camera" in document else None
    if world_from_camera is not None:
        return _ground(document, np.array(world_from_camera, float), placed)
    support = plane_under([(one, one.pose) for one in placed])
    if support is None:
        raise InputError(NO_UP)
    who = ", ".join(placed[i].row["id"] for i in support.by)
    return Floor(support.plane, f"what {who} stand on")


def _ground(document: Interpretation, world_from_camera: Floats, placed: Sequence[Placed]) -> Floor:
    up, height = world_from_camera[2, :3], float(world_from_camera[2, 3])
    gravity = document.get("gravity")
    if gravity is not None and gravity["ground"] is not None:
        return Floor(Plane(up, height - gravity["ground"]), "ground")
    lows = {one.row["id"]: float((one.vertices @ up).min()) for one in placed}
    lowest = min(lows, key=lambda name: (lows[name], name), default="")
    return Floor(Plane(up, -lows.get(lowest, -height)), f"lowest object {lowest}" if lowest else "T_world_camera")


def _object(
    one: Placed, start: tuple[Floats, Floats], fate: Fate, camera_from_level: Floats, *, held: bool
) -> ObjectRow:
    """Its verdict; ``start``: where it was (4, 4), and where it was seated, level frame."""
    poses = (*start, fate.pushed, fate.after)
    middles = [transform_points(pose, one.middle[None])[0] for pose in poses]
    lows = [transform_points(pose, one.corners)[:, 2].min() for pose in poses]
    moves = {
        "moved": float(np.linalg.norm(middles[3] - middles[0])),
        "seated": float(np.linalg.norm(middles[1] - middles[0])),
        "turned": _tilt(poses[0], poses[1]),
        "pushed": float(np.linalg.norm(middles[2] - middles[1])),
        "fell": max(0.0, float(lows[0] - lows[1] + lows[2] - lows[3])),
        "slid": float(np.linalg.norm((middles[1] - middles[0] + middles[3] - middles[2])[:2])),
        "tilted": _tilt(poses[0], poses[3]),
        "allowed": one.allowed,
    }
    return {
        "id": one.row["id"],
        "type": one.row["type"],
        "verdict": "held" if held else verdict_of(moves),
        **{key: round(value, DIGITS) for key, value in moves.items()},  # type: ignore[typeddict-item] # the keys of moves
        "still": fate.still,
        "T_camera_object": np.round(camera_from_level @ fate.after, 9).tolist(),
    }


def _tilt(one: Floats, other: Floats) -> float:
    """The angle between what is up in a body at one pose (4, 4) and at another, level frame."""
    return float(np.arccos(np.clip((other[:3, :3] @ one[:3, :3].T)[2, 2], -1.0, 1.0)))


def verdict_of(moves: Mapping[str, float]) -> Verdict:
    """By how far it moved in each way: the first of these that is more than it may.

    | pushed > allowed | fell > ``SINK`` allowed | tilted > ``TILT`` | slid > allowed | else |
    |---|---|---|---|---|
    | pushed out | falls | tips | slides | stands |
    """
    allowed = moves["allowed"]
    ways: tuple[tuple[Verdict, bool], ...] = (
        ("pushed out", moves["pushed"] > allowed),
        ("falls", moves["fell"] > SINK * allowed),
        ("tips", moves["tilted"] > TILT),
        ("slides", moves["slid"] > allowed),
    )
    return next((verdict for verdict, holds in ways if holds), "stands")
