"""Derive the facts of space (``plogic.facts.spatial``) and of gravity (``plogic.facts.gravity``) from posed hypotheses.

Space: up, above, on, and A4 in numbers. Up is the world's z where the camera knows its place in the world; else, where
the knowledge base says that gravity holds, away from the plane that two accepted objects or more stand on
(``plogic.cycle.support``); else nobody knows, and nothing is above or on anything.

Gravity: who may hold whom, by where bodies of Δh begin, and which touches which from above, as far as poses are known.
Tolerances are stated, in favour of what stands. Each body gives way by half of what ``on`` allows a pair (``CONTACT``),
or by three standard deviations of its pose at that place and in that direction, where this is more: a hypothesis floats
only if no pose of those that its matches leave would hold it. Contacts are by pybullet, of the bodies' convex parts;
``geometry.bodies.resting`` says what stands in for a scan.
"""

from collections.abc import Iterable, Mapping, Sequence
from itertools import combinations, permutations
from typing import NamedTuple

import numpy as np
import shapely

from geometry.arrays import Floats
from geometry.bodies.columns import STEEP, Body, Contact, above, body_of, stands, steady
from geometry.bodies.depth import parts_of, penetration
from geometry.bodies.overlap import Solid, distance, gap, solid_overlap
from geometry.bodies.resting import Bodies, Shape, Touch, shape_of
from geometry.camera import Camera
from geometry.frames import transform_points
from geometry.poses.refine import turned_step
from geometry.visibility.occlusion import PosedSurface
from geometry.visibility.outline import image_area, outline
from kb.clouds.cloud import KnowledgeBase
from kb.surfaces.surface import Surface
from plogic.cycle.planes import Setting
from plogic.cycle.support import support_of
from plogic.facts.hypothesis import Hypothesis
from plogic.facts.spatial import GROUND, BodyFact, Foot, Gravity, SharedFact, Space, View
from plogic.match.judged.evidence import pose_information
from plogic.match.judged.rivals import solid_of
from plogic.match.judged.type_models import TypeModel
from sensing.simulated.physics import NO_PHYSICS, client, has_physics

Pair = tuple[str, str]


CONTACT = 0.01
"""Share of the distance from the camera, up to which a gap, or a depth, between two bodies is what pose errors make of
contact."""
MOST = 60
"""Hypotheses whose bodies are compared, in the order of Δh; the others are told of by themselves."""
ROUND = 6
"""Decimals of the metres that are written: micrometres."""


class _Placed(NamedTuple):
    """A posed body, ``solid`` where it encloses a volume; ``reach``: distance of its middle, m."""

    name: str
    posed: Hypothesis
    surface: PosedSurface | None
    solid: Solid | None
    reach: float


def space_of_view(
    beliefs: Mapping[str, Hypothesis],
    overlaps: Iterable[tuple[str, str]],
    camera: Camera,
    kb: KnowledgeBase,
    models: Mapping[str, TypeModel],
) -> Space:
    """Of Δh, its hypotheses by id; ``overlaps``: the pairs that A4 excludes from one world."""
    placed = {name: _placed(name, belief) for name, belief in beliefs.items()}
    up, up_from = upward(beliefs.values(), Setting(models, camera, kb))
    apart = {frozenset(pair) for pair in overlaps}
    pairs = [
        (x, y) for x, y in combinations(list(placed.values())[:MOST], 2) if frozenset((x.name, y.name)) not in apart
    ]
    over, on, on_both = ((), (), ()) if up is None else _stacked(pairs, up)
    return Space(
        up=None if up is None else _triple(up),
        up_from=up_from,
        bodies=tuple(_body(one, camera) for one in placed.values()),
        gaps=tuple((x.name, y.name, round(_gap(x, y), ROUND)) for x, y in pairs),
        above=over,
        on=on,
        on_both=on_both,
        shared=tuple(fact for x, y in sorted(overlaps) if (fact := _shared(placed[x], placed[y])) is not None),
    )


def upward(beliefs: Iterable[Hypothesis], setting: Setting) -> tuple[Floats | None, str]:
    """The unit vector (3,), camera frame, against gravity, and what says so; None and '' where nothing does."""
    if setting.camera.world_from_camera is not None:
        return np.asarray(setting.camera.world_from_camera[2, :3]), "T_world_camera"
    if not setting.models:
        return None, ""
    support = support_of([belief for belief in beliefs if belief.status == "accepted"], setting)
    return (None, "") if support is None else (support.plane.up, "support plane")


def _placed(name: str, posed: Hypothesis) -> _Placed:
    surface, reach = posed.object_type.surface, float(np.linalg.norm(posed.middle))
    if surface is None:
        return _Placed(name, posed, None, None, reach)
    solid = None if surface.solid is None else solid_of(surface.solid)
    placed = PosedSurface(surface.vertices, surface.triangles, surface.rays, posed.camera_from_object)
    return _Placed(name, posed, placed, solid, reach)


def _body(one: _Placed, camera: Camera) -> BodyFact:
    middle = one.posed.middle
    nearest = float(np.linalg.norm(middle)) if one.surface is None else distance(one.surface)
    return BodyFact(one.name, _triple(middle), round(nearest, ROUND), _view(one, camera))


