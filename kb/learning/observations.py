"""What the detector sees of an object from one direction.

Keypoints that come again in worse pictures, carried back to its surface.

* ``Observations``: N of them as arrays; ``joined`` puts those of several views together
* ``View``: one picture of the object alone, with its depth, large; smaller and worse pictures are made of it
  (``variants``)
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, fields
from functools import cached_property, lru_cache
from typing import NamedTuple, Protocol

import cv2
import numpy as np
from numpy.typing import NDArray

from geometry.arrays import Bytes, Floats, Ints, Mask
from geometry.camera import Camera
from kb.learning.again import (
    INSIDE,
    SIDES_NEAR,
    Like,
    Look,
    Seen,
    around,
    descriptors,
    keypoints_again,
    may_be,
    reach_of,
    sides_again,
)

Variant = tuple[NDArray[np.uint8], NDArray[np.uint8]]
"""(h, w, 3) each: the view under random light, with blur and noise.

Before random spots, and before a calm background.

Before spots no keypoint at the outline comes twice; but a region of one colour, which ends there, would hardly ever
come at all.
"""


DIRECTIONS = 80
"""Viewpoints on the sphere: one per 23°, within which SIFT holds."""
PIXELS = (290.0, 190.0, 125.0, 82.0)
"""How large the object's diameter is in the pictures, pixels: what cameras see of a thing on a table and a room
away. Of the 127 textured objects of `plogic bench recognition` 121 are found, 119 with the right pose; with five sizes
from 330 on and four pictures of each 121 and 120, and a view of a box takes 0.52 s of processor time, not 0.20 s."""
AWAY = 5.0
"""Distance of the viewpoints in diameters of the object."""
MARGIN = 0.125
"""What is left around the object in a picture, in its diameters."""


class View(Protocol):
    """One large picture of the object before nothing, as whoever renders hands it in."""

    @property
    def image(self) -> NDArray[np.uint8]:
        """(H, W, 3), blue first."""

    @property
    def mask(self) -> NDArray[np.bool_]:
        """(H, W) where the object is."""

    @property
    def depth(self) -> NDArray[np.float32]:
        """(H, W) metres along the optical axis where the object is."""

    @property
    def camera(self) -> Camera:
        """Its ``world_from_camera`` is object_from_camera."""

    @property
    def pixels(self) -> float:
        """The object's diameter in this picture, pixels."""


def distance(pixels: float, diameter: float, f: float) -> float:
    """Metres at which an object of a diameter (m) is so many pixels large at the focal length f."""
    return f * diameter / pixels


GAIN, GAMMA = (0.7, 1.4), (0.8, 1.25)
"""Ranges of exposure; what is too bright is cut off at 255."""
BLUR, NOISE = (0.4, 1.1), (2.0, 8.0)
"""Ranges of the blur's and the noise's standard deviation: pixels, grey levels."""
LEVEL, TINT, CLOUDY = (20.0, 235.0), 20.0, 6.0
"""Of a calm background: range of its brightness, standard deviations of its channels about it and of the clouds in it;
grey levels."""


def size_of(view: View, pixels: float) -> tuple[int, int]:
    """Width and height of the picture in which the object's diameter is so many pixels."""
    height, width = view.image.shape[:2]
    return max(1, round(width * pixels / view.pixels)), max(1, round(height * pixels / view.pixels))


class Bare(NamedTuple):
    """The object's colours (h, w, 3), and its share (h, w, 1) of each pixel."""

    even: NDArray[np.uint8]
    share: NDArray[np.float32]


def bare(view: View, pixels: float) -> Bare:
    """The view with the object's diameter so many pixels."""
    size, mask = size_of(view, pixels), view.mask.astype(np.uint8)
    whole = np.asarray(cv2.resize(cv2.copyTo(view.image, mask), size, interpolation=cv2.INTER_AREA), np.float32)
    share = np.asarray(cv2.resize(mask.astype(np.float32), size, interpolation=cv2.INTER_AREA), np.float32)[..., None]
    return Bare(np.minimum(np.rint(whole / np.maximum(share, 1e-3)), 255.0).astype(np.uint8), share)


def variants(shown: Bare, rng: np.random.Generator, count: int) -> list[Variant]:
    """``count`` variants of a view, all different."""
    return [_variant(*shown, rng) for _ in range(count)]


