"""What of a type written by hand does not fit together: places and mesh, lobes and body, ranges and size.

Each is no mistake of the files, and yet the type is never found, or seldom.

* ``misfits(kind)``: a sentence about each, ``"north is off the mesh by 4.2 m, and the mesh measures 0.4 m: ..."``
"""

from collections.abc import Iterator
from math import log10

import numpy as np

from geometry.arrays import Floats
from kb.clouds.cloud import ObjectType
from kb.shown.seen_from import FIXING_A_POSE, named, shown, size_of
from kb.surfaces.nearness import Nearness

OFF = 0.5
"""How far a feature may be off the mesh, as a share of the mesh's diameter."""
APART = 5.0
"""Ratio of the features' extent and the mesh's from which on they may be in different units."""
UNITS = {1000.0: "mm", 100.0: "cm", 10.0: "dm"}
"""By how much a number in metres is too large where it was meant in another unit."""
PIXELS = 8.0
"""Least size in the picture, at the reference focal length, at which a type is told from noise."""
FLAT = 1e-3
"""Features are on one line that are no farther from it than this share of their extent."""


def misfits(kind: ObjectType, f_ref: float) -> Iterator[str]:
    """A sentence about each; nothing of learned types, whose features were measured on their mesh.

    ``f_ref`` pixels: the focal length that the ranges hold for.
    """
    if kind.learned is not None or not kind.seen_features:
        return
    yield from _places(kind)
    yield from _off_the_mesh(kind)
    yield from _inward(kind)
    yield from _ranges(kind, f_ref)


def _at(kind: ObjectType) -> Floats:
    return np.array([feature.at for feature in kind.seen_features])


def _places(kind: ObjectType) -> Iterator[str]:
    """Features at one place, or on one line, fix no pose."""
    at = _at(kind)
    extent = float(np.linalg.norm(np.ptp(at, axis=0)))
    if len(at) < FIXING_A_POSE:
        return
    if extent == 0.0:
        yield f"its {len(at)} features are all at one place, {_row(at[0])}: no pose can be taken from them; give each its own at"
        return
    off = at - at.mean(axis=0)
    spread = np.linalg.svd(off, compute_uv=False)
    if spread[1] <= FLAT * spread[0]:
        yield f"its {len(at)} features are on one line: no pose can be taken from them; add some beside it"


def _off_the_mesh(kind: ObjectType) -> Iterator[str]:
    surface = kind.surface
    if surface is None:
        return
    at, size = _at(kind), surface.diameter
    extent = float(np.linalg.norm(np.ptp(at, axis=0)))
    off = Nearness(surface.vertices, surface.triangles).distance(at)
    ratio = extent / size
    far = ratio > APART and np.median(off) > OFF * size
    inside = 0.0 < ratio < 1.0 / APART and (np.median(off) > OFF * extent or _is_unit(1.0 / ratio))
    if far or inside:
        times = _times(ratio if far else 1.0 / ratio)
        more, remedy = (
            ("more", _remedy(ratio, "a feature's at", "[15 {}, 0 m, 2 {}]", "cm"))
            if far
            else (
                "less",
                _remedy(1.0 / ratio, "the mesh", "mesh: {{units: {}}}", "mm"),
            )
        )
        yield f"its features measure {_metres(extent)} and its mesh {_metres(size)}, {times} {more}: they are in different units: {remedy}"
        return
    lost = [(feature.name, float(d)) for feature, d in zip(kind.seen_features, off, strict=True) if d > OFF * size]
    if lost:
        names, farthest = named([name for name, _ in lost]), max(d for _, d in lost)
        many = len(lost) > 1
        off_by = f"{names} {'are' if many else 'is'} off the mesh by {'up to ' * many}{_metres(farthest)}"
        yield f"{off_by}, and the mesh measures {_metres(size)}: is at in its parent's frame, and in m?"


def _is_unit(ratio: float) -> bool:
    """Whether two sizes differ by about what cm or mm are to m."""
    return any(abs(log10(ratio / unit)) < 0.1 for unit in UNITS if unit >= 100.0)


def _remedy(ratio: float, what: str, example: str, usual: str) -> str:
    """What to write; ``example`` has a place for each unit, the ``usual`` one's where none is meant."""
    unit = next((name for factor, name in UNITS.items() if abs(log10(ratio / factor)) < 0.3), None)
    shown = example.replace("{}", unit or usual).replace("{{", "{").replace("}}", "}")
    return f"is {what} in {unit}? write it so, as in {shown}" if unit else f"state the unit of {what}, as in {shown}"


def _times(ratio: float) -> str:
    return f"{ratio:.3g} times"


def _inward(kind: ObjectType) -> Iterator[str]:
    """Features all of whose lobes look where the type's own body is in the way, and not where it is not."""
    surface, table = kind.surface, kind.lobes
    if surface is None or not kind.opaque or not surface.closed or not len(table.types):
        return
    reach = 2.0 * surface.diameter + np.zeros(len(table.types))
    out, back = (
        shown(kind, table.at + sign * reach[:, None] * table.axis, np.asarray(table.at)) for sign in (1.0, -1.0)
    )
    turned = np.bincount(table.feature[~out & back], minlength=table.features)
    names = [
        kind.seen_features[f].name
        for f in np.flatnonzero((turned > 0) & (turned == np.bincount(table.feature, minlength=table.features)))
    ]
    if not names:
        return
    example = "turn the axis round: it points from the feature to the viewer"
    if len(names) == 1:
        yield f"the lobe of {names[0]} looks inward, into the type's own body: {example}"
    else:
        yield f"lobes of {len(names)} features look inward, into the type's own body ({named(names)}): {example}"


def _ranges(kind: ObjectType, f_ref: float) -> Iterator[str]:
    table, size = kind.lobes, size_of(kind)
    if not len(table.types):
        return
    far, near = float(np.median(table.r_max)), float(np.median(table.r_min))
    what = ""
    if far < 0.5 * size:
        what = f"the range ends {_metres(far)} away, and the type measures {_metres(size)}: a camera so near does not see it whole"
    elif near > 0.0 and f_ref * size / near < PIXELS:
        what = f"the range begins {_metres(near)} away, where the type, {_metres(size)} large, is smaller than {PIXELS:g} pixels"
    if what:
        yield f"{what}; range is [nearest, farthest], in m unless a unit is written"


def _row(place: Floats) -> str:
    return "[" + ", ".join(f"{x:g}" for x in place) + "]"


def _metres(length: float) -> str:
    return f"{length:.3g} m" if length >= 0.01 else f"{1000.0 * length:.3g} mm"