def _view(one: _Placed, camera: Camera) -> View:
    """Whether its outline is in the image: wholly, in part, or not at all.

    What reaches behind the camera is not wholly in it.
    """
    if one.surface is None:
        return "inside" if bool(camera.contains(camera.project(one.posed.middle))) else "outside"
    pose, image = one.posed.camera_from_object, image_area(camera)
    shown = outline(one.surface.vertices, one.surface.triangles, pose, camera)
    if shown.is_empty or not shapely.intersects(image, shown):
        return "outside"
    ahead = one.surface.vertices @ pose[2, :3] + pose[2, 3] > 0.0
    return "inside" if bool(ahead.all()) and bool(image.covers(shown)) else "cut"


def _gap(x: _Placed, y: _Placed) -> float:
    """Metres between two bodies; what has no mesh is a point, the middle of its features."""
    if x.surface is not None and y.surface is not None:
        return gap(x.surface, y.surface, (x.solid, y.solid))
    if x.surface is None and y.surface is None:
        return float(np.linalg.norm(x.posed.middle - y.posed.middle))
    point, body = (x, y) if x.surface is None else (y, x)
    assert body.surface is not None  # noqa: S101 - one of the two has one
    return distance(body.surface, point.posed.middle)


def _stacked(
    pairs: Iterable[tuple[_Placed, _Placed]], up: Floats
) -> tuple[tuple[Pair, ...], tuple[Pair, ...], tuple[tuple[str, str, str], ...]]:
    """Who is above whom; who stands on one alone; who stands on two together, and on neither alone."""
    seen: dict[str, Body] = {}

    def bodies(name: str, surface: PosedSurface) -> Body:
        return seen.get(name) or seen.setdefault(name, body_of(surface, up))

    over: list[Pair] = []
    under: dict[str, dict[str, Contact]] = {}
    slack: dict[str, float] = {}
    for pair in pairs:
        for x, y in (pair, pair[::-1]):
            if x.surface is None or y.surface is None or _aside(x, y, up):
                continue
            upper, lower = bodies(x.name, x.surface), bodies(y.name, y.surface)
            tolerance = CONTACT * min(x.reach, y.reach)
            if not above(upper, lower, tolerance):
                continue
            over.append((x.name, y.name))
            contact = stands(upper, lower, tolerance)
            if contact is not None:
                under.setdefault(x.name, {})[y.name] = contact
                slack[x.name] = max(tolerance, slack.get(x.name, 0.0))
    on = [(x, y) for x, below in under.items() for y, contact in below.items() if steady([contact], slack[x])]
    leaning = {x: [y for y in below if (x, y) not in on] for x, below in under.items()}
    both = [
        (x, y, z)
        for x, some in leaning.items()
        for y, z in combinations(some, 2)
        if steady([under[x][y], under[x][z]], slack[x])
    ]
    return tuple(over), tuple(on), tuple(both)


def _aside(x: _Placed, y: _Placed, up: Floats) -> bool:
    """Whether no plumb line can meet both, by the balls around them."""
    way = x.posed.middle - y.posed.middle
    level = way - (way @ up) * up
    sizes = [one.posed.object_type.surface.diameter for one in (x, y) if one.posed.object_type.surface is not None]
    return bool(np.linalg.norm(level) >= 0.5 * sum(sizes))


def _shared(x: _Placed, y: _Placed) -> SharedFact | None:
    """The volume and the depth of two bodies; None where they share nothing, or either has no volume."""
    if x.solid is None or y.solid is None:
        return None
    poses = x.posed.camera_from_object, y.posed.camera_from_object
    found = penetration(x.solid, poses[0], y.solid, poses[1])
    if found is None:
        return None
    volume = solid_overlap(x.solid, poses[0], y.solid, poses[1])
    return SharedFact(x.name, y.name, float(f"{volume:.6g}"), (round(found.low, ROUND), round(found.high, ROUND)))


def _triple(row: Floats) -> tuple[float, float, float]:
    x, y, z = (round(float(value), ROUND) + 0.0 for value in row)
    return x, y, z


SURE = 3.0
"""Standard deviations by which a pose may be wrong: beyond them are 3 in 1000."""
NO_UP = "the camera does not know its place in the world, so nobody knows which way is up"


class Laid(NamedTuple):
    """A posed body in the world: ``allowed`` m of contact, ``covariance`` (6, 6) of its turn and move.

    Rad about its ``middle`` (3,), and metres.
    """

    name: str
    surface: Surface
    world_from_object: Floats
    middle: Floats
    allowed: float
    covariance: Floats

    @property
    def vertices(self) -> Floats:
        """(V, 3) m, world."""
        return transform_points(self.world_from_object, self.surface.vertices)

    def slack(self, way: Floats, at: Floats) -> float:
        """M by which its place ``at`` (3,) may be off along ``way`` (3,), unit, world."""
        row = np.concatenate([np.cross(at - self.middle, way), way])
        return max(self.allowed, SURE * float(np.sqrt(max(row @ self.covariance @ row, 0.0))))

    def most(self) -> float:
        """M, no less than any ``slack`` of its places."""
        turn, move = (float(np.linalg.eigvalsh(self.covariance[part, part])[-1]) for part in (slice(0, 3), slice(3, 6)))
        return self.allowed + SURE * (self.surface.diameter * max(turn, 0.0) ** 0.5 + max(move, 0.0) ** 0.5)