def _variant(even: NDArray[np.uint8], share: NDArray[np.float32], rng: np.random.Generator) -> Variant:
    """One of an object's colours (h, w, 3) that has a share (h, w, 1) of each pixel."""
    size = share.shape[1], share.shape[0]
    light = (np.arange(256) / 255.0) ** rng.uniform(*GAMMA) * (255.0 * rng.uniform(*GAIN))
    own = share * np.asarray(cv2.LUT(even, light.astype(np.float32)), np.float32)
    behind = _spots(size, rng)
    blur, noise = rng.uniform(*BLUR), np.float32(rng.uniform(*NOISE)) * _noise(even.shape, rng)

    def taken(background: NDArray[np.float32]) -> NDArray[np.uint8]:
        picture = np.minimum(own + (1.0 - share) * background, 255.0)
        picture = np.asarray(cv2.GaussianBlur(picture, (0, 0), blur)) + noise
        return np.clip(np.rint(picture, out=picture), 0, 255, out=picture).astype(np.uint8)

    return taken(behind), taken(_calm(size, rng))


NOISES = 1 << 20
"""Numbers of which each picture's noise is a stretch, made once: new ones took 2.4 of the 6.8 ms of the largest."""


@lru_cache(maxsize=2)
def _noises(count: int) -> NDArray[np.float32]:
    """(count,) normally distributed."""
    noises = np.random.default_rng(0).standard_normal(count, dtype=np.float32)
    noises.setflags(write=False)
    return noises


def _noise(shape: tuple[int, ...], rng: np.random.Generator) -> NDArray[np.float32]:
    """Of that shape, normally distributed."""
    count = math.prod(shape)
    start = int(rng.integers(NOISES))
    return _noises(NOISES + max(NOISES, count))[start : start + count].reshape(shape)


