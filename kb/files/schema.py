"""What an author writes: the models of ``kb.yaml`` and ``object.yaml``, and their JSON Schemas.

Vocabulary: ``KBModel(name="towers", ...)``, ``ObjectModel(object="t1", ...)``. Unknown keys are mistakes.
"""

import math
from typing import Annotated, Any, Literal, Self

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, WithJsonSchema, computed_field, model_validator

from kb.clouds.cloud import UNKNOWN_SUPPORT
from kb.files.values import (
    Angle,
    Chance,
    Direction,
    Flag,
    Fold,
    HalfAngle,
    Length,
    Name,
    Odds,
    Pair,
    Pixels,
    Place,
    Positive,
    PositiveLength,
    Quaternion,
    Range,
    Share,
    Text,
    Units,
)


class Model(BaseModel):
    """What all models have in common: no key that is not known."""

    model_config = ConfigDict(extra="forbid", frozen=True)


class LobeModel(Model):
    """From where a detector can see the appearance (§2.7)."""

    axis: Direction = Field(
        description="The cone's axis, in the feature's frame, towards the viewer; its length is free."
    )
    half_angle: HalfAngle = Field(description="The cone's half-angle, such as '60 deg'.")
    range: Range = Field(description="Nearest and farthest distance at the KB's f_ref, such as [0.2 m, 30 m].")


class AppearanceModel(Model):
    """One way that a feature looks."""

    type: Name = Field(description="The appearance's type, one of the KB's appearance_types: what a detector reports.")
    size: PositiveLength | None = Field(
        None, description="How wide it is, such as '3 cm': what the detector's scale, in pixels, is the picture of."
    )
    lobe: LobeModel | None = Field(
        None, description="From where it is seen. May be absent only above other appearances."
    )
    appearances: list["AppearanceModel"] = Field([], description="Appearances that this one is made of.")

    @model_validator(mode="after")
    def _seen_from_somewhere(self) -> Self:
        if self.lobe is None and not self.appearances:
            raise ValueError("missing key 'lobe': from where the appearance is seen")
        if self.lobe is None and self.size is not None:
            raise ValueError(
                "'size' without 'lobe': what is not seen itself has no width in the picture; say it of the appearances below"
            )
        return self


class RotationModel(Model):
    """parent_from_child, in one of two forms."""

    quat_xyzw: Quaternion | None = Field(None, description="A unit quaternion, in the order x, y, z, w.")
    euler_xyz: Annotated[list[Angle], Field(min_length=3, max_length=3)] | None = Field(
        None, description="Turns about the parent's x, then y, then z axis, such as [0 deg, 0 deg, 90 deg]."
    )

    @model_validator(mode="after")
    def _one_form(self) -> Self:
        if (self.quat_xyzw is None) == (self.euler_xyz is None):
            raise ValueError("must be either quat_xyzw or euler_xyz")
        return self


class FeatureModel(Model):
    """One feature, of appearances, or of features (a compound, A1)."""

    feature: Name = Field(description="Its name, of its own among its siblings.")
    type: Name = Field(description="Its type: apex, corner, patch, ...: what distinctiveness counts.")
    at: Place = Field(description="Its place in its parent's frame, m.")
    rotation: RotationModel | None = Field(None, description="Its frame, turned against its parent's.")
    arms: list[Direction] = Field([], description="Directions, in its frame, of the surface's edges that meet here.")
    features: list["FeatureModel"] = Field(
        [], description="A compound's features; then it has no appearances of its own."
    )
    appearances: list[AppearanceModel] = Field([], description="The ways it looks, each with its viewpoints.")


class PartModel(Model):
    """One part, of parts, or of features (A1)."""

    part: Name = Field(description="Its name, of its own among its siblings.")
    type: Name | None = Field(None, description="Its type; its name, if not given.")
    at: Place = Field((0.0, 0.0, 0.0), description="Its place in its parent's frame, m.")
    rotation: RotationModel | None = Field(None, description="Its frame, turned against its parent's.")
    parts: list["PartModel"] = Field([], description="Its parts.")
    features: list[FeatureModel] = Field([], description="Its features.")