UP = np.array([0.0, 0.0, 1.0])


def gravity_of_view(
    posed: Mapping[str, Hypothesis],
    overlaps: Iterable[Pair],
    camera: Camera,
    kb: KnowledgeBase,
    information: Mapping[str, Floats] | None = None,
) -> Gravity | None:
    """Of Δh, by id; None where the KB does not say that gravity holds.

    ``overlaps``: pairs that A4 excludes from one world, which hold nobody.

    ``information`` (6, 6) each: what is known of the poses, camera axes; left out, what this view tells. It speaks of
    the first ``MOST`` that have a surface.
    """
    if not kb.gravity:
        return None
    world_from_camera = camera.world_from_camera
    if world_from_camera is None or not has_physics():
        return Gravity(kb.unknown_support, kb.ground, silent=NO_UP if world_from_camera is None else NO_PHYSICS)
    known = (
        {name: pose_information(some, camera, kb) for name, some in posed.items()}
        if information is None
        else information
    )
    laid = [
        one
        for name, some in list(posed.items())[:MOST]
        if (one := _laid(name, some, world_from_camera, known[name])) is not None
    ]
    feet = tuple(foot_of(one) for one in laid)
    grounded = [(foot.id, GROUND) for foot in feet if kb.ground is not None and foot.low <= kb.ground]
    return Gravity(kb.unknown_support, kb.ground, feet, (*grounded, *rests_of(laid, overlaps)))


def _laid(name: str, posed: Hypothesis, world_from_camera: Floats, information: Floats) -> Laid | None:
    surface, turn = posed.object_type.surface, turned_step(world_from_camera[:3, :3])
    if surface is None:
        return None
    return Laid(
        name,
        surface,
        world_from_camera @ posed.camera_from_object,
        transform_points(world_from_camera, posed.middle[None])[0],
        0.5 * CONTACT * float(np.linalg.norm(posed.middle)),
        turn @ np.linalg.inv(information) @ turn.T,
    )


def foot_of(one: Laid) -> Foot:
    """Between which heights its lowest place is."""
    lowest = one.vertices[one.vertices[:, 2].argmin()]
    slack = one.slack(UP, lowest)
    return Foot(one.name, round(float(lowest[2] - slack), ROUND), round(float(lowest[2] + slack), ROUND))


def rests_of(laid: Sequence[Laid], apart: Iterable[Pair] = ()) -> tuple[Pair, ...]:
    """The ordered pairs of which the first touches the second from above; ``apart``: who is never together."""
    never = {frozenset(pair) for pair in apart}
    pairs = [(x, y) for x, y in permutations(laid, 2) if frozenset((x.name, y.name)) not in never]
    if not pairs:
        return ()
    shapes = {one.name: shape_in(one.surface, one.world_from_object) for one in laid}
    with client() as (bullet, number):
        bodies = Bodies(bullet, number, shapes, min(one.allowed for one in laid))
        found = {(x.name, y.name): x.middle[2] for x, y in pairs if _rests(x, y, bodies)}
    return tuple(pair for pair, height in found.items() if found.get(pair[::-1], -np.inf) <= height)


def _rests(x: Laid, y: Laid, bodies: Bodies) -> bool:
    (x_low, x_high), (y_low, y_high) = (bodies.shapes[one.name].heights for one in (x, y))
    reach = x.most() + y.most()
    if x_high < y_low or x_low > y_high + reach:
        return False
    solid = not any(bodies.shapes[one.name].rough for one in (x, y))
    return any(_from_above(touch, x, y, x_low - y_high, solid=solid) for touch in bodies.touches(x.name, y.name, reach))


def _from_above(touch: Touch, x: Laid, y: Laid, over: float, *, solid: bool) -> bool:
    """Whether the touch is one, and holds X.

    It is below it, or beside it where X as a whole is ``over`` Y, m, but for what poses may be off.

    Where both are not ``solid``, one of them a hull that stands in, a deep touch is of what the hull adds, for A4 lets
    them be together.
    """
    slack = x.slack(touch.normal, touch.at) + y.slack(touch.normal, touch.at)
    if touch.gap > slack or (touch.gap < -slack and not solid):
        return False
    return bool(touch.normal @ UP >= np.cos(STEEP)) or over >= -x.slack(UP, touch.at) - y.slack(UP, touch.at)


def shape_in(surface: Surface, pose: Floats) -> Shape:
    """A surface at a pose (4, 4): convex parts where it can be cut into them exactly, else its hull."""
    solid = surface.solid
    parts = None if solid is None else parts_of(solid_of(solid))
    exact = parts is not None and parts.exact
    some = [] if parts is None else [transform_points(pose, part) for part in parts.parts]
    return shape_of(some, transform_points(pose, surface.vertices), surface.triangles, exact=exact)
