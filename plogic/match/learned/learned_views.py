"""Poses of learned types that have little print, proposed from their outlines, creases and colours (``sensing.views``).

What has print is found by its keypoints, in a fraction of the time.

* ``seen_anywhere``: the poses of several types that one photo suggests
"""

from __future__ import annotations

from contextlib import closing
from typing import TYPE_CHECKING

import numpy as np

from geometry.files.remembered import cache_folder
from plogic.base.jobs import each

if TYPE_CHECKING:
    from collections.abc import Sequence

    from geometry.arrays import Floats
    from kb.clouds.learned import LearnedCloud
    from plogic.match.gamma.data import Data
    from plogic.match.learned.learned_models import LearnedIndex

PRINTED = 110.0
"""Keypoints in the mean picture of a type, in learning, from which on it is found by these alone. Of 21 types of YCB
five have up to 73, the others from 125 on; learned from more pictures, as once, up to 102, and from 162 on."""
VIEWS = 400
"""Of a type, from all around."""
SEEN = 3.0
"""Log-likelihood ratio from which pixels convince: 20 to 1, less than of all poses, for they are asked of few that
looks picked. How many have it of what is there, and of what is not, ``python benchmarks/pixel_odds.py KB SCENE``
prints."""
PROPOSED = 20
"""Poses of a type."""


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


def seen_anywhere(indices: Sequence[LearnedIndex], data: Data, processes: int) -> dict[str, Floats]:
    """The poses (N, 4, 4) of each type with little print, by name, the best first."""
    plain = [index for index in indices if index.plain and index.paint is not None]
    if data.photo is None or not plain:
        return {}
    draw(plain, processes)
    from sensing.views.maps import PhotoMaps
    from sensing.views.search import searched, share_maps

    maps = PhotoMaps(data.photo.image)
    share_maps(maps)
    camera = data.camera

    def seen(index: LearnedIndex) -> Floats:
        assert index.body is not None  # noqa: S101 - just looked
        return searched(maps, camera, index.body, PROPOSED)[0]

    with closing(each(seen, plain, processes)) as found:
        return {index.object_type.name: poses for index, poses in zip(plain, found, strict=True)}
