"""What ``kb assimilate`` needs of a ``panorama/1``.

The views with their cameras, and the unknown objects with their data.

The document may come from anywhere: its size is bounded, every key that is used is checked, and each mistake is one
line.
"""

from typing import Annotated, Any, Literal

from pydantic import BaseModel, Field, ValidationError

from geometry.camera import Camera, camera_from_dict, camera_mistakes
from geometry.errors import Mistake
from geometry.files.documents import Document, read_json
from geometry.frames import is_rigid
from plogic.base.errors import InputError
from plogic.sequence.constancy.result import SeenFeature, Sighting

LARGEST = 256 * 2**20
"""Bytes of a panorama that is read."""
MOST_MISTAKES = 20
"""Mistakes that are told; the rest are counted."""
HIGHEST = 1e6
"""m; what every coordinate stays below."""
_Number = Annotated[float, Field(strict=True, allow_inf_nan=False, ge=-HIGHEST, le=HIGHEST)]
_Angle = Annotated[float, Field(strict=True, allow_inf_nan=False)]
_Name = Annotated[str, Field(strict=True, min_length=1, max_length=200)]
_Row = Annotated[list[_Number], Field(min_length=4, max_length=4)]


class _AppearanceModel(BaseModel):
    id: _Name
    type: _Name
    angle: _Angle | None = None


class _InterpretationModel(BaseModel):
    camera: dict[str, Any]
    appearances: Annotated[list[_AppearanceModel], Field(max_length=20_000)]


class _ViewModel(BaseModel):
    id: _Name
    T_world_camera: Annotated[list[_Row], Field(min_length=4, max_length=4)]
    interpretation: _InterpretationModel


class _FeatureModel(BaseModel):
    id: _Name
    type: _Name
    at: Annotated[list[_Number], Field(min_length=3, max_length=3)]
    data: Annotated[dict[_Name, _Name], Field(min_length=1)]


class _UnknownModel(BaseModel):
    id: _Name
    features: Annotated[list[_FeatureModel], Field(max_length=20_000)]


class _PanoramaModel(BaseModel):
    format: Literal["panorama/1"]
    views: Annotated[list[_ViewModel], Field(max_length=10_000)]
    unknown: Annotated[list[_UnknownModel], Field(max_length=20_000)]


def unknown_of(path: str, wanted: str) -> tuple[SeenFeature, ...]:
    """The features of the unknown object ``wanted`` of a panorama's file, `-` being stdin.

    Raises:
        InputError: The file's mistakes, a line each; or there is no such object.
    """
    document = read_json(path, LARGEST, "it should hold views and what was seen in them", InputError)
    name, panorama = document.name, _checked(document)
    unknown = {one.id: one for one in panorama.unknown}
    if wanted not in unknown:
        raise InputError(
            f"{name}: {wanted!r:.80} is no unknown object; there are: {', '.join(list(unknown)[:20]) or 'none'}"
        )
    views = {view.id: view for view in panorama.views}
    cameras = {view.id: camera_from_dict(view.interpretation.camera) for view in panorama.views}
    angles = {view.id: {a.id: a.angle for a in view.interpretation.appearances} for view in panorama.views}
    return tuple(_seen(feature, views, cameras, angles) for feature in unknown[wanted].features)


def _seen(
    feature: _FeatureModel,
    views: dict[str, _ViewModel],
    cameras: dict[str, Camera],
    angles: dict[str, dict[str, float | None]],
) -> SeenFeature:
    import numpy as np

    sightings = tuple(
        Sighting(np.array(views[view].T_world_camera), cameras[view].f, angles[view][datum])
        for view, datum in feature.data.items()
    )
    return SeenFeature(feature.type, np.array(feature.at), sightings)


def _checked(document: Document) -> _PanoramaModel:
    try:
        panorama = _PanoramaModel.model_validate(document.data)
    except ValidationError as error:
        found = [(e["loc"], e["msg"]) for e in error.errors(include_url=False)]
        raise _mistaken(document, [Mistake(loc, f"{what[:1].lower()}{what[1:]}") for loc, what in found]) from None
    mistakes = _twice("views", [view.id for view in panorama.views])
    mistakes += _twice("unknown", [one.id for one in panorama.unknown])
    for i, view in enumerate(panorama.views):
        mistakes += camera_mistakes(view.interpretation.camera, ("views", i, "interpretation", "camera"))
        if not is_rigid(view.T_world_camera):
            mistakes.append(Mistake(("views", i, "T_world_camera"), "must be a rigid 4x4 transform"))
    known = {view.id: {a.id: a.type for a in view.interpretation.appearances} for view in panorama.views}
    for i, one in enumerate(panorama.unknown):
        for j, feature in enumerate(one.features):
            here = ("unknown", i, "features", j)
            mistakes += [Mistake((*here, "data"), wrong) for wrong in _data_mistakes(feature, known)]
            mistakes += [Mistake((*here, "at"), wrong) for wrong in _at_a_camera(feature, panorama)]
    if mistakes:
        raise _mistaken(document, mistakes)
    return panorama


def _data_mistakes(feature: _FeatureModel, known: dict[str, dict[str, str]]) -> list[str]:
    """Data of views that are not there, that are not in these, or of another type than the feature's."""
    lines = []
    for view, datum in feature.data.items():
        if view not in known:
            lines.append(f"{view!r:.80} is no view")
        elif datum not in known[view]:
            lines.append(f"{datum!r:.80} is no appearance of {view}")
        elif known[view][datum] != feature.type:
            lines.append(
                f"{datum!r:.80} of {view} is a {known[view][datum]!r:.80}, and the feature a {feature.type!r:.80}"
            )
    return lines


def _at_a_camera(feature: _FeatureModel, panorama: _PanoramaModel) -> list[str]:
    """A feature in a camera's own place has no direction from it."""
    eyes = {view.id: [row[3] for row in view.T_world_camera[:3]] for view in panorama.views}
    near = [
        view
        for view in feature.data
        if view in eyes and max(abs(a - b) for a, b in zip(feature.at, eyes[view], strict=True)) < 1e-6
    ]
    return [f"lies in the camera of {view}" for view in near]


def _twice(key: str, ids: list[str]) -> list[Mistake]:
    twice = sorted({name for name in ids if ids.count(name) > 1})
    return [Mistake((key,), f"{name!r:.80} is the id of two") for name in twice]


def _mistaken(document: Document, mistakes: list[Mistake]) -> InputError:
    more = len(mistakes) - MOST_MISTAKES
    said = [f"{document.name}: and {more} more mistakes"] if more > 0 else []
    return InputError("\n".join(document.told(mistakes[:MOST_MISTAKES]) + said))
