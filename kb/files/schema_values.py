"""The values of ``kb.yaml`` and ``object.yaml``, as pydantic reads them: names, places, directions, angles, rates, and their JSON Schemas.

Vocabulary: ``HalfAngle``, written ``'60 deg'``; ``Range``, ``[0.2 m, 30 m]``; ``Pair``, ``[12, 20]``. Plain numbers are
in SI units.
"""

from __future__ import annotations

import math
from typing import Annotated, Any

from pydantic import BeforeValidator, WithJsonSchema

from kb import quantities

MAX_NAME = 200
"""Most characters of a name."""
UNIT = 1e-9
"""A direction whose length is this near to 1 is left as it is, so that what was written comes back the same."""


def _shape(kind: str, example: str) -> WithJsonSchema:
    either = [{"type": "number"}, {"type": "string", "examples": [example]}]
    return WithJsonSchema({"anyOf": either, "description": f"{kind}, a plain number being SI"})


def _name(value: object) -> str:
    if not isinstance(value, str) or not value.strip() or len(value) > MAX_NAME or set(value) & set("/#\n\t"):
        raise ValueError(f"must be a name without '/' and '#', not {value!r:.60}")
    return value


def _text(value: object) -> str:
    if not isinstance(value, str) or not value:
        raise ValueError(f"must be a text, not {value!r:.60}")
    return value


def _items(value: object, size: int) -> list[Any]:
    if not isinstance(value, list) or len(value) != size:
        raise ValueError(f"must be a list of {size}, not {value!r:.60}")
    return value


def _direction(value: object) -> tuple[float, ...]:
    numbers = [quantities.number(item) for item in _items(value, 3)]
    largest = max(abs(item) for item in numbers)
    if not largest:
        raise ValueError("must be a direction, not the zero vector")
    scale = math.hypot(*(item / largest for item in numbers))
    if abs(largest * scale - 1) < UNIT:
        return tuple(numbers)
    return tuple(item / largest / scale for item in numbers)


def _place(value: object) -> tuple[float, ...]:
    return tuple(quantities.length(item) for item in _items(value, 3))


def _quaternion(value: object) -> tuple[float, ...]:
    numbers = tuple(quantities.number(item) for item in _items(value, 4))
    if not math.isclose(math.hypot(*numbers), 1.0, abs_tol=1e-3):
        raise ValueError(f"must be of length 1, not {math.hypot(*numbers):.4g}")
    return numbers


def _half_angle(value: object) -> float:
    size = quantities.angle(value)
    if not 0 < size <= math.pi + 1e-9:
        raise ValueError(f"must be above 0 and at most 180 deg, not {math.degrees(size):.6g} deg")
    return min(size, math.pi)


def _range(value: object) -> tuple[float, ...]:
    low, high = (quantities.length(item) for item in _items(value, 2))
    if not 0 <= low < high:
        raise ValueError(f"must be [nearest, farthest] with 0 <= nearest < farthest, not [{low:g} m, {high:g} m]")
    return low, high


def _share(value: object) -> float:
    share = quantities.number(value)
    if not 0 < share < 1:
        raise ValueError(f"must be above 0 and below 1, not {share:g}")
    return share


def _wide(value: object) -> float:
    length = quantities.length(value)
    if length <= 0.0:
        raise ValueError(f"must be above 0, not {value!r:.60}")
    return length


def _chance(value: object) -> float:
    chance = quantities.number(value)
    if not 0 < chance <= 1:
        raise ValueError(f"must be above 0 and at most 1, not {chance:g}")
    return chance


def _positive(value: object) -> float:
    size = quantities.number(value)
    if size <= 0:
        raise ValueError(f"must be above 0, not {size:g}")
    return size


def _flag(value: object) -> bool:
    if not isinstance(value, bool):
        raise ValueError(f"must be true or false, not {value!r:.60}")  # noqa: TRY004 - pydantic wants a ValueError
    return value


def _fold(value: object) -> int:
    if isinstance(value, bool) or not isinstance(value, int) or not 2 <= value <= 360:
        raise ValueError(f"must be a whole number from 2 to 360, not {value!r:.60}")
    return value


def _pair(value: object) -> tuple[float, ...]:
    part, whole = (quantities.number(item) for item in _items(value, 2))
    if not (part >= 0 and whole >= 0):
        raise ValueError(f"must be [n, of], neither below 0, not {value!r:.60}")
    return part, whole


_TRIPLE = {"type": "array", "minItems": 3, "maxItems": 3}
_MEASURE = {"type": ["number", "string"]}
_OPEN = {"type": "number", "exclusiveMinimum": 0}

Name = Annotated[str, BeforeValidator(_name), WithJsonSchema({"type": "string", "pattern": "^[^/#\n\t]+$"})]
Text = Annotated[str, BeforeValidator(_text)]
Place = Annotated[tuple[float, ...], BeforeValidator(_place), WithJsonSchema({**_TRIPLE, "items": _MEASURE})]
Direction = Annotated[
    tuple[float, ...], BeforeValidator(_direction), WithJsonSchema({**_TRIPLE, "items": {"type": "number"}})
]
Quaternion = Annotated[
    tuple[float, ...],
    BeforeValidator(_quaternion),
    WithJsonSchema({"type": "array", "minItems": 4, "maxItems": 4, "items": {"type": "number"}}),
]
Angle = Annotated[float, BeforeValidator(quantities.angle), _shape("an angle", "90 deg")]
HalfAngle = Annotated[float, BeforeValidator(_half_angle), _shape("an angle, at most 180 deg", "60 deg")]
Range = Annotated[
    tuple[float, ...],
    BeforeValidator(_range),
    WithJsonSchema({"type": "array", "minItems": 2, "maxItems": 2, "items": _MEASURE}),
]
Share = Annotated[float, BeforeValidator(_share), WithJsonSchema({**_OPEN, "exclusiveMaximum": 1})]
Chance = Annotated[float, BeforeValidator(_chance), WithJsonSchema({**_OPEN, "maximum": 1})]
Length = Annotated[float, BeforeValidator(quantities.length), _shape("a length", "75 cm")]
PositiveLength = Annotated[float, BeforeValidator(_wide), _shape("a length above 0", "3 cm")]
Positive = Annotated[float, BeforeValidator(_positive), WithJsonSchema(_OPEN)]
Flag = Annotated[bool, BeforeValidator(_flag)]
Fold = Annotated[int, BeforeValidator(_fold), WithJsonSchema({"type": "integer", "minimum": 2, "maximum": 360})]
Units = Annotated[str, BeforeValidator(quantities.unit_of_length), WithJsonSchema({"enum": list(quantities.LENGTHS)})]
Pair = Annotated[
    tuple[float, ...],
    BeforeValidator(_pair),
    WithJsonSchema({"type": "array", "minItems": 2, "maxItems": 2, "items": {"type": "number", "minimum": 0}}),
]
