"""One scene of ``plogic bench look-again``, looked at again and again by one policy, until the true world is probable.

* ``Tour``: a scene with the places that any policy may go to, and what was seen from them so far
* ``Policy``: where to go, of the places that are left
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from benchmarks.clutter.scenes import CAMERA
from benchmarks.look_again.from_views import prospect_of_views
from geometry.frames import inverse, pose_error
from plogic.base.clock import Stopwatch
from plogic.cycle.delta import Options
from plogic.match.gamma.data import data_of
from plogic.scene.worlds.ranked_worlds import ranked_worlds
from plogic.sequence.next_view.look import looked_ahead
from plogic.sequence.next_view.moves import Candidate, Stand, ring
from plogic.sequence.views.joint import Found, joint, merged
from plogic.sequence.views.standing import Seen

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from benchmarks.look_again.scenes import Scene
    from plogic.run.perceive import Perceiver
    from plogic.scene.worlds.ranked_worlds import Ranking
    from plogic.sequence.next_view.expected import Prospect
    from plogic.sequence.views.joint import Joint
    from plogic.sequence.views.standing import Standing

    Floats = NDArray[np.float64]

SURE = 0.95
"""Probability of the true world at which a policy may stop."""
MOST_VIEWS = 6
"""Views of a tour; where they leave the true world less probable, one more is counted."""
LISTED = 100
"""Worlds that are looked ahead in."""
TURN, PLACE = np.radians(5.0), 0.05
"""Within which a pose is true: radians, and a share of the distance from the first camera."""
UP = np.array([0.0, 0.0, 1.0])


@dataclass(frozen=True, eq=False)
class State:
    """What some views say together."""

    prospect: Prospect
    ranking: Ranking
    true: float


@dataclass(eq=False)
class Tour:
    """``places``: the present one first.

    What was perceived from a place is kept, so that every policy sees the same there.
    """

    scene: Scene
    perceiver: Perceiver
    places: list[Candidate] = field(default_factory=list)
    found: dict[int, Found] = field(default_factory=dict)
    states: dict[frozenset[int], State] = field(default_factory=dict)

    def state(self, visited: Sequence[int]) -> State:
        """The worlds after views from these places; the order of views changes nothing."""
        key = frozenset(visited)
        if key not in self.states:
            self.states[key] = self._judged(sorted(key))
        return self.states[key]

    def _judged(self, visited: Sequence[int]) -> State:
        looks = [self.look(place) for place in visited]
        together, _ = joint(
            [one.seen for one in looks],
            merged(looks, self.perceiver.models, self.perceiver.kb),
            self.perceiver,
            Options(reading="posterior"),
        )
        ranking = ranked_worlds(together.situation, LISTED)
        return State(
            prospect_of_views(together, ranking, self.perceiver.kb), ranking, true_mass(together, ranking, self.scene)
        )

    def look(self, place: int) -> Found:
        """What is seen from a place, and the hypotheses that it leads to by itself."""
        if place not in self.found:
            pose = self.scene.first if place == 0 else self.places[place].reference_from_camera
            view = self.scene.view(f"v{place}", pose, place)
            delta = self.perceiver.delta(view.gamma, Options(reading="posterior"), Stopwatch())[0]
            data = data_of(view.gamma.appearances, view.gamma.camera, self.perceiver.width)
            self.found[place] = Found(Seen(view, data), tuple(delta.beliefs.values()))
        return self.found[place]


def tour(scene: Scene, perceiver: Perceiver) -> Tour | None:
    """The scene with a ring of places about the middle of what the first view shows; None where it shows nothing."""
    begun = Tour(scene, perceiver)
    if not begun.look(0).beliefs:
        return None
    made, _ = ring(begun.state([0]).prospect, Stand(scene.first, UP, upright=True))
    begun.places = [Candidate("first", scene.first), *made]
    return begun


def true_mass(together: Joint, ranking: Ranking, scene: Scene) -> float:
    """The probability of the worlds that hold what stands there and nothing else, up to identity and pose."""
    whose = {f"h{i}": _true(some, scene) for i, some in enumerate(together.standing, 1)}
    wanted = list(range(len(scene.objects)))
    worlds = [(w.probability, sorted(str(whose[name]) for name in w.present)) for w in ranking.worlds]
    return float(sum(p for p, members in worlds if members == [str(i) for i in wanted]))


def _true(some: Standing, scene: Scene) -> int | None:
    """Which object a hypothesis is true of."""
    camera_from_world = inverse(scene.first)
    for i, one in enumerate(scene.objects):
        turned, moved = pose_error(
            camera_from_world @ some.world_from_object, camera_from_world @ one.pose, some.object_type.symmetries
        )
        far = float(np.linalg.norm((camera_from_world @ one.pose)[:3, 3]))
        if one.kind.name == some.object_type.name and turned <= TURN and moved <= PLACE * far:
            return i
    return None


Policy = Callable[[Tour, Sequence[int]], int]


def left(begun: Tour, visited: Sequence[int]) -> list[int]:
    """Places that were not visited."""
    return [i for i in range(len(begun.places)) if i not in visited]


def greatest_gain(begun: Tour, visited: Sequence[int]) -> int:
    """Ours: the greatest expected reduction of the worlds' entropy."""
    names = {begun.places[i].name: i for i in left(begun, visited)}
    looks = looked_ahead(begun.state(visited).prospect, CAMERA, [begun.places[i] for i in names.values()], seed=0)
    return names[looks[0].candidate.name]


def at_random(begun: Tour, visited: Sequence[int]) -> int:
    """Any of the places left."""
    rng = np.random.default_rng([begun.scene.seed, 2008, len(visited)])
    return int(rng.choice(left(begun, visited)))


def fixed(step: int) -> Policy:
    """Always so many places on; where one was there, to the next that is left."""

    def move(begun: Tour, visited: Sequence[int]) -> int:
        count = len(begun.places)
        return next(i for i in ((visited[-1] + step + k) % count for k in range(count)) if i not in visited)

    return move


def widest(begun: Tour, visited: Sequence[int]) -> int:
    """The place whose nearest visited one is farthest."""
    eyes = np.array([place.reference_from_camera[:3, 3] for place in begun.places])
    apart = {i: min(float(np.linalg.norm(eyes[i] - eyes[j])) for j in visited) for i in left(begun, visited)}
    return max(apart, key=lambda i: (round(apart[i], 6), -i))


def views_needed(begun: Tour, policy: Policy) -> int:
    """How many views until the true world's probability is ``SURE``."""
    visited = [0]
    while begun.state(visited).true < SURE:
        if len(visited) == MOST_VIEWS:
            return MOST_VIEWS + 1
        visited.append(policy(begun, visited))
    return len(visited)
