"""Boxes with features, what a camera would detect of them, and the paper's numbers of that, by other means.

Own projection, own lobes, own rays (slabs of boxes), own formula of ev: nothing of the program's is asked but the YAML
that it reads.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from plogic import Appearance, Camera, Gamma, KnowledgeBase

if TYPE_CHECKING:
    from pathlib import Path

WIDTH, HEIGHT, FOCAL = 640, 480, 600.0
TOLERANCE = 4.0
LOOKS = ("disc", "ring", "star")
SIGNS = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], float)
QUADS = ((0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3))
FACETS = [(a + 1, q + 1, r + 1) for a, b, c, d in QUADS for q, r in ((b, c), (c, d))]
IDENTITY = np.eye(4)


@dataclass(frozen=True)
class Box:
    """A type: half lengths (3,) m, and features (name, type, place (3,), axis (3,), half-angle in degrees)."""

    half: tuple[float, float, float]
    features: tuple[tuple[str, str, tuple[float, ...], tuple[float, ...], float], ...]
    opaque: bool = True
    symmetries: str = "[]"
    reach: float = 9.0
    """Metres to which its lobes reach at the reference focal length."""


def box(half: tuple[float, float, float], seed: int, marks: int = 4, **rest: object) -> Box:
    """Eight corners, and so many marks a face at places that only ``seed`` decides."""
    rng, size = np.random.default_rng(seed), np.array(half)
    rows = [(f"c{i}", "corner", tuple(s * size), tuple(s), 120.0) for i, s in enumerate(SIGNS)]
    for face in range(6):
        axis, side = face % 3, 1.0 if face < 3 else -1.0
        normal = np.eye(3)[axis] * side
        for k in range(marks):
            place = rng.uniform(-0.85, 0.85, 3) * size
            place[axis] = side * size[axis]
            rows.append((f"m{face}{k}", LOOKS[int(rng.integers(3))], tuple(place.round(4)), tuple(normal), 78.0))
    return Box(half, tuple(rows), **rest)


def written(folder: Path, types: dict[str, Box]) -> KnowledgeBase:
    """The knowledge base as a user would write it."""
    for name, kind in types.items():
        place = folder / "objects" / name
        place.mkdir(parents=True)
        mesh = "".join(f"v {x} {y} {z}\n" for x, y, z in (SIGNS * kind.half).tolist())
        (place / "mesh.obj").write_text(mesh + "".join(f"f {a} {b} {c}\n" for a, b, c in outward(FACETS)))
        head = f"object: {name}\nmesh: {{file: mesh.obj, units: m}}\nopaque: {str(kind.opaque).lower()}\n"
        head += f"symmetries: {kind.symmetries}\nfeatures:\n"
        rows = [
            f"  - {{feature: {n}, type: {t}, at: {numbers(at)}, appearances: [{{type: {t}, lobe: {{axis: {numbers(axis)}, "
            f"half_angle: {half} deg, range: [0.1 m, {kind.reach} m]}}}}]}}\n"
            for n, t, at, axis, half in kind.features
        ]
        (place / "object.yaml").write_text(head + "".join(rows))
    every = ("corner", *LOOKS)
    hit, clutter = (", ".join(f"{t}: {x}" for t in every) for x in (0.9, 1))
    priors = ", ".join(f"{name}: 0.5" for name in types)
    (folder / "kb.yaml").write_text(
        f"name: scenes\nappearance_types: [{', '.join(every)}]\nf_ref: {FOCAL}\n"
        f"detector: {{hit: {{{hit}}}, clutter: {{{clutter}}}, sigma: 1.0, match_tolerance: {TOLERANCE}}}\n"
        f"priors: {{{priors}}}\n"
    )
    return KnowledgeBase.load(folder)


def outward(facets: list[tuple[int, int, int]]) -> list[tuple[int, int, int]]:
    """The facets, each turned so that its normal leads out of the box."""

    def turned(a: int, b: int, c: int) -> tuple[int, int, int]:
        p, q, r = (SIGNS[i - 1] for i in (a, b, c))
        return (a, b, c) if np.cross(q - p, r - p) @ p > 0 else (a, c, b)

    return [turned(*facet) for facet in facets]


def numbers(row: tuple[float, ...]) -> list[float]:
    """Plain numbers for YAML."""
    return [float(x) for x in row]


def standing(x: float, y: float, z: float, turn: float = 0.0, lean: float = 0.35) -> np.ndarray:
    """camera_from_object: a box at (x, y, z) m of the camera, turned about its z axis, seen from ``lean`` rad above."""
    c, s, u, v = np.cos(turn), np.sin(turn), np.cos(lean), np.sin(lean)
    about = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])
    seen = np.array([[1, 0, 0], [0, v, -u], [0, u, v]])
    pose = np.eye(4)
    pose[:3, :3], pose[:3, 3] = seen @ about, (x, y, z)
    return pose


@dataclass(frozen=True)
class Scene:
    """What stands where, by a camera of focal length ``f``: Γ is made of it, and the numbers are computed."""

    types: dict[str, Box]
    objects: tuple[tuple[str, np.ndarray], ...]
    f: float = FOCAL
    missed: tuple[tuple[int, str], ...] = ()
    extra: tuple[tuple[str, float, float], ...] = ()
    seed: int = 0
    noise: float = field(default=0.2)

    @property
    def K(self) -> np.ndarray:  # noqa: N802 - the matrix's name
        """The camera's matrix (3, 3)."""
        return np.array([[self.f, 0, 319.5], [0, self.f, 239.5], [0, 0, 1.0]])

    def gamma(self) -> Gamma:
        """One appearance of each feature that is expected and not in ``missed`` (object's index, feature's name)."""
        rng, rows = np.random.default_rng(self.seed), [*self.extra]
        for i, (name, pose) in enumerate(self.objects):
            others = [other for j, other in enumerate(self.objects) if j != i]
            for (feature, kind, *_), uv, seen in zip(
                self.types[name].features, *self.expected(name, pose, others), strict=True
            ):
                if seen and (i, feature) not in self.missed:
                    rows.append((kind, *(uv + rng.normal(0.0, self.noise, 2))))
        order = rng.permutation(len(rows))
        data = [
            Appearance(f"a{n}", rows[k][0], (float(rows[k][1]), float(rows[k][2])), "made") for n, k in enumerate(order)
        ]
        return Gamma(Camera(WIDTH, HEIGHT, self.K), data)

    def expected(self, name: str, pose: np.ndarray, others=()) -> tuple[np.ndarray, np.ndarray]:
        """Pixels (F, 2) of a box's features, NaN outside the image, and whether each is Expected beside others (D7)."""
        kind = self.types[name]
        at = np.array([f[2] for f in kind.features]) @ pose[:3, :3].T + pose[:3, 3]
        uv = at @ self.K.T
        uv = uv[:, :2] / uv[:, 2:]
        inside = ((uv >= -0.5) & (uv < (WIDTH - 0.5, HEIGHT - 0.5))).all(axis=1) & (at[:, 2] > 0)
        way = (-at @ pose[:3, :3]) / np.linalg.norm(at, axis=1, keepdims=True)
        axes = np.array([f[3] for f in kind.features])
        cosine = (way * axes).sum(axis=1) / np.linalg.norm(axes, axis=1)
        lobe = cosine >= np.cos(np.radians([f[4] for f in kind.features]))
        distance = np.linalg.norm(at, axis=1) / (self.f / FOCAL)
        seen = inside & lobe & (distance >= 0.1) & (distance <= kind.reach)
        for other, place in ((name, pose), *others):
            if self.types[other].opaque:
                seen &= ~np.array([behind(point, place, self.types[other].half) for point in at])
        return np.where(inside[:, None], uv, np.nan), seen

    def dv(self) -> dict[str, float]:
        """Dv of each feature type over the types (§5.1)."""
        every = [f[1] for kind in self.types.values() for f in kind.features]
        return {name: 1.0 - every.count(name) / len(every) for name in set(every)}

    def cells(self, name, pose, others=(), data=()) -> list[tuple[str, bool, bool, bool]]:
        """Of each feature in the image: its type, Expected alone, Expected beside others, Detected in ``data``."""
        uv, alone = self.expected(name, pose)
        _, beside = self.expected(name, pose, others)
        free = list(data)
        order = sorted(range(len(uv)), key=lambda f: not beside[f])
        found = {}
        for f in order:
            kind = self.types[name].features[f][1]
            near = [(np.hypot(*(uv[f] - a.uv)), a) for a in free if a.type == kind]
            best = min(near, key=lambda pair: pair[0], default=(np.inf, None))
            found[f] = bool(best[0] <= TOLERANCE)
            if found[f]:
                free.remove(best[1])
        return [
            (self.types[name].features[f][1], bool(alone[f]), bool(beside[f]), found[f])
            for f in np.flatnonzero(~np.isnan(uv[:, 0]))
        ]

    def share(self, rows, mode: str = "alone") -> float:
        """P(ev) of these cells: alone, or beside the others in one of the three modes (§5.4, §5.5)."""
        dv, concordant, whole = self.dv(), 0.0, 0.0
        for kind, alone, beside, detected in rows:
            if mode == "drop" and alone and not beside and not detected:
                continue
            concordant += dv[kind] * ((alone if mode == "alone" else beside) == detected)
            whole += dv[kind]
        return concordant / whole


def behind(point: np.ndarray, pose: np.ndarray, half) -> bool:
    """Whether the line of sight to a point (3,), camera frame, meets a posed box strictly before it."""
    eye, there = -pose[:3, :3].T @ pose[:3, 3], pose[:3, :3].T @ (point - pose[:3, 3])
    way, half = there - eye, np.array(half)
    with np.errstate(divide="ignore"):
        a, b = (-half - eye) / way, (half - eye) / way
    enter, leave = np.minimum(a, b).max(), np.maximum(a, b).min()
    return bool(enter < leave and 0 < enter < 1.0 - 2e-3)
