"""Values as an author writes them in ``kb.yaml`` and ``object.yaml``.

Quantities, names, places, directions, rates, and their JSON Schemas.

Vocabulary: ``HalfAngle``, written ``'60 deg'``; ``Range``, ``[0.2 m, 30 m]``; ``Pair``, ``[12, 20]``.
"""

import math
from collections.abc import Callable
from typing import Annotated, Any

from pydantic import BeforeValidator, WithJsonSchema

from kb.files.quantities import ANGLES, LENGTHS, angle, length, number, split

MAX_NAME = 200
"""Most characters of a name."""
UNIT = 1e-9
"""A direction whose length is this near to 1 is left as it is, so that what was written comes back the same."""


def _shape(kind: str, example: str) -> WithJsonSchema:
    either = [{"type": "number"}, {"type": "string", "examples": [example]}]
    return WithJsonSchema({"anyOf": either, "description": f"{kind}, a plain number being SI"})


def _items(value: object, size: int) -> list[Any]:
    if not isinstance(value, list) or len(value) != size:
        raise ValueError(f"must be a list of {size}, not {value!r:.60}")
    return value


def _direction(value: object) -> tuple[float, ...]:
    numbers = [number(item) for item in _items(value, 3)]
    largest = max(abs(item) for item in numbers)
    if not largest:
        raise ValueError("must be a direction, not the zero vector")
    scale = math.hypot(*(item / largest for item in numbers))
    if abs(largest * scale - 1) < UNIT:
        return tuple(numbers)
    return tuple(item / largest / scale for item in numbers)


def _place(value: object) -> tuple[float, ...]:
    return tuple(length(item) for item in _items(value, 3))


def _quaternion(value: object) -> tuple[float, ...]:
    numbers = tuple(number(item) for item in _items(value, 4))
    if not math.isclose(math.hypot(*numbers), 1.0, abs_tol=1e-3):
        raise ValueError(f"must be of length 1, not {math.hypot(*numbers):.4g}")
    return numbers


def _half_angle(value: object) -> float:
    size = angle(value)
    if not 0 < size <= math.pi + 1e-9:
        unit = split(value)[1] if isinstance(value, str) else "rad"
        told = f"must be above 0 and at most {math.pi / ANGLES[unit]:.6g} {unit}, not {size / ANGLES[unit]:.6g} {unit}"
        degrees = not isinstance(value, str) and 0 < size <= 180
        raise ValueError(f"{told}; a plain number is in rad: for degrees write '{value} deg'" if degrees else told)
    return min(size, math.pi)


def _range(value: object) -> tuple[float, ...]:
    low, high = (length(item) for item in _items(value, 2))
    if not 0 <= low < high:
        raise ValueError(f"must be [nearest, farthest] with 0 <= nearest < farthest, not [{low:g} m, {high:g} m]")
    return low, high


def _wide(value: object) -> float:
    size = length(value)
    if size <= 0.0:
        raise ValueError(f"must be above 0, not {value!r:.60}")
    return size


def _value_that(holds: Callable[[Any], bool], wanted: str) -> BeforeValidator:
    """A value for which ``holds`` is true; ``wanted`` says so in the mistake."""

    def read(value: object) -> object:
        if not holds(value):
            raise ValueError(f"must be {wanted}, not {value!r:.60}")
        return value

    return BeforeValidator(read)


def _is_name(value: object) -> bool:
    return isinstance(value, str) and bool(value.strip()) and len(value) <= MAX_NAME and not set(value) & set("/#\n\t")


def _is_fold(value: object) -> bool:
    return isinstance(value, int) and not isinstance(value, bool) and 2 <= value <= 360


def _number_that(holds: Callable[[float], bool], wanted: str) -> BeforeValidator:
    """A number for which ``holds`` is true; ``wanted`` says so in the mistake."""

    def read(value: object) -> float:
        found = number(value)
        if not holds(found):
            raise ValueError(f"must be {wanted}, not {found:g}")
        return found

    return BeforeValidator(read)