class MeshModel(Model):
    """The type's surface, closed where it can be, and what shows it painted."""

    file: Text = Field(description="The mesh's file, beside object.yaml; anything that trimesh reads.")
    units: Units = Field(
        description="The unit of the mesh's coordinates. No mesh format carries it, so it must be stated."
    )
    textured: Text | None = Field(
        None, description="The same mesh with its texture, an OBJ in the same unit: what is rendered."
    )


class FileModel(Model):
    """A file that a machine made."""

    file: Text = Field(description="The file, beside this one.")


class SymmetryModel(Model):
    """Rigid motions that change nothing: turns about an axis, or one motion.

    All the products of what is listed are meant.
    """

    axis: Direction | None = Field(None, description="The axis of the turns, object frame.")
    fold: Fold | None = Field(None, description="How many turns make a full one: 4 for a square tower.")
    continuous: Flag = Field(default=False, description="Any turn about the axis changes nothing; sampled every 5 deg.")
    quat_xyzw: Quaternion | None = Field(None, description="Instead of an axis: one rotation.")
    at: Place = Field(
        (0.0, 0.0, 0.0), description="A point that the axis runs through; for a single motion, the shift."
    )

    @model_validator(mode="after")
    def _one_form(self) -> Self:
        if (self.axis is None) == (self.quat_xyzw is None):
            raise ValueError("must have either axis or quat_xyzw")
        if (self.fold is not None) + self.continuous != (self.axis is not None):
            raise ValueError("an axis must have either fold or continuous: true; quat_xyzw has neither")
        return self


class StandModel(Model):
    """One way in which the type stands."""

    down: Direction = Field(description="What is below, object frame; within 10 deg of a face that it can stand on.")
    weight: Positive = Field(1.0, description="How often it stands so, against the others: the sum is free.")


def _stands(value: object) -> object:
    if value == "never":
        return []
    if isinstance(value, list) and value:
        return value
    raise ValueError(f"must be never, or a list of one or more ways to stand, not {value!r:.60}")


Stands = Annotated[
    list[StandModel] | None,
    BeforeValidator(_stands),
    WithJsonSchema(
        {"anyOf": [{"enum": ["never"]}, {"type": "array", "minItems": 1, "items": StandModel.model_json_schema()}]}
    ),
]


class ObjectModel(Model):
    """``object.yaml``: one type of maximal object (D3)."""

    object: Name = Field(description="The type's name.")
    mesh: MeshModel | None = Field(None, description="Its surface. A type without one hides nothing.")
    opaque: Flag = Field(default=True, description="Whether it hides what is behind it.")
    symmetries: list[SymmetryModel] = Field([], description="Motions of its frame that change nothing.")
    stands: Stands = Field(
        None,
        description="How it stands, or never (it hangs, or is held); left out, on any face that its mesh can stand on.",
    )
    parts: list[PartModel] = Field([], description="Its parts; or else features (A1).")
    features: list[FeatureModel] = Field([], description="Its features, if it has no parts.")
    cloud: FileModel | None = Field(
        None, description="Its learned features (`plogic kb learn`), each of its nearest part; none by hand."
    )


class DetectorModel(Model):
    """Detector statistics."""

    hit: dict[Name, Share] = Field(
        {}, description="Chance that an expected feature is detected, per feature type; 0.8."
    )
    clutter: dict[Name, Positive] = Field(
        {}, description="Appearances of noise per image and appearance type; by P(dv), 1 on the average."
    )
    sigma: Pixels = Field(1.0, description="Location noise, pixels.")
    sigmas: dict[Name, Pixels] = Field(
        {}, description="Location noise per feature type, pixels, where it is not sigma."
    )
    sigma_angle: HalfAngle | None = Field(
        None,
        description="Noise of a datum's angle, which is how its feature's x axis lies on the screen; left out, angles say nothing.",
    )
    match_tolerance: Pixels = Field(
        4.0, description="How far from its predicted place a feature may be found, px (D8)."
    )


