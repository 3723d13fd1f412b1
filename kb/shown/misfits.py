"""What of a type written by hand does not fit together: places and mesh, lobes and body, ranges and size.

Each is no mistake of the files, and yet the type is never found, or seldom.

* ``misfits(kind)``: a sentence about each, ``"north is off the mesh by 4.2 m, and the mesh measures 0.4 m: ..."``
"""

from collections.abc import Iterator
from math import degrees, log10, pi

import numpy as np

from geometry.arrays import Floats
from geometry.cones import even_directions
from kb.clouds.cloud import ObjectType
from kb.clouds.lobes import object_nodes, place
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
BESIDE = 0.05
"""A feature is beside the mesh that is farther from it than this share of the mesh's diameter."""
AROUND = 64
"""Directions from which it is asked whether the type's own body hides a feature."""
AWAY, FLUSH = -0.25, 0.05
"""An axis looks inward whose cosine with the middle of the free directions is less; that middle is longer than so."""
FLAT = 1e-3
"""Features are on one line that are no farther from it than this share of their extent."""


def misfits(kind: ObjectType, f_ref: float) -> Iterator[str]:
    """A sentence about each; nothing of learned types, whose features were measured on their mesh.

    ``f_ref`` pixels: the focal length that the ranges hold for.
    """
    if kind.learned is not None or not kind.seen_features:
        return
    yield from _places(kind)
    yield from _offsets_twice(kind) or _off_the_mesh(kind)
    inward = _inward(kind)
    yield from _inward_told(inward)
    yield from _narrow(kind)
    yield from _ranges(kind, f_ref, inward)


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


def _offsets_twice(kind: ObjectType) -> list[str]:
    """Parts whose features are off the mesh, and on it where the part's own offset is taken back."""
    if kind.surface is None:
        return []
    near, size, told = Nearness(kind.surface.vertices, kind.surface.triangles), kind.surface.diameter, []
    for node in object_nodes(kind.tree):
        above = kind.tree.nodes[node].above
        if above is None:
            continue
        offset = place(kind.tree, node)[:3, 3] - place(kind.tree, above)[:3, 3]
        at = np.array([f.at for f in kind.seen_features if f.name.startswith(f"{node}/")]).reshape(-1, 3)
        if not len(at) or np.linalg.norm(offset) <= BESIDE * size:
            continue
        off = near.distance(at)
        if np.median(off) > BESIDE * size > 5.0 * np.median(near.distance(at - offset)):
            written = _row(kind.tree.nodes[node].parent_from_node[:3, 3])
            told.append(
                f"the features of part {node} lie up to {_metres(float(off.max()))} off the mesh, and on it without the part's own at, {written}: "
                "is it applied twice? a feature's at is in its part's frame"
            )
    return told


def _inward(kind: ObjectType) -> list[str]:
    """Names of the features all of whose lobes' axes turn away from where the type's own body leaves them in sight."""
    surface, table = kind.surface, kind.lobes
    if surface is None or not kind.opaque or not len(table.types):
        return []
    at = _at(kind)
    directions = even_directions(AROUND)
    eyes = at[:, None] + 2.0 * surface.diameter * directions
    free = shown(kind, eyes.reshape(-1, 3), np.repeat(at, AROUND, axis=0)).reshape(len(at), AROUND)
    outward = free @ directions / np.maximum(free.sum(axis=1, keepdims=True), 1)
    length = np.linalg.norm(outward, axis=1)
    along = np.einsum("lk,lk->l", table.axis, outward[table.feature])
    inward = (along < AWAY * length[table.feature]) & (length > FLUSH)[table.feature]
    turned = np.bincount(table.feature[inward], minlength=table.features)
    lobes = np.bincount(table.feature, minlength=table.features)
    return [kind.seen_features[f].name for f in np.flatnonzero((turned > 0) & (turned == lobes))]


def _inward_told(names: list[str]) -> Iterator[str]:
    if not names:
        return
    example = "turn the axis round: it points from the feature to the viewer"
    if len(names) == 1:
        yield f"the lobe of {names[0]} looks inward, into the type's own body: {example}"
    else:
        yield f"lobes of {len(names)} features look inward, into the type's own body ({named(names)}): {example}"


def _narrow(kind: ObjectType) -> Iterator[str]:
    """Cones so narrow that their degrees are radians."""
    table = kind.lobes
    half = np.degrees(np.arccos(np.clip(table.cos_half, -1.0, 1.0)))
    narrow = np.flatnonzero(half < pi)
    if not len(narrow):
        return
    widest = float(half[narrow].max())
    names = list(dict.fromkeys(kind.seen_features[table.feature[lobe]].name for lobe in narrow))
    meant = f"was {widest:.3g} rad meant? write '{widest:.3g} rad' or '{degrees(widest):.3g} deg'"
    yield f"half_angle is {widest:.3g} deg or less for {named(names)}: hardly any viewpoint lies in so narrow a cone; {meant}"


def _ranges(kind: ObjectType, f_ref: float, told: list[str]) -> Iterator[str]:
    """Of the whole, else of single features that are not ``told`` of already."""
    table, size = kind.lobes, size_of(kind)
    if not len(table.types):
        return
    far, near = float(np.median(table.r_max)), float(np.median(table.r_min))
    remedy = "range is [nearest, farthest], in m unless a unit is written"
    if far < size:
        yield f"the range ends {_metres(far)} away, and the type measures {_metres(size)}: a camera so near does not see it whole; {remedy}"
        return
    if near > 0.0 and f_ref * size / near < PIXELS:
        yield f"the range begins {_metres(near)} away, where the type, {_metres(size)} large, is smaller than {PIXELS:g} pixels; {remedy}"
        return
    yield from _odd_ranges(kind, (max(size, near), far), told, remedy)


def _odd_ranges(kind: ObjectType, whole: tuple[float, float], told: list[str], remedy: str) -> Iterator[str]:
    """Features whose ranges all end before, or all begin after, the distances (m) at which the ``whole`` is seen."""
    table, (near, far) = kind.lobes, whole
    ends, begins = np.zeros(table.features), np.full(table.features, np.inf)
    np.maximum.at(ends, table.feature, table.r_max)
    np.minimum.at(begins, table.feature, table.r_min)
    seen = np.isin(np.arange(table.features), table.feature)
    seen &= [feature.name not in told for feature in kind.seen_features]
    for some, word, bound in ((seen & (ends < near), "ends", ends), (seen & (begins > far), "begins", begins)):
        if some.any():
            names = [kind.seen_features[f].name for f in np.flatnonzero(some)]
            worst = float(bound[some].max() if word == "ends" else bound[some].min())
            others = f"the whole is seen from {_metres(near)} to {_metres(far)}"
            yield f"the range of {named(names)} {word} {_metres(worst)} away, and {others}: never expected with the others; {remedy}"


def _row(place: Floats) -> str:
    return "[" + ", ".join(f"{x:g}" for x in place) + "]"


def _metres(length: float) -> str:
    return f"{length:.3g} m" if length >= 0.01 else f"{1000.0 * length:.3g} mm"
