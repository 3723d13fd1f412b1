"""Which turns of a shape its texture keeps: a learned cloud is turned, and compared with itself, and with new pictures.

A turn of the shape alone means nothing for a can with print on it. So the cloud is turned and must find itself again:
at the turned places features that look alike, from like directions, the same way up. That is cheap, and most turns fail
it. What is left must explain new pictures, which the cloud was not learned from, about as well turned as unturned: also
the unturned cloud finds only a part of itself there, and that part is the measure. What is equally bright is one to the
detectors, whatever its colour.

* ``Trial``: one turn of the shape and how it went, ``Trial(turn, motions, share=0.43, control=0.002, ratio=0.98)``
"""

import io
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from geometry.arrays import Bytes, Floats, Mask
from geometry.frames import motion_about, quat_xyzw_from_rotation, rotation_angle
from kb.clouds.learned import LearnedCloud, read_arrays
from kb.errors import CloudError
from kb.files.schema import SymmetryModel
from kb.learning.again import ALIKE, differences, flat
from kb.learning.observations import Observations
from kb.surfaces.surface import Surface
from kb.surfaces.symmetries import ODD, Turn, motions, turns_of

Indices = NDArray[np.intp]


TOGETHER, SAME_UP, SAME_SIZE = 0.85, 0.8, 0.3
"""Least cosines between directions of view and between ``up``, greatest logarithm of the ratio of sizes, of two that
are alike."""
ROUNDS = (0.025, 0.015, 0.01, 0.006)
"""How far apart, in diameters, counterparts may stand while a motion is settled: scans are no exact shapes, and their
boxes no exact axes."""
SIGMAS = 3.0 * 2.0**0.5
"""How far apart they may stand afterwards, in the cloud's median location noise; both have it."""
BLOCK = 1_000_000
"""Pairs of appearances that are compared at a time."""


def reach_of(cloud: LearnedCloud) -> float:
    """Metres within which two appearances are at one place."""
    return SIGMAS * float(np.median(cloud.sigma))


def counterparts(
    cloud: LearnedCloud, motion: Floats, reach: float, descriptor: Bytes | None = None
) -> tuple[Indices, Indices, Floats]:
    """Appearances, their counterparts after ``motion`` (4, 4), and how far apart the descriptors of the two are.

    ``descriptor`` (L, D) takes the place of those of what is moved.
    """
    R, t = motion[:3, :3], motion[:3, 3]
    axis, up, moving = cloud.axis @ R.T, cloud.up @ R.T, cloud.descriptor if descriptor is None else descriptor
    found: list[tuple[Indices, Indices, Floats]] = []
    for a, b in _near(cloud, cloud.at @ R.T + t, reach):
        like = _alike(axis[a], cloud.axis[b], TOGETHER) & _alike(up[a], cloud.up[b], SAME_UP)
        like &= np.abs(np.log(cloud.size[a] / cloud.size[b])) < SAME_SIZE
        some, its = a[like], b[like]
        apart = differences(moving[some], cloud.descriptor[its])
        close = apart < ALIKE[cloud.descriptor.shape[1]]
        found.append((some[close], its[close], apart[close]))
    none = np.zeros(0, np.intp), np.zeros(0, np.intp), np.zeros(0)
    some, its, apart = (np.concatenate(columns) for columns in zip(none, *found, strict=True))
    return some, its, apart


def _alike(some: Floats, others: Floats, least: float) -> Mask:
    return np.asarray((some * others).sum(axis=1) > least)


def _near(cloud: LearnedCloud, moved: Floats, reach: float) -> Iterator[tuple[Indices, Indices]]:
    """Blocks of pairs of appearances, of features that are ``moved`` (F, 3) to within ``reach`` of others."""
    i, j = flat(cKDTree(cloud.at).query_ball_point(moved, reach, return_sorted=True))
    counts = np.bincount(cloud.feature, minlength=len(cloud.at))
    start, pairs = np.cumsum(counts) - counts, counts[i] * counts[j]
    ends = np.searchsorted(np.cumsum(pairs), np.arange(BLOCK, pairs.sum() + BLOCK, BLOCK), side="left") + 1
    for low, high in zip([0, *ends.tolist()], ends.tolist(), strict=False):
        some, its, size = i[low:high], j[low:high], pairs[low:high]
        which = np.repeat(np.arange(len(some)), size)
        number = np.arange(len(which)) - np.repeat(np.cumsum(size) - size, size)
        width = counts[its][which]
        yield start[some][which] + number // width, start[its][which] + number % width