def _calm(size: tuple[int, int], rng: np.random.Generator) -> NDArray[np.float32]:
    """(h, w, 3) of nearly one colour, as floors, tables and walls are."""
    (width, height), colour = size, rng.uniform(*LEVEL) + rng.normal(0.0, TINT, 3)
    cloudy = rng.normal(0.0, CLOUDY, (height // 16 + 2, width // 16 + 2, 1)).astype(np.float32)
    clouds = np.asarray(cv2.resize(cloudy, size, interpolation=cv2.INTER_CUBIC), np.float32)
    return np.asarray(np.clip(colour.astype(np.float32) + clouds[..., None], 0.0, 255.0), np.float32)


def _spots(size: tuple[int, int], rng: np.random.Generator) -> NDArray[np.float32]:
    """(h, w, 3) coarse and fine spots."""
    (width, height), spots = size, np.zeros((size[1], size[0], 3), np.float32)
    for cell, mean, spread, smooth in ((16, 128.0, 60.0, cv2.INTER_CUBIC), (3, 0.0, 25.0, cv2.INTER_LINEAR)):
        some = rng.normal(mean, spread, (height // cell + 2, width // cell + 2, 3)).astype(np.float32)
        spots += np.asarray(cv2.resize(some, size, interpolation=smooth), np.float32)
    return np.clip(spots, 0.0, 255.0, out=spots)


Detect = Callable[[Bytes, Bytes, int, Mask, Like | None], "Seen"]
"""Of a picture and the same before a calm background, where a mask (h, w) holds; the number is how many pixels lie
between points along an edge, and which of these are wanted the last argument tells, where it is given."""


PICTURES = 2
"""Pictures of each size in which keypoints are looked for, all different: those of the first, again in the others."""
PICTURES_OF_SIDES, ALWAYS = 3, 1.0
"""Those in which sides of edges are looked for, and the share of the others in which one must come again: noise makes
edges too."""
OFTEN = 0.5
"""Share of the other pictures in which a keypoint must come again: what comes less often is not expected (D7)."""
SPARSE, DENSE = 9, 5
"""Pixels between points along an edge: of those that become features, and of those among which they are looked for, as
at run time."""
SMALL = 200.0
"""Pixels: in a picture of a smaller object sides are taken densely, for a stretch of an edge is short there."""
STEEP = 0.2
"""Least cosine between a ray and the normal of a plane for it to be said where they meet."""
FLAT = 0.7
"""Pixels of the large picture by which a surface may be off a plane and is that plane."""
BESIDE = 3
"""Pixels beside the object at which what one picture shows may be on it by the mean of all, or be its outline."""
EDGE = 2
"""Pixels of the large picture that a keypoint must keep from the outline, where depth is that of the background."""


@dataclass(frozen=True, eq=False)
class Observations:
    """Metres, radians, the object's frame.

    Attributes:
        at: (N, 3) places on the surface.
        normal: (N, 3) unit normals there, towards the viewpoint.
        direction: (N, 3) unit vectors to the viewpoint.
        up: (N, 3) unit: the keypoint's angle as a direction, perpendicular to ``direction``.
        size: (N,) diameter in space; 0 of the side of an edge, which has none.
        pixel: (N,) how large a pixel was there, metres.
        view: (N,) index of the direction.
        level: (N,) index into ``PIXELS``.
        hit: (N,) share of the other pictures in which it came again.
        descriptor: (N, D) float32, its mean over the pictures.
    """

    at: Floats
    normal: Floats
    direction: Floats
    up: Floats
    size: Floats
    pixel: Floats
    view: Ints
    level: Ints
    hit: Floats
    descriptor: NDArray[np.float32]

    def __len__(self) -> int:
        return len(self.at)

    @cached_property
    def sided(self) -> Mask:
        """(N,) which are sides of edges."""
        return np.asarray(self.size == 0.0)


def joined(several: Sequence[Observations]) -> Observations:
    """All observations of at least one view, in order."""
    return Observations(*(np.concatenate([getattr(one, f.name) for one in several]) for f in fields(Observations)))


def observed(view: View, number: int, detect: Detect, seed: int = 0, look: Look | None = None) -> Observations:
    """What is seen from direction ``number`` at all sizes, with ``look`` sides of edges too.

    The same arguments give the same observations.
    """
    inner = cv2.erode(view.mask.astype(np.uint8), np.ones((2 * EDGE + 1, 2 * EDGE + 1), np.uint8)) > 0
    levels = []
    for level, pixels in enumerate(PIXELS):
        rng = np.random.default_rng([seed, number, level])
        shown = bare(view, pixels)
        pictures, own = variants(shown, rng, max(PICTURES, PICTURES_OF_SIDES)), _own(shown)
        first = detect(*pictures[0], SPARSE, own, None)
        there, like = around(first.uv, reach_of(first), own.shape), may_be(first)
        others = [detect(*both, DENSE, there, like) for both in pictures[1:PICTURES]]
        hit, uv, descriptor = keypoints_again(first, others)
        levels.append(_on_surface(view, inner, pixels, first, uv, hit, descriptor, (number, level)))
        if look is not None:
            levels.append(
                _sides(view, pixels, [busy for busy, _ in pictures[:PICTURES_OF_SIDES]], own, look, (number, level))
            )
    return joined(levels)


def _own(shown: Bare) -> Mask:
    """(h, w) where the object is, and ``BESIDE`` pixels around."""
    there = (shown.share[..., 0] > 0.0).astype(np.uint8)
    return np.asarray(cv2.dilate(there, np.ones((2 * BESIDE + 1, 2 * BESIDE + 1), np.uint8))) > 0


def _sides(
    view: View, pixels: float, pictures: Sequence[Bytes], own: Mask, look: Look, number_level: tuple[int, int]
) -> Observations:
    """Carry sides of edges back to the surface that is on their side; those seldom seen are left out."""
    first = look(pictures[0], SPARSE if pixels > SMALL else DENSE, own)
    large = np.array(view.image.shape[1::-1])
    factors = large / np.array(size_of(view, pixels))
    inward = np.column_stack([np.cos(first.angle), np.sin(first.angle)])
    cells = [
        np.clip(np.rint((first.uv + deep * inward + 0.5) * factors - 0.5).astype(int), 0, large - 1) for deep in INSIDE
    ]
    good = np.flatnonzero(np.all([view.mask[cell[:, 1], cell[:, 0]] for cell in cells[:2]], axis=0))
    there = around(first.uv[good], np.full(len(good), SIDES_NEAR), own.shape)
    hit = sides_again(first, [look(busy, DENSE, there) for busy in pictures[1:]], good)
    good = good[hit[good] >= ALWAYS]
    place, cell = (first.uv[good] + 0.5) * factors - 0.5, cells[0][good]
    here = _on_plane(view, place, cell, cells[-1][good])
    seen = _Taken(first.angle[good], np.zeros(len(good)), hit[good], descriptors(first.looks[good]))
    return _carried(view, here, cell, factors, seen, number_level)


def _on_surface(
    view: View,
    inner: Mask,
    pixels: float,
    first: Seen,
    uv: Floats,
    hit: Floats,
    descriptor: NDArray[np.float32],
    number_level: tuple[int, int],
) -> Observations:
    """Carry keypoints of a picture back along their rays to the surface.

    Those near the outline or seldom seen are left out.
    """
    large = np.array(view.image.shape[1::-1])
    factors = large / np.array(size_of(view, pixels))
    place = (uv + 0.5) * factors - 0.5
    cell = np.clip(np.rint(place).astype(int), 0, large - 1)
    good = inner[cell[:, 1], cell[:, 0]] & (hit >= OFTEN)
    seen = _Taken(first.angle[good], first.scale[good], hit[good], descriptor[good])
    return _carried(view, _points(view, place[good], cell[good]), cell[good], factors, seen, number_level)


@dataclass(frozen=True)
class _Taken:
    """What is carried back: angles, sizes in pixels, hits, descriptors."""

    angle: Floats
    scale: Floats
    hit: Floats
    descriptor: NDArray[np.float32]


def _carried(
    view: View, here: Floats, cell: NDArray[np.intp], factors: Floats, seen: _Taken, number_level: tuple[int, int]
) -> Observations:
    """What is seen at places (N, 3) in the camera's frame.

    At ``cell`` (N, 2) of the large picture, ``factors`` larger than what was looked at.
    """
    object_from_camera = view.camera.world_from_camera
    assert object_from_camera is not None  # noqa: S101 - a view has one
    R, viewpoint = object_from_camera[:3, :3], object_from_camera[:3, 3]
    at = here @ R.T + viewpoint
    direction = _unit(viewpoint - at)
    up = np.stack([np.cos(seen.angle), np.sin(seen.angle), np.zeros(len(at))], axis=1) @ R.T
    up = _unit(up - (up * direction).sum(axis=1, keepdims=True) * direction)
    pixel = here[:, 2] * factors.mean() / view.camera.f
    number, level = number_level
    return Observations(
        at=at,
        normal=_normals(view, cell) @ R.T,
        direction=direction,
        up=up,
        size=seen.scale * pixel,
        pixel=pixel,
        view=np.full(len(at), number, np.int64),
        level=np.full(len(at), level, np.int64),
        hit=seen.hit,
        descriptor=seen.descriptor,
    )


def _points(view: View, place: Floats, cell: NDArray[np.intp]) -> Floats:
    """(N, 3) in the camera's frame: the ray of each place, as deep as the picture is there."""
    rays = np.column_stack([view.camera.normalised(place), np.ones(len(place))])
    return np.asarray(rays * view.depth[cell[:, 1], cell[:, 0]].astype(float)[:, None])


def _on_plane(view: View, place: Floats, cell: NDArray[np.intp], inner: NDArray[np.intp]) -> Floats:
    """(N, 3) in the camera's frame.

    Where the rays of places on edges meet the plane of the surface at cells ``inner``, farther in.

    Where the surface at ``cell``, beside the edge, is not that plane, the place is as deep as that cell.
    """
    rays, there, normal = _points(view, place, cell), _points(view, inner.astype(float), inner), _normals(view, inner)
    beside, level = _points(view, cell.astype(float), cell), (there * normal).sum(axis=1)
    slope = (rays * normal).sum(axis=1)
    flat = np.abs((beside * normal).sum(axis=1) - level) < FLAT * there[:, 2] / view.camera.f
    flat &= np.abs(slope) > STEEP * np.linalg.norm(rays, axis=1)
    return np.asarray(np.where(flat[:, None], rays * (level / np.where(flat, slope, 1.0))[:, None], rays))


def _normals(view: View, cell: NDArray[np.intp], reach: int = EDGE) -> Floats:
    """(N, 3) unit normals in the camera's frame, towards it, from the depth to both sides."""
    limit = np.array(view.image.shape[1::-1]) - 1
    sides = []
    for step in ((reach, 0), (-reach, 0), (0, reach), (0, -reach)):
        there = np.clip(cell + np.array(step), 0, limit)
        sides.append(_points(view, there.astype(float), there))
    normal = _unit(np.cross(sides[0] - sides[1], sides[2] - sides[3]))
    return np.asarray(np.where(normal[:, 2:] > 0, -normal, normal))


def _unit(vectors: Floats) -> Floats:
    return np.asarray(vectors / np.maximum(np.linalg.norm(vectors, axis=1, keepdims=True), 1e-12))