def _pair(value: object) -> tuple[float, ...]:
    part, whole = (number(item) for item in _items(value, 2))
    if not (part >= 0 and whole >= 0):
        raise ValueError(f"must be [n, of], neither below 0, not {value!r:.60}")
    return part, whole


_TRIPLE = {"type": "array", "minItems": 3, "maxItems": 3}
_MEASURE = {"type": ["number", "string"]}
_OPEN = {"type": "number", "exclusiveMinimum": 0}

Name = Annotated[
    str,
    _value_that(_is_name, "a name without '/' and '#'"),
    WithJsonSchema({"type": "string", "pattern": "^[^/#\n\t]+$"}),
]
Text = Annotated[str, _value_that(lambda x: isinstance(x, str) and x != "", "a text")]
Place = Annotated[tuple[float, ...], BeforeValidator(_place), WithJsonSchema({**_TRIPLE, "items": _MEASURE})]
Direction = Annotated[
    tuple[float, ...], BeforeValidator(_direction), WithJsonSchema({**_TRIPLE, "items": {"type": "number"}})
]
Quaternion = Annotated[
    tuple[float, ...],
    BeforeValidator(_quaternion),
    WithJsonSchema({"type": "array", "minItems": 4, "maxItems": 4, "items": {"type": "number"}}),
]
Angle = Annotated[float, BeforeValidator(angle), _shape("an angle", "90 deg")]
HalfAngle = Annotated[float, BeforeValidator(_half_angle), _shape("an angle, at most 180 deg", "60 deg")]
Range = Annotated[
    tuple[float, ...],
    BeforeValidator(_range),
    WithJsonSchema({"type": "array", "minItems": 2, "maxItems": 2, "items": _MEASURE}),
]
LEAST = 1e-8
"""A chance that is nearer to 0 or 1 counts as this one (``plogic.base.bounds``)."""
Share = Annotated[
    float,
    _number_that(lambda x: LEAST <= x <= 1 - LEAST, f"above 0 and below 1, by {LEAST:g} at least"),
    WithJsonSchema({"type": "number", "minimum": LEAST, "maximum": 1 - LEAST}),
]
Chance = Annotated[
    float, _number_that(lambda x: 0 < x <= 1, "above 0 and at most 1"), WithJsonSchema({**_OPEN, "maximum": 1})
]
Odds = Annotated[
    float,
    _number_that(lambda x: 0 <= x < 1, "at least 0 and below 1"),
    WithJsonSchema({"type": "number", "minimum": 0, "exclusiveMaximum": 1}),
]
Length = Annotated[float, BeforeValidator(length), _shape("a length", "75 cm")]
PositiveLength = Annotated[float, BeforeValidator(_wide), _shape("a length above 0", "3 cm")]
Positive = Annotated[float, _number_that(lambda x: x > 0, "above 0"), WithJsonSchema(_OPEN)]
Pixels = Annotated[
    float,
    _number_that(lambda x: 1e-6 <= x <= 1e9, "from 1e-6 to 1e9"),
    WithJsonSchema({"type": "number", "minimum": 1e-6, "maximum": 1e9}),
]
Flag = Annotated[bool, _value_that(lambda x: isinstance(x, bool), "true or false")]
Fold = Annotated[
    int,
    _value_that(_is_fold, "a whole number from 2 to 360"),
    WithJsonSchema({"type": "integer", "minimum": 2, "maximum": 360}),
]
Units = Annotated[
    str,
    _value_that(lambda x: isinstance(x, str) and x in LENGTHS, f"one of {', '.join(LENGTHS)}"),
    WithJsonSchema({"enum": list(LENGTHS)}),
]
Pair = Annotated[
    tuple[float, ...],
    BeforeValidator(_pair),
    WithJsonSchema({"type": "array", "minItems": 2, "maxItems": 2, "items": {"type": "number", "minimum": 0}}),
]