def share(cloud: LearnedCloud, found: Indices) -> float:
    """What the appearances ``found``, each counted once, are of all, by their hit rates."""
    return float(cloud.hit[np.unique(found)].sum() / max(float(cloud.hit.sum()), 1e-12))


def settled(cloud: LearnedCloud, motion: Floats, diameter: float) -> Floats:
    """The motion (4, 4) moved onto what looks alike, ever more tightly; as it was where there is too little."""
    for near in ROUNDS:
        a, b, apart = counterparts(cloud, motion, near * diameter)
        order = np.lexsort((b, apart, a))
        first = np.unique(a[order], return_index=True)[1]
        if len(first) < 10:
            break
        motion = _fitted(cloud, motion, a[order][first], b[order][first])
    return motion


def _fitted(cloud: LearnedCloud, motion: Floats, a: Indices, b: Indices) -> Floats:
    """The motion that takes the appearances ``a`` nearest to ``b`` (Kabsch), by their hit rates."""
    moved = cloud.at[cloud.feature[a]] @ motion[:3, :3].T + motion[:3, 3]
    there, weight = cloud.at[cloud.feature[b]], np.maximum(cloud.hit[a], 1e-9)
    middle, its = np.average(moved, axis=0, weights=weight), np.average(there, axis=0, weights=weight)
    u, _, v = np.linalg.svd((moved - middle).T @ ((there - its) * weight[:, None]))
    turn = (u @ np.diag([1.0, 1.0, np.sign(np.linalg.det(u @ v))]) @ v).T
    step = np.eye(4)
    step[:3, :3], step[:3, 3] = turn, its - turn @ middle
    return np.asarray(step @ motion)


def seen_again(cloud: LearnedCloud, motion: Floats, seen: Observations, directions: Floats) -> float:
    """Share of the appearances due in new pictures from ``directions`` (V, 3) that they show.

    ``motion`` (4, 4) moves the appearances.

    By hit rates: what the detector would report of the object in this place, if it stood in that.
    """
    R, t = motion[:3, :3], motion[:3, 3]
    at, axis, up = cloud.at @ R.T + t, cloud.axis @ R.T, cloud.up @ R.T
    due, got = 0.0, 0.0
    for view, direction in enumerate(directions):
        held, own = np.flatnonzero(axis @ direction >= np.cos(cloud.half_angle)), np.flatnonzero(seen.view == view)
        due += float(cloud.hit[held].sum())
        if not len(held) or not len(own):
            continue
        i, j = flat(
            cKDTree(seen.at[own]).query_ball_point(at[cloud.feature[held]], reach_of(cloud), return_sorted=True)
        )
        a, b = held[i], own[j]
        like = _alike(up[a], seen.up[b], SAME_UP) & (np.abs(np.log(cloud.size[a] / seen.size[b])) < SAME_SIZE)
        a, b = a[like], b[like]
        shown = np.rint(seen.descriptor[b]).astype(np.uint8)
        close = differences(cloud.descriptor[a], shown) < ALIKE[cloud.descriptor.shape[1]]
        got += float(cloud.hit[np.unique(a[close])].sum())
    return got / max(due, 1e-12)


FOLDS = {0: (0, 4, 3, 2), 4: (4, 2), 2: (2,)}
"""What may be left of a shape's turns (0: any turn) under a texture, the most first."""
LIKELY, CHANCE = 0.1, 3.0
"""Least share of appearances with a counterpart, and how many times that of appearances dealt out anew, for a turn to
be looked into."""
HOLDS, OPEN = 0.9, 0.5
"""Share of what the unturned cloud shows in new pictures: from the one on a turn holds, from the other on nobody
knows."""
STRAY = math.radians(10.0)
"""The axes of a scan's box are no farther off than this."""
DIRECTIONS = 10
"""Viewpoints of the new pictures."""

