"""What ``kb assimilate`` needs of a ``panorama/1``.

The views with their cameras, and the unknown objects with their data.

The document may come from anywhere: its size is bounded, it is held to its shape, and each mistake is one line.
"""

from typing import cast

import numpy as np

from geometry.camera import Camera, camera_from_dict, camera_mistakes
from geometry.errors import Keys, Mistake
from geometry.files.documents import Document, read_json
from geometry.frames import is_rigid
from plogic.base.errors import InputError
from plogic.sequence.constancy.result import SeenFeature, Sighting
from plogic.sequence.document import Panorama, PhysicalFeatureRow, ViewRow

LARGEST = 256 * 2**20
"""Bytes of a panorama that is read."""
MOST_MISTAKES = 20
"""Mistakes that are told; the rest are counted."""
HIGHEST = 1e6
"""m; what every coordinate stays below."""


def unknown_of(path: str, wanted: str) -> tuple[SeenFeature, ...]:
    """The features of the unknown object ``wanted`` of a panorama's file, `-` being stdin.

    Raises:
        InputError: The file's mistakes, a line each; or there is no such object.
    """
    document = read_json(path, LARGEST, "it should hold views and what was seen in them", InputError)
    panorama = _checked(document)
    unknown = {one["id"]: one for one in panorama.get("unknown", [])}
    if wanted not in unknown:
        there = ", ".join(list(unknown)[:20]) or "none"
        raise InputError(f"{document.name}: {wanted!r:.80} is no unknown object; there are: {there}")
    views = {view["id"]: view for view in panorama["views"]}
    cameras = {name: camera_from_dict(view["interpretation"].get("camera")) for name, view in views.items()}
    angles = {
        name: {a["id"]: a.get("angle") for a in view["interpretation"]["appearances"]} for name, view in views.items()
    }
    return tuple(_seen(feature, views, cameras, angles) for feature in unknown[wanted]["features"])


def _seen(
    feature: PhysicalFeatureRow,
    views: dict[str, ViewRow],
    cameras: dict[str, Camera],
    angles: dict[str, dict[str, float | None]],
) -> SeenFeature:
    sightings = tuple(
        Sighting(np.array(views[view]["T_world_camera"], dtype=float), cameras[view].f, angles[view][datum])
        for view, datum in feature["data"].items()
    )
    return SeenFeature(feature["type"], np.array(feature["at"], dtype=float), sightings)


def _checked(document: Document) -> Panorama:
    mistakes = document.against(Panorama)
    if mistakes:
        raise _mistaken(document, mistakes)
    panorama = cast("Panorama", document.data)
    unknown = panorama.get("unknown", [])
    mistakes += _twice("views", [view["id"] for view in panorama["views"]])
    mistakes += _twice("unknown", [one["id"] for one in unknown])
    for i, view in enumerate(panorama["views"]):
        mistakes += camera_mistakes(view["interpretation"].get("camera"), ("views", i, "interpretation", "camera"))
        mistakes += _pose_mistakes(view["T_world_camera"], ("views", i, "T_world_camera"))
    known = {
        view["id"]: {a["id"]: a["type"] for a in view["interpretation"]["appearances"]} for view in panorama["views"]
    }
    for i, one in enumerate(unknown):
        for j, feature in enumerate(one["features"]):
            here = ("unknown", i, "features", j)
            mistakes += [Mistake((*here, "data"), wrong) for wrong in _data_mistakes(feature, known)]
            mistakes += [Mistake((*here, "at"), wrong) for wrong in _place_mistakes(feature, panorama)]
    if mistakes:
        raise _mistaken(document, mistakes)
    return panorama


def _pose_mistakes(rows: list[list[float]], place: Keys) -> list[Mistake]:
    far = not all(abs(value) <= HIGHEST for row in rows for value in row)
    wrong = (
        f"no number may be above {HIGHEST:g} m" if far else "" if is_rigid(rows) else "must be a rigid 4x4 transform"
    )
    return [Mistake(place, wrong)] if wrong else []


def _data_mistakes(feature: PhysicalFeatureRow, known: dict[str, dict[str, str]]) -> list[str]:
    """Data of views that are not there, that are not in these, or of another type than the feature's."""
    lines = [] if feature["data"] else ["is empty: should name an appearance by view"]
    for view, datum in feature["data"].items():
        if view not in known:
            lines.append(f"{view!r:.80} is no view")
        elif datum not in known[view]:
            lines.append(f"{datum!r:.80} is no appearance of {view}")
        elif known[view][datum] != feature["type"]:
            lines.append(
                f"{datum!r:.80} of {view} is a {known[view][datum]!r:.80}, and the feature a {feature['type']!r:.80}"
            )
    return lines


def _place_mistakes(feature: PhysicalFeatureRow, panorama: Panorama) -> list[str]:
    """A feature that is too far off, or in a camera's own place: it has no direction from there."""
    at = feature["at"]
    if not all(abs(value) <= HIGHEST for value in at):
        return [f"no number may be above {HIGHEST:g} m"]
    eyes = {view["id"]: [row[3] for row in view["T_world_camera"][:3]] for view in panorama["views"]}
    near = (
        view
        for view in feature["data"]
        if view in eyes and max(abs(a - b) for a, b in zip(at, eyes[view], strict=True)) < 1e-6
    )
    return [f"lies in the camera of {view}" for view in near]


def _twice(key: str, ids: list[str]) -> list[Mistake]:
    twice = sorted({name for name in ids if ids.count(name) > 1})
    return [Mistake((key,), f"{name!r:.80} is the id of two") for name in twice]


def _mistaken(document: Document, mistakes: list[Mistake]) -> InputError:
    more = len(mistakes) - MOST_MISTAKES
    said = [f"{document.name}: and {more} more mistakes"] if more > 0 else []
    return InputError("\n".join(document.told(mistakes[:MOST_MISTAKES]) + said))
