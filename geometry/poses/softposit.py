"""SoftPOSIT: pose and correspondence at once, from model points and image points of which nobody knows which is which.

Source: David, DeMenthon, Duraiswami and Samet, SoftPOSIT: Simultaneous Pose and Correspondence Determination, IJCV
59(3), 2004 (formalism §6.2). With S_k = (P_k, 1) of the model, Q1 = (R1, Tx) / Tz and Q2 = (R2, Ty) / Tz of the pose,
and w_k = 1 + R3 . P_k / Tz, a pair of a model point k and an image point j = (x, y) is off by  d_jk^2 = (Q1 . S_k - w_k
x_j)^2 + (Q2 . S_k - w_k y_j)^2,  and

    E = sum_jk m_jk (d_jk^2 - alpha)

is lowered in turn in the assignment m (softassign: m_jk = g exp(-beta (d_jk^2 - alpha)), with a slack row and column of
g = 1 / (max(N, M) + 1), normalised by Sinkhorn), in Q1 and Q2 (linear: the sum L of m'_k S_k S_k^T is inverted, m'_k =
sum_j m_jk), and in w; beta grows by 5 % a step.

**Convergence does not mean that the pose is right: check the match count.** A local minimum converges as well as the
true pose does. Without types few random starts find it; the more types there are, the more do.

Ours, not the paper's: `allowed` pairs, for features that have types; many starts annealed together; starts given by the
caller, so that it refines a near pose too (then with a greater `beta`: a small one forgets the start); w_k kept
positive; matches taken at the end as those of m > 1/2 at `beta_final`, whatever the beta at which the start ended. Not
done: the paper's decision tree that gives a start up early by its match count so far; the tweak in the authors'
published program that holds the slack of maximal pairs. Coplanar models are beyond it: L is singular.

SoftPOSIT from many starts: random ones, one after the other until enough points are matched.

Source: David et al. 2004 (formalism §6.2), random-start SoftPOSIT: a local minimum is met more often than not, and only
the match count tells.
"""

from collections.abc import Callable
from dataclasses import dataclass, fields

import numpy as np
from numpy.typing import ArrayLike

from geometry.arrays import Floats, Ints, Mask, last_axes
from geometry.errors import GeometryError
from geometry.frames import from_rotation_translation, rotation_from_quat_xyzw
from geometry.poses.posit import turned
from geometry.poses.sinkhorn import Assignment, Pairs, pairs_of, sinkhorn, sums_per_model

BLOCK = 50_000  # pairs x starts that are annealed together: what a processor's cache holds was the fastest
SINGULAR = (
    1e-10  # least over greatest eigenvalue of L (or over 1, the mass of one match) below which a start is given up
)
STRAIGHT = 1e-9  # how far from orthonormal a rotation may come out
ROUGH = 1e-3  # how far from a rotation a start may be
HUGE = 1e6  # a start's greatest entry, and the sizes and depths of the image beyond which it lies nowhere
NEARER, FARTHER = -0.95, 20.0  # bounds of w - 1, as in `geometry.poses.posit`
EXPONENT = 100.0  # bound of |beta (d^2 - alpha)|: what is smaller than exp(-100) is nothing
MATCHED = 0.51  # m above which a pair is a match: above both slacks and all rivals, as rows and columns sum to 1
LEAST_MATCHED = 4  # matches below which a pose is not determined


@dataclass(frozen=True)
class Annealing:
    """The schedule of beta, and what counts as near; lengths in the image are in pixels of the size `pixel`."""

    beta: float = 2e-4  # 1/px^2 at the start: about 1 / (how far off the points may be)^2
    beta_final: float = 0.5  # 1/px^2
    rate: float = 1.05  # by which beta grows each step
    noise: float = 0.5  # px, standard deviation of an image point in each axis
    patience: int = 20  # steps before a start may end as converged
    pixel: float = 1 / 600  # in normalised units: 1 / focal length

    @property
    def alpha(self) -> float:
        """d^2 in px^2 below which a match is better than none: the 99 % quantile at `noise`, and 1 for good measure."""
        return 9.21 * self.noise**2 + 1.0

    @property
    def nearest(self) -> float:
        """The rms d in px below which the pose counts as converged."""
        return float(np.sqrt(self.alpha) / 2)


@dataclass(frozen=True, eq=False)
class SoftPositResult:
    """Poses of K starts, each proper, orthonormal and with the model's middle before the camera.

    Not `converged` ones mean nothing.
    """

    camera_from_object: Floats  # (K, 4, 4)
    matches: Ints  # (K, N) the image point of each model point, or -1; no image point twice
    count: Ints  # (K,) matches: what says whether the pose is right
    error: Floats  # (K,) mean squared distance of reprojection over the matches, normalised units^2; inf without any or with one behind
    converged: Mask  # (K,) near (`Annealing.nearest`), by at least four matches, all before the camera