class GravityModel(Model):
    """That things rest, and what is not known of it."""

    rests: Odds = Field(
        1.0 - UNKNOWN_SUPPORT, description="Chance that a thing rests on another, a plane or the ground."
    )
    unknown_support: Chance = Field(
        UNKNOWN_SUPPORT,
        description="1 - rests: chance that something unknown holds what floats; 1: nothing is made of it.",
    )
    ground: Length | None = Field(
        None, description="The ground's height, world z; left out, it is where the lowest object of a world stands."
    )

    @model_validator(mode="after")
    def _said_once(self) -> Self:
        both = {"rests", "unknown_support"} <= self.model_fields_set
        if both and not math.isclose(self.rests + self.unknown_support, 1.0, abs_tol=1e-9):
            raise ValueError(
                f"unknown_support is 1 - rests: {self.unknown_support:g} and {self.rests:g} contradict each other; say one of them"
            )
        return self

    @computed_field  # type: ignore[prop-decorator]
    @property
    def certain(self) -> bool:
        """Whether worlds in which something floats are less probable."""
        return True

    @computed_field  # type: ignore[prop-decorator]
    @property
    def floats(self) -> float:
        """Chance that something unknown holds what floats, whichever way it is said."""
        told = "rests" in self.model_fields_set and "unknown_support" not in self.model_fields_set
        return round(1.0 - self.rests, DIGITS) if told else self.unknown_support


DIGITS = 12
"""Decimals to which 1 - rests is taken: 0.9 leaves 0.1."""
MAYBE = "maybe"


class _Maybe(GravityModel):
    """``gravity: maybe``: things rest, it is likely, on planes that nobody knows."""

    @computed_field  # type: ignore[prop-decorator]
    @property
    def certain(self) -> bool:
        """They need not."""
        return False


def _gravity(value: object) -> object:
    if value == MAYBE:
        return _Maybe.model_validate({})
    if isinstance(value, dict):
        return value
    if isinstance(value, bool):
        return {} if value else None
    raise ValueError(f"must be true, false, maybe, or a mapping of keys to values, not {value!r:.60}")


Gravity = Annotated[
    GravityModel | None,
    BeforeValidator(_gravity),
    WithJsonSchema({"anyOf": [{"type": "boolean"}, {"enum": [MAYBE]}, GravityModel.model_json_schema()]}),
]


class CountsModel(Model):
    """What the rates were learned from; written by ``plogic kb learn-rates``."""

    hit: dict[Name, Pair] = Field({}, description="[detected, expected] per feature type.")
    clutter: dict[Name, Pair] = Field({}, description="[appearances of noise, images] per appearance type.")
    prior: dict[Name, Pair] = Field({}, description="[present, instances and empty images] per object type.")


def _no_counts() -> CountsModel:
    return CountsModel.model_validate({})


def _no_statistics() -> DetectorModel:
    return DetectorModel.model_validate({})


class KBModel(Model):
    """``kb.yaml``: what holds for all types."""

    name: Name = Field(description="The knowledge base's name.")
    appearance_types: list[Name] = Field(description="The vocabulary of appearance types, which detectors report.")
    f_ref: Pixels = Field(600.0, description="The focal length, pixels, that the lobes' ranges hold for.")
    detector: DetectorModel = Field(
        default_factory=_no_statistics,
        description="What is known of the detectors: hit rates, clutter, location noise.",
    )
    gravity: Gravity = Field(
        default=False,
        validate_default=True,
        description="Whether things rest: what floats is less probable, and what is not found yet is looked for on the plane that others stand on. "
        "`maybe`: it is likely that they do, on planes nobody knows.",
    )
    words: FileModel | None = Field(
        None, description="The visual words that learned clouds are made of (`plogic kb learn`)."
    )
    priors: dict[Name, Share] = Field({}, description="Chance of an instance, per object type; 0.5.")
    counts: CountsModel = Field(
        default_factory=_no_counts, description="What the rates were learned from: [n, of] each."
    )


def json_schema(which: Literal["kb", "object"]) -> dict[str, Any]:
    """The JSON Schema of ``kb.yaml`` or ``object.yaml``; every key has a description."""
    model = KBModel if which == "kb" else ObjectModel
    return {"$schema": "https://json-schema.org/draft/2020-12/schema"} | model.model_json_schema()
