"""Who may hold whom, by geometry (``plogic.facts.spatial``): where bodies of Δh begin, and which touches which from above, as far as poses are known.

Tolerances are stated, in favour of what stands. Each body gives way by half of what ``on`` allows a pair
(``plogic.cycle.placing.CONTACT``), or by three standard deviations of its pose at that place and in that direction,
where this is more: a hypothesis floats only if no pose of those that its matches leave would hold it. Contacts are by
pybullet, of the bodies' convex parts; ``geometry.bodies.resting`` says what stands in for a scan.
"""

from __future__ import annotations

from itertools import permutations
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from geometry.bodies.columns import STEEP
from geometry.bodies.depth import parts_of
from geometry.bodies.resting import Bodies, shape_of
from geometry.frames import transform_points
from geometry.poses.refine import turned_step
from plogic.cycle.placing import CONTACT, MOST, ROUND
from plogic.facts.spatial import GROUND, Foot, Gravity
from plogic.match.judged.disjoint import pose_information
from plogic.match.judged.rivals import solid_of
from sensing.simulated.physics import NO_PHYSICS, client, has_physics

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping, Sequence

    from numpy.typing import NDArray

    from geometry.bodies.resting import Shape, Touch
    from geometry.camera import Camera
    from kb.clouds.cloud import KnowledgeBase
    from kb.surfaces.surface import Surface
    from plogic.facts.hypothesis import Hypothesis

    Floats = NDArray[np.float64]
    Pair = tuple[str, str]

SURE = 3.0
"""Standard deviations by which a pose may be wrong: beyond them are 3 in 1000."""
NO_UP = "the camera does not know its place in the world, so nobody knows which way is up"


class Laid(NamedTuple):
    """A posed body in the world: ``allowed`` m of contact, ``covariance`` (6, 6) of turning about its ``middle`` (3,), rad, and moving, m."""

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
    middle = transform_points(world_from_camera, posed.middle[None])[0]
    allowed = 0.5 * CONTACT * float(np.linalg.norm(posed.middle))
    return Laid(
        name,
        surface,
        world_from_camera @ posed.camera_from_object,
        middle,
        allowed,
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
    shapes = {one.name: _shape(one) for one in laid}
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
    """Whether the touch is one, and holds X: it is below it, or beside it where X as a whole is ``over`` Y, m, but for what poses may be off.

    Where both are not ``solid``, one of them a hull that stands in, a deep touch is of what the hull adds, for A4 lets
    them be together.
    """
    slack = x.slack(touch.normal, touch.at) + y.slack(touch.normal, touch.at)
    if touch.gap > slack or (touch.gap < -slack and not solid):
        return False
    return bool(touch.normal @ UP >= np.cos(STEEP)) or over >= -x.slack(UP, touch.at) - y.slack(UP, touch.at)


def _shape(one: Laid) -> Shape:
    solid = one.surface.solid
    parts = None if solid is None else parts_of(solid_of(solid))
    exact = parts is not None and parts.exact
    some = [] if parts is None else [transform_points(one.world_from_object, part) for part in parts.parts]
    return shape_of(some, one.vertices, one.surface.triangles, exact=exact)
