"""Poses of learned types that have little print, proposed from their outlines, creases and colours (``sensing.views``).

What has print is found by its keypoints, in a fraction of the time; on a plane, where few poses are possible, by its
views as well.

* ``maps_for``: what all types ask of a photo; ``seen_anywhere``: the poses of a type that it suggests; ``seen_on``:
  those on a plane
"""

from __future__ import annotations

from contextlib import closing
from typing import TYPE_CHECKING

import numpy as np

from geometry.files.remembered import cache_folder
from plogic.base.jobs import each
from plogic.match.learned.learned_pixels import NOT_SEEN, Seen

if TYPE_CHECKING:
    from collections.abc import Sequence

    from geometry.bodies.standing import Known
    from kb.clouds.learned import LearnedCloud
    from plogic.match.gamma.data import Data
    from plogic.match.learned.learned_models import LearnedIndex
    from sensing.views.maps import PhotoMaps

PRINTED = 135.0
"""Keypoints in the mean picture of a type, in learning, from which on it is found by these alone. Of what shows no
print an egg box has 131 for its folds, others up to 89; of what does, two have 125 and the others 145 and more."""
VIEWS = 400
"""Of a type, from all around."""
SEEN = 3.0
"""Log-likelihood ratio from which pixels convince before all types were searched for (``convincing``): 20 to 1. How
many have it of what is there, and of what is not, ``python benchmarks/pixel_odds.py KB DATASET`` prints."""
PROPOSED, PROPOSED_ON, PROPOSED_BESIDE, PROPOSED_ON_TOP = 20, 100, 10, 4
"""Poses of a type, anywhere, on a plane, there of one that has print, and on a top."""


def keypoints_shown(cloud: LearnedCloud) -> float:
    """How many keypoints of a type a picture of it shows, on average over all directions."""
    share = cloud.hit * (1.0 - np.cos(cloud.half_angle)) / 2.0
    return float(share[~cloud.sided].sum())


def draw(indices: Sequence[LearnedIndex], processes: int) -> None:
    """Draw the views of types where they are not kept yet; copies of this process keep theirs on disk."""
    new = [index for index in indices if "body" not in vars(index)]
    if cache_folder("views") is not None:
        with closing(each(lambda index: index.body is None, new, processes)) as drawn:
            list(drawn)
    for index in new:
        _ = index.body


def maps_for(indices: Sequence[LearnedIndex], data: Data, processes: int) -> PhotoMaps | None:
    """What types ask of a photo, measured before copies of this process are made; None without one.

    The views of those with little print are drawn as well.
    """
    painted = [index for index in indices if index.paint is not None]
    if data.photo is None or not painted:
        return None
    from sensing.views.maps import PhotoMaps
    from sensing.views.search import share_maps

    maps, plain = PhotoMaps(data.photo.small.image), [index for index in painted if index.plain]
    draw(plain, processes)
    if plain:  # else hardly any is searched, and on planes alone
        share_maps(maps)
    return maps


def seen_anywhere(index: LearnedIndex, maps: PhotoMaps | None, data: Data) -> Seen:
    """The poses of a type that a photo's maps suggest, the best first; none of what has print."""
    if maps is None or data.photo is None or not index.plain or index.body is None:
        return NOT_SEEN
    from sensing.views.search import searched

    return Seen(*searched(maps, data.photo.small.camera, index.body, PROPOSED))


def seen_on(index: LearnedIndex, maps: PhotoMaps | None, data: Data, supports: Sequence[Known]) -> list[Seen]:
    """The poses of a type on each of planes below the camera that a photo's maps suggest, the best first."""
    if maps is None or data.photo is None or index.body is None:
        return [NOT_SEEN] * len(supports)
    from sensing.views.maps import TypeMaps
    from sensing.views.standing import stood

    mine = TypeMaps(maps, index.body.views)
    on = PROPOSED_ON if index.plain else PROPOSED_BESIDE
    camera = data.photo.small.camera
    most = (on if known.area is None else PROPOSED_ON_TOP for known in supports)
    return [
        Seen(*stood(mine, camera, index.body, known, index.resting, some))
        for known, some in zip(supports, most, strict=True)
    ]
