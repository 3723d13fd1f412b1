"""Expected and Detected of one posed hypothesis (D7, D8): what should be seen of it, and which appearance each feature takes."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
from scipy.optimize import linear_sum_assignment

from geometry.frames import inverse, transform_points
from geometry.visibility.rays import behind
from kb.clouds.lobes import LobeTable, in_lobe
from plogic.facts.hypothesis import Hypothesis

if TYPE_CHECKING:
    from geometry.arrays import Floats, Indices, Mask
    from kb.clouds.cloud import KnowledgeBase, ObjectType
    from plogic.match.gamma.data import Data


def pose_of(object_type: ObjectType, camera_from_object: Floats, data: Data, kb: KnowledgeBase) -> Hypothesis:
    """What geometry says of a type at a pose: nothing is matched yet. Rays are cast for Behind its own host (§6.4)."""
    camera = data.camera
    positions = np.array([feature.at for feature in object_type.seen_features]).reshape(-1, 3)
    at = transform_points(camera_from_object, positions)
    uv = camera.project(at)
    inside = camera.contains(uv)
    viewpoint = inverse(camera_from_object)[:3, 3][None]
    granularity = camera.f / kb.f_ref
    table = object_type.lobes
    held = in_lobe(table, viewpoint, granularity)[0]
    surface = object_type.surface
    hidden = np.zeros(len(at), dtype=bool)
    if surface is not None:
        hidden = behind(at, surface.rays, camera_from_object, 0.004 * surface.diameter)
    right = _right_types(table, held, data)
    seen = np.bincount(table.feature[held], minlength=len(at)) > 0
    return Hypothesis(
        type=object_type.name,
        camera_from_object=camera_from_object,
        opaque=object_type.opaque,
        known_type=object_type,
        at=at,
        uv=uv,
        in_image=inside,
        in_lobe=seen,
        self_hidden=hidden,
        right=right,
        matches=np.full(len(at), -1, dtype=np.intp),
        residual=np.full(len(at), np.nan),
    )


def _right_types(table: LobeTable, held: Mask, data: Data) -> Mask:
    """(F, A) the data whose type some lobe of the feature reports from here.

    ``held`` (L,) are the lobes that hold the viewpoint.
    """
    names = sorted(set(table.types))
    column = {name: i for i, name in enumerate(names)}
    reports = np.zeros((table.features, len(names)), dtype=bool)
    lobes = np.flatnonzero(held)
    reports[table.feature[lobes], [column[table.types[lobe]] for lobe in lobes]] = True
    of_datum = np.array([column.get(name, -1) for name in data.types], dtype=np.intp)
    reports = np.hstack(
        [reports, np.zeros((table.features, 1), dtype=bool)]
    )  # the last column is for types that no lobe reports
    return np.asarray(reports[:, of_datum])


def matched(
    posed: Hypothesis,
    data: Data,
    allowed: Mask,
    tolerance: float,
    free: Mask | None = None,
    hidden: Mask | None = None,
) -> Hypothesis:
    """The hypothesis' one assignment (D8): expected features first, with the types whose lobe holds v.

    Then unexpected ones.

    ``allowed`` (F, A) are the types of each feature in any lobe; ``tolerance`` in pixels; ``free`` (A,) the data that
    nobody else has claimed; ``hidden`` (F,) the features that accepted opaque objects hide. An appearance serves one
    feature; a feature takes one.
    """
    free = np.ones(len(data.ids), dtype=bool) if free is None else free
    expected = posed.expected(hidden)
    off = np.linalg.norm(np.nan_to_num(posed.uv, nan=1e9)[:, None] - data.uv[None], axis=2)
    near = off <= tolerance
    matches = np.full(len(posed.uv), -1, dtype=np.intp)
    _assign(matches, off, near & free & posed.right & expected[:, None], tolerance)
    left = free.copy()
    left[matches[matches >= 0]] = False
    _assign(matches, off, near & left & allowed & (posed.in_image & ~expected)[:, None], tolerance)
    residual = (
        np.where(matches >= 0, np.take_along_axis(off, np.maximum(matches, 0)[:, None], axis=1)[:, 0], np.nan)
        if off.size
        else np.full(len(matches), np.nan)
    )
    return replace(posed, matches=matches, residual=residual)


def assigned(
    matches: Indices,
    feature: Indices,
    datum: Indices,
    off: Floats,
    tolerance: float,
) -> None:
    """The same assignment for few pairs (feature, datum), ``off`` pixels apart: fill ``matches`` (F,)."""
    rows, row = np.unique(feature, return_inverse=True)
    columns, column = np.unique(datum, return_inverse=True)
    if not len(rows):
        return
    distance, possible = np.full((len(rows), len(columns)), 2.0 * tolerance), np.zeros((len(rows), len(columns)), bool)
    distance[row, column], possible[row, column] = off, True
    found = np.full(len(rows), -1, np.intp)
    _assign(found, distance, possible, tolerance)
    matches[rows[found >= 0]] = columns[found[found >= 0]]


def _assign(matches: Indices, off: Floats, possible: Mask, tolerance: float) -> None:
    """Fill ``matches`` with the assignment of greatest Σ (1 − d²/2·tolerance²): as many as can be, the nearer the better."""
    rows, columns = np.flatnonzero(possible.any(axis=1)), np.flatnonzero(possible.any(axis=0))
    if not len(rows):
        return
    grid = np.ix_(rows, columns)
    gain = np.where(possible[grid], 1.0 - 0.5 * (off[grid] / tolerance) ** 2, 0.0)
    for r, c in zip(*linear_sum_assignment(gain, maximize=True), strict=True):
        if possible[rows[r], columns[c]]:
            matches[rows[r]] = columns[c]


def hidden_by(posed: Hypothesis, other: Hypothesis) -> Mask:
    """(F,) Behind(f, other, v): the line of sight to each feature of ``posed`` meets the other's surface first (§3.4).

    Of a learned type's thousands of features it is asked of those alone that are expected or detected: of others
    nothing is said.
    """
    surface, mask = other.object_type.surface, np.zeros(len(posed.at), dtype=bool)
    if surface is None:
        return mask
    asked = np.flatnonzero(posed.candidate | posed.detected) if posed.hit is not None else np.arange(len(posed.at))
    mask[asked] = behind(posed.at[asked], surface.rays, other.camera_from_object, 0.004 * surface.diameter)
    return mask
