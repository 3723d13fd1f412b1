"""Shapes of what ``interpretation/1`` carries along: how types are seen, the picture, and surfaces."""

from typing import Annotated, Literal, NotRequired, TypedDict

from geometry.json_shapes import Row, Size
from plogic.facts.fact_rows import Count, Name, Point3, Positive

PlacedFeature = Annotated[list[str | float], Row(Name, Name, float, float, float)]
LobeNumbers = Annotated[list[float], Row(Count, Count, float, float, float, float, float, float, float)]


class TypeRow(TypedDict):
    """How one type is seen: [id, type, x, y, z] of features, and lobes as rows of numbers (``plogic.run.carried``).

    ``facets``, ``faces``: polygons of its surface whose corners are features.
    """

    features: Annotated[
        list[PlacedFeature],
        "Its features: name, feature type, place in the object's frame, m.",
    ]
    looks: Annotated[list[Name], "The appearance types of its lobes."]
    lobes: Annotated[
        list[LobeNumbers],
        "From where features are seen: number of the feature, number of the look, axis, half-angle, nearest and farthest distance, m, hit rate.",
    ]
    measured: Annotated[bool, "Whether the hit rates were measured."]
    facets: NotRequired[
        Annotated[list[Annotated[list[Name], Size(3)]], "Triangles of its surface whose corners are features."]
    ]
    faces: NotRequired[
        Annotated[list[Annotated[list[Name], Size(3, 1000)]], "Polygons of its surface whose corners are features."]
    ]
    left_out: NotRequired[Annotated[dict[Name, Count], "Features that are not listed, by feature type."]]


class ImageRow(TypedDict):
    """The picture, base64; the size is the original's."""

    media_type: Annotated[Literal["image/png", "image/jpeg"], "Kind of the picture."]
    width: Annotated[Count, "Width of the original, pixels."]
    height: Annotated[Count, "Height of the original, pixels."]
    base64: Annotated[str, "The picture's bytes."]


class MeshRow(TypedDict):
    """A surface, m, object frame; ``slack``: how far off it may be."""

    vertices: Annotated[list[Point3], "Points, object frame, m."]
    triangles: Annotated[list[Annotated[list[Count], Size(3)]], "Numbers of three vertices each."]
    slack: NotRequired[Annotated[Positive, "How far off the simplified surface may be, m."]]


class TextureRow(TypedDict):
    """The texture of a surface, base64."""

    media_type: Annotated[Literal["image/jpeg"], "Kind of the picture."]
    base64: Annotated[str, "The picture's bytes."]


class PaintRow(TypedDict):
    """A surface with its texture or its vertices' colours, to be looked at; arrays are base64, little-endian."""

    vertices: Annotated[str, "Points, object frame, m: float32, three each."]
    triangles: Annotated[str, "Numbers of three vertices each: uint16."]
    uv: NotRequired[Annotated[str, "Texture coordinates of each vertex, (0, 0) at the lower left: float32, two each."]]
    picture: NotRequired[Annotated[TextureRow, "The texture."]]
    colours: NotRequired[Annotated[str, "Instead of these: red, green, blue of each vertex: uint8, three each."]]


class AssetsRow(TypedDict):
    """What is carried along to be looked at."""

    image: NotRequired[Annotated[ImageRow, "The picture."]]
    meshes: NotRequired[Annotated[dict[Name, MeshRow], "Surfaces by object type."]]
    paints: NotRequired[Annotated[dict[Name, PaintRow], "Surfaces with their textures, by object type."]]