@dataclass(frozen=True, eq=False)
class _Problem:
    points: Floats  # (N, 4) S_k: about their middle, in units of `size`
    xy: Floats  # (M', 2) px, of the image points that any model point may be
    of_image: Ints  # (M',) which they are of the M
    pairs: Pairs  # of N and M'
    slack: float  # g = 1 / (max(N, M) + 1)
    annealing: Annealing
    middle: Floats  # (3,) m, object frame
    size: float  # m


@dataclass(frozen=True, eq=False)
class _State:
    """K starts on their way: Q1 = (zoom R1, shift x), Q2 = (zoom R2, shift y), both in px, of the scaled points."""

    rotation: Floats  # (K, 3, 3)
    zoom: Floats  # (K,) size / Tz / pixel
    shift: Floats  # (K, 2) (Tx, Ty) / Tz / pixel
    columns: Floats  # (K, M') where Sinkhorn ended

    def of(self, which: Ints) -> "_State":
        return _State(self.rotation[which], self.zoom[which], self.shift[which], self.columns[which])

    def put(self, which: Ints, other: "_State") -> None:
        """Write the starts `which` of `other` into this one."""
        self.rotation[which], self.zoom[which], self.shift[which], self.columns[which] = (
            other.rotation,
            other.zoom,
            other.shift,
            other.columns,
        )