Verdict = Literal["holds", "ambiguous", "broken"]


@dataclass(frozen=True, eq=False)
class Trial:
    """``motions``: the turns that were tried, (4, 4) each, settled on the cloud.

    Of the worst of them: ``share`` of the appearances, by hit
    rate, with a counterpart; ``control``, the same with all looks dealt out anew; ``ratio`` of what new pictures show
    of the cloud turned and
    unturned, None where nobody looked. ``closes``: whether it makes a group with those before it.
    """

    turn: Turn
    motions: tuple[Floats, ...]
    share: float
    control: float
    ratio: float | None = None
    closes: bool = True

    @property
    def likely(self) -> bool:
        """Whether it is worth new pictures."""
        return self.share >= max(LIKELY, CHANCE * self.control)

    @property
    def verdict(self) -> Verdict:
        """What to do with it: write it, tell it, or forget it."""
        if self.ratio is None or self.ratio < OPEN:
            return "broken"
        return "holds" if self.ratio >= HOLDS and self.closes else "ambiguous"


def trials(cloud: LearnedCloud, surface: Surface) -> list[list[Trial]]:
    """For each turn of the shape what may be left of it, the most first, tried on the cloud alone."""
    rng = np.random.default_rng(0)
    dealt = cloud.descriptor[rng.permutation(len(cloud.feature))]
    turns = turns_of(surface) if len(cloud.feature) else []
    return [
        [_trial(cloud, dealt, replace(turn, fold=fold), surface.diameter) for fold in FOLDS[turn.fold]]
        for turn in turns
    ]


def _trial(cloud: LearnedCloud, dealt: Bytes, turn: Turn, diameter: float) -> Trial:
    angles = ODD if turn.fold == 0 else (2.0 * math.pi / turn.fold,)
    moves = tuple(_settled(cloud, motion_about(turn.axis, turn.at, angle), diameter) for angle in angles)
    shares = [share(cloud, counterparts(cloud, motion, reach_of(cloud))[0]) for motion in moves]
    controls = [share(cloud, counterparts(cloud, motion, reach_of(cloud), dealt)[0]) for motion in moves]
    worst = int(np.argmin(shares))
    return Trial(turn, moves, shares[worst], controls[worst])


def _settled(cloud: LearnedCloud, motion: Floats, diameter: float) -> Floats:
    """The motion settled on the cloud; as it was, where that would make another turn of it."""
    found = settled(cloud, motion, diameter)
    return found if rotation_angle(found[:3, :3] @ motion[:3, :3].T) < STRAY else motion


def judged(
    groups: Sequence[Sequence[Trial]], cloud: LearnedCloud, seen: Observations | None, directions: Floats
) -> list[Trial]:
    """One trial for each turn of the shape: the most that holds, or else what came nearest to it.

    ``seen``: new pictures from ``directions`` (V, 3); None where no trial is likely.
    """
    own = 0.0 if seen is None else seen_again(cloud, np.eye(4), seen, directions)
    result: list[Trial] = []
    for group in groups:
        looked = [_looked(trial, cloud, seen, directions, own) for trial in group]
        nearest = max(looked, key=lambda trial: (trial.ratio or 0.0, trial.share))
        best = next((trial for trial in looked if trial.verdict == "holds"), nearest)
        result.append(replace(best, closes=_close([*result, best])))
    return result


def _close(found: Sequence[Trial]) -> bool:
    """Whether the turns that hold make a group that an ``object.yaml`` may state; the many axes of a ball do not."""
    try:
        motions([SymmetryModel.model_validate(entry) for entry in entries(found)])
    except ValueError:
        return False
    return True


def _looked(trial: Trial, cloud: LearnedCloud, seen: Observations | None, directions: Floats, own: float) -> Trial:
    if seen is None or not trial.likely or not own > 0.0:
        return trial
    return replace(trial, ratio=min(seen_again(cloud, motion, seen, directions) for motion in trial.motions) / own)


