"""A camera as JSON has it, ``CameraRow``, and a pose, ``Pose``: shapes and bounds, without any arithmetic."""

from typing import Annotated, NotRequired, TypedDict

from geometry.json_shapes import Lengths, Range, Row, Rule, Size

LENGTHS = (0, 4, 5, 8, 12, 14)  # the numbers of coefficients that OpenCV knows
MAX_SIDE = 65536  # px
SHORTEST, LARGEST = (
    1e-3,
    1e9,
)  # px; focal lengths beyond, and larger numbers of a matrix, belong to no camera, and squares of them overflow
STRONGEST = 1e6  # a distortion coefficient; past a few thousand no lens is known


RIGID = "should be a rigid 4x4 matrix (row-major, metres)"
Pose = Annotated[list[Annotated[list[float], Size(4)]], Size(4), Rule(RIGID)]
"""A rigid motion, row-major, metres."""
_Focal, _Offset = Annotated[float, Range(SHORTEST, LARGEST)], Annotated[float, Range(-LARGEST, LARGEST)]
_Zero, _One = Annotated[float, Range(0.0, 0.0)], Annotated[float, Range(1.0, 1.0)]
_Rows = Row(
    Annotated[list[float], Row(_Focal, _Offset, _Offset)],
    Annotated[list[float], Row(_Zero, _Focal, _Offset)],
    Annotated[list[float], Row(_Zero, _Zero, _One)],
)


class CameraRow(TypedDict):
    """A camera as JSON: the key `camera` of other documents, or a file of its own."""

    width: Annotated[int, Range(1, MAX_SIDE), "Width of the image, pixels."]
    height: Annotated[int, Range(1, MAX_SIDE), "Height of the image, pixels."]
    K: Annotated[
        list[list[float]],
        _Rows,
        Rule("should be [[fx, skew, cx], [0, fy, cy], [0, 0, 1]]"),
        "Focal lengths, skew and principal point, pixels; an integer pixel is a pixel's centre.",
    ]
    dist: NotRequired[
        Annotated[
            list[Annotated[float, Range(-STRONGEST, STRONGEST)]],
            Lengths(*LENGTHS),
            "Lens distortion, OpenCV's coefficients in OpenCV's order: k1, k2, p1, p2, k3, ...; none: `[]`.",
        ]
    ]
    T_world_camera: NotRequired[
        Annotated[
            Pose | None, "Where the camera stands: maps camera coordinates to the world's (z up); row-major, metres."
        ]
    ]