def softposit(
    points: ArrayLike,
    xy: ArrayLike,
    start: ArrayLike,
    *,
    allowed: ArrayLike | None = None,
    annealing: Annealing | None = None,
    check: Callable[[], None] | None = None,
) -> SoftPositResult:
    """Poses from `points` (N, 3) m, object frame, some seen among `xy` (M, 2) = x/z, y/z, each from one of K starts.

    `start` (K, 4, 4) are rough `camera_from_object`; one that is not finite, not a rotation or has the model's middle
    behind the camera is given
    up at once. `allowed` (N, M) bool says which point may be which, all any if not given.

    A start ends when it is near after `patience` steps, when beta passes `beta_final`, or when its assignment fixes no
    pose. Each ends as if it
    were alone. Work: about 160 steps of up to 60 normalisations of P pairs, so types save time, and many starts at once
        take less than one by one.
    Memory: some ten arrays of max(P, 50,000) doubles, so P = N M beyond 10^7 is not for it. `check` is called before
        each step, and may raise to end it.

    Raises:
        GeometryError: where the shapes do not fit, a point is not finite, the model has no size, or the schedule does
            not rise.
    """
    problem = _problem(points, xy, allowed, annealing or Annealing())
    starts = last_axes(start, (4, 4), "start")
    if starts.ndim != 3:
        raise GeometryError(f"start must have the shape (K, 4, 4), not {starts.shape}")
    at_once = max(1, BLOCK // max(1, len(problem.pairs)))
    parts = [_annealed(problem, starts[i : i + at_once], check) for i in range(0, max(1, len(starts)), at_once)]
    return joined(parts)


def joined(parts: list[SoftPositResult]) -> SoftPositResult:
    """One result of several, at least one, of the same points."""
    names = [field.name for field in fields(SoftPositResult)]
    return SoftPositResult(**{name: np.concatenate([getattr(part, name) for part in parts]) for name in names})


def _problem(points: ArrayLike, xy: ArrayLike, allowed: ArrayLike | None, annealing: Annealing) -> _Problem:
    objects, seen = last_axes(points, (-1, 3), "points"), last_axes(xy, (-1, 2), "xy")
    shape = (len(objects), len(seen))
    mask = np.ones(shape, dtype=np.bool_) if allowed is None else np.asarray(allowed, dtype=np.bool_)
    if objects.ndim != 2 or seen.ndim != 2 or mask.shape != shape:
        raise GeometryError(
            f"points (N, 3), xy (M, 2) and allowed (N, M) must agree, not {objects.shape}, {seen.shape}, {mask.shape}"
        )
    if not (np.isfinite(objects).all() and np.isfinite(seen).all()):
        raise GeometryError("points and xy must be finite")
    rising = (
        annealing.rate > 1
        and 0 < annealing.beta <= annealing.beta_final
        and annealing.beta_final * annealing.alpha < EXPONENT
    )
    if not rising or annealing.pixel <= 0:
        raise GeometryError(
            f"beta must rise to beta_final, of which alpha times must be below {EXPONENT:.0f}, not {annealing}"
        )
    middle = objects.mean(axis=0) if len(objects) else np.zeros(3)
    size = float(np.sqrt(((objects - middle) ** 2).sum(axis=1).mean())) if len(objects) else 0.0
    if not size > 0:
        raise GeometryError(f"points must be two or more at different places, not {len(objects)} at one")
    scaled = np.concatenate([(objects - middle) / size, np.ones((len(objects), 1))], axis=1)
    used = np.nonzero(mask.any(axis=0))[0]
    return _Problem(
        scaled,
        seen[used] / annealing.pixel,
        used,
        pairs_of(mask[:, used]),
        1.0 / (max(shape) + 1),
        annealing,
        middle,
        size,
    )


def _annealed(problem: _Problem, starts: Floats, check: Callable[[], None] | None) -> SoftPositResult:
    """The whole way of one block of starts (K, 4, 4)."""
    setting = problem.annealing
    ends, sound = _from_poses(problem, starts)
    which, beta, step = np.nonzero(sound)[0], setting.beta, 0
    while len(which) and beta <= setting.beta_final:
        if check is not None:
            check()
        state, offset, fixed = _step(problem, ends.of(which), beta)
        ends.put(which, state)
        sound[which] = fixed
        beta, step = beta * setting.rate, step + 1
        which = which[fixed & ((offset > setting.nearest) | (step <= setting.patience))]
    return _result(problem, ends, sound)


def _step(problem: _Problem, state: _State, beta: float) -> tuple[_State, Floats, Mask]:
    """One step at `beta`: the next state, the assignment's rms d (K,) px, and whether that fixed a pose (K,)."""
    square, w = _squares(problem, state)
    m = _assigned(problem, square, beta, state.columns)
    S = problem.points
    sums = sums_per_model(m.weights, problem.pairs, np.concatenate([problem.xy, np.ones((len(problem.xy), 1))], axis=1))
    L = (S.T * sums[:, None, :, 2]) @ S
    spread = np.linalg.eigvalsh(L)
    fixed = spread[:, 0] > SINGULAR * np.maximum(spread[:, -1], 1.0)
    solvable = np.where(fixed[:, None, None], L, np.eye(4))
    Q = np.asarray(np.linalg.solve(solvable, S.T @ (w[..., None] * sums[..., :2])), dtype=np.float64)
    rotation, inverse_zoom, _ = turned(Q[:, :3, 0], Q[:, :3, 1])
    fixed &= _straight(rotation)
    after = _State(
        np.where(fixed[:, None, None], rotation, state.rotation),
        np.where(fixed, 1.0 / inverse_zoom, state.zoom),
        np.where(fixed[:, None], Q[:, 3], state.shift),
        m.scale,
    )
    return after, np.sqrt((m.weights * square).sum(axis=1) / len(S)), fixed


def _squares(problem: _Problem, state: _State) -> tuple[Floats, Floats]:
    """d^2 (K, P) px^2 of each pair, and w (K, N), kept positive.

    No point may come to lie behind the camera on the way.
    """
    P, model, image = problem.points[:, :3], problem.pairs.model, problem.pairs.image
    turned_points = P @ np.swapaxes(state.rotation, 1, 2)
    zoom = state.zoom[:, None]
    w = 1.0 + np.clip(turned_points[..., 2] * zoom * problem.annealing.pixel, NEARER, FARTHER)
    u, v = (turned_points[..., axis] * zoom + state.shift[:, axis, None] for axis in (0, 1))
    w_pair = w[:, model]
    off_x, off_y = u[:, model] - w_pair * problem.xy[image, 0], v[:, model] - w_pair * problem.xy[image, 1]
    return off_x * off_x + off_y * off_y, w


def _assigned(problem: _Problem, square: Floats, beta: float, columns: Floats) -> Assignment:
    """Softassign at `beta` of d^2 = `square` (K, P)."""
    affinities = problem.slack * np.exp(np.maximum(-beta * (square - problem.annealing.alpha), -EXPONENT))
    return sinkhorn(affinities, problem.pairs, problem.slack, columns)


def _from_poses(problem: _Problem, starts: Floats) -> tuple[_State, Mask]:
    """The states of poses (K, 4, 4), and which are sound (K,); the others stand ten sizes before the camera."""
    bounded = np.asarray((np.abs(np.nan_to_num(starts, nan=np.inf)) < HUGE).all(axis=(1, 2)))
    poses = np.where(bounded[:, None, None], starts, np.eye(4))
    rotation, _, _ = turned(poses[:, 0, :3], poses[:, 1, :3])
    place = poses[:, :3, :3] @ problem.middle + poses[:, :3, 3]
    alike = np.abs(rotation - poses[:, :3, :3]).max(axis=(1, 2)) < ROUGH
    sound = (
        bounded
        & alike
        & _straight(rotation)
        & (place[:, 2] * HUGE > np.abs(place).max(axis=1))
        & (place[:, 2] > problem.size / HUGE)
    )
    unmoved = np.array([0.0, 0.0, 10 * problem.size])
    place = np.where(sound[:, None], place, unmoved)
    pixel = problem.annealing.pixel
    columns = np.ones((len(starts), len(problem.xy)))
    rotation = np.where(sound[:, None, None], rotation, np.eye(3))
    return _State(rotation, problem.size / place[:, 2] / pixel, place[:, :2] / place[:, 2:] / pixel, columns), sound


def _result(problem: _Problem, ends: _State, sound: Mask) -> SoftPositResult:
    """Poses, and the matches under them at the final beta."""
    setting, pairs = problem.annealing, problem.pairs
    square, _ = _squares(problem, ends)
    weights = _assigned(problem, square, setting.beta_final, ends.columns).weights
    matches = np.full((len(sound), len(problem.points)), -1, dtype=np.int64)
    start, pair = np.nonzero((weights > MATCHED) & sound[:, None])
    matches[start, pairs.model[pair]] = pairs.image[pair]
    count = np.asarray((matches >= 0).sum(axis=1))
    error = _error(problem, ends, matches)
    near = np.sqrt((weights * square).sum(axis=1) / len(problem.points)) < setting.nearest
    depth = problem.size / (ends.zoom * setting.pixel)
    place = np.concatenate([ends.shift * setting.pixel, np.ones((len(sound), 1))], axis=1) * depth[:, None]
    poses = from_rotation_translation(ends.rotation, place - ends.rotation @ problem.middle)
    return SoftPositResult(
        poses,
        np.append(problem.of_image, -1)[matches],
        count,
        error,
        sound & near & (count >= LEAST_MATCHED) & np.isfinite(error),
    )


def _error(problem: _Problem, ends: _State, matches: Ints) -> Floats:
    """Mean squared distance (K,) of reprojection over the `matches` (K, N), normalised units^2.

    Inf without any or with one behind.
    """
    pixel, there = problem.annealing.pixel, matches >= 0
    placed = (
        problem.points[:, :3] @ np.swapaxes(ends.rotation, 1, 2) * ends.zoom[:, None, None]
    )  # px, at the depth of the middle
    w = 1.0 + placed[..., 2] * pixel
    good = (there & (w > 0)).sum(axis=1) == np.maximum(there.sum(axis=1), 1)
    seen = problem.xy[matches] if len(problem.xy) else np.zeros((*matches.shape, 2))
    off = (placed[..., :2] + ends.shift[:, None]) / np.where(w > 0, w, 1.0)[..., None] - seen
    total = np.where(there, (off * off).sum(axis=-1), 0.0).sum(axis=1) * pixel**2
    return np.where(good, total / np.maximum(there.sum(axis=1), 1), np.inf)


def _straight(rotation: Floats) -> Mask:
    """Whether `rotation` (K, 3, 3) came out orthonormal: not where the image axes were parallel or nothing."""
    return np.asarray(np.abs(rotation @ np.swapaxes(rotation, 1, 2) - np.eye(3)).max(axis=(1, 2)) < STRAIGHT)


def random_starts(
    points: ArrayLike, xy: ArrayLike, count: int, rng: np.random.Generator | int, *, depth: tuple[float, float]
) -> Floats:
    """`count` poses (count, 4, 4).

    Any rotation, the middle of `points` (N, 3) m in the box about `xy` (M, 2), `depth` m away.

    Depths are uniform in their logarithm between the two bounds. `rng` is a generator, which moves on, or a seed.

    Raises:
        GeometryError: where the shapes do not fit, a point is missing on either side, or the bounds are not 0 < nearest
        <= farthest.
    """
    objects, seen, generator = (
        last_axes(points, (-1, 3), "points"),
        last_axes(xy, (-1, 2), "xy"),
        np.random.default_rng(rng),
    )
    if objects.ndim != 2 or seen.ndim != 2 or not (len(objects) and len(seen) and 0 < depth[0] <= depth[1]):
        rule = "random starts need points (N, 3), xy (M, 2), one of each at least, and depths 0 < nearest <= farthest"
        raise GeometryError(f"{rule}, not {objects.shape}, {seen.shape} and {depth}")
    rotation = rotation_from_quat_xyzw(generator.normal(size=(count, 4)))
    z = np.exp(generator.uniform(np.log(depth[0]), np.log(depth[1]), (count, 1)))
    place = (
        np.concatenate([generator.uniform(seen.min(axis=0), seen.max(axis=0), (count, 2)), np.ones((count, 1))], axis=1)
        * z
    )
    return from_rotation_translation(rotation, place - rotation @ objects.mean(axis=0))