def entries(found: Sequence[Trial]) -> list[dict[str, Any]]:
    """The turns that hold as entries of ``object.yaml``.

    Their axes squared to each other, through one point, so that they close.
    """
    held = [trial for trial in found if trial.verdict == "holds"]
    if not held:
        return []
    u, _, v = np.linalg.svd(np.array([_axis(trial) for trial in held]), full_matrices=False)
    at = _plain(_middle(held))
    kinds: list[dict[str, Any]] = [
        {"fold": trial.turn.fold} if trial.turn.fold else {"continuous": True} for trial in held
    ]
    return [{"axis": _plain(axis), **kind, "at": at} for axis, kind in zip(u @ v, kinds, strict=True)]


def _axis(trial: Trial) -> Floats:
    """(3,) the axis of the settled motions, the way round that the shape's was."""
    quats = np.array([quat_xyzw_from_rotation(motion[:3, :3])[:3] for motion in trial.motions])
    quats *= np.where(quats @ np.array(trial.turn.axis) < 0.0, -1.0, 1.0)[:, None]
    total = quats.sum(axis=0)
    return np.asarray(total / np.linalg.norm(total))


def _middle(held: Sequence[Trial]) -> Floats:
    """(3,) the point that all motions move least, and of many such the one next to the shape's middle."""
    moves, start = [motion for trial in held for motion in trial.motions], np.array(held[0].turn.at)
    still = np.concatenate([np.eye(3) - motion[:3, :3] for motion in moves])
    moved = np.concatenate([motion[:3, 3] - (np.eye(3) - motion[:3, :3]) @ start for motion in moves])
    return np.asarray(start + np.linalg.lstsq(still, moved, rcond=1e-3)[0])


def _plain(values: Floats) -> list[float]:
    return [round(float(value), 6) + 0.0 for value in values]


_ROWS = ("axis", "at", "fold", "moves", "share", "control", "ratio", "closes")
MAX_BYTES = 1_000_000
"""Largest file of trials."""


def trials_bytes(tried: Sequence[Trial]) -> bytes:
    """Trials as a file, the same for the same ones: arrays, never pickled."""
    rows: dict[str, Any] = {
        "axis": np.array([trial.turn.axis for trial in tried], np.float64).reshape(-1, 3),
        "at": np.array([trial.turn.at for trial in tried], np.float64).reshape(-1, 3),
        "fold": np.array([trial.turn.fold for trial in tried], np.int64),
        "moves": np.array([len(trial.motions) for trial in tried], np.int64),
        "share": np.array([trial.share for trial in tried], np.float64),
        "control": np.array([trial.control for trial in tried], np.float64),
        "ratio": np.array([np.nan if trial.ratio is None else trial.ratio for trial in tried], np.float64),
        "closes": np.array([trial.closes for trial in tried], np.int64),
        "motions": np.array([motion for trial in tried for motion in trial.motions], np.float64).reshape(-1, 4, 4),
    }
    memory = io.BytesIO()
    np.savez(memory, allow_pickle=False, **rows)
    return memory.getvalue()


def read_trials(content: bytes) -> list[Trial]:
    """The trials of such a file. Raises CloudError where it is not what was written."""
    rows = read_arrays(content, (*_ROWS, "motions"), MAX_BYTES)
    try:
        ends = np.cumsum(rows["moves"])
        motions_of = np.split(rows["motions"], ends[:-1]) if len(ends) else []
        found = [
            Trial(
                Turn(tuple(axis), tuple(at), fold),
                tuple(moves),
                share,
                control,
                None if math.isnan(ratio) else ratio,
                bool(closes),
            )
            for axis, at, fold, share, control, ratio, closes, moves in zip(
                *(rows[name].tolist() for name in _ROWS if name != "moves"), motions_of, strict=True
            )
        ]
        same = trials_bytes(found) == content
    except (ValueError, TypeError, IndexError):
        same = False
    if not same:
        raise CloudError("is no file of trials, or not what was written")
    return found
