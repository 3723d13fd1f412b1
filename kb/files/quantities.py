"""Quantities as an author writes them.

``'100 deg'``, ``'0.2 m'``, ``'5 cm'``, or a plain number in SI units (m, rad).
"""

import math

LENGTHS = {"m": 1.0, "dm": 0.1, "cm": 0.01, "mm": 0.001, "um": 1e-6, "km": 1000.0, "in": 0.0254, "ft": 0.3048}
"""Metres in a unit."""
ANGLES = {"rad": 1.0, "deg": math.pi / 180, "turn": 2 * math.pi}
"""Radians in a unit."""
LARGEST = 1e9
"""What lengths stay below, in m, and numbers of imported files: so their squares are numbers."""


def length(value: object) -> float:
    """Metres: ``length("5 cm") == 0.05``.

    Raises:
        ValueError: for anything but a number with a unit of length, or without a unit, of less than ``LARGEST``.
    """
    found = _quantity(value, LENGTHS, "a length in metres, such as 0.2 or '20 cm'")
    if abs(found) >= LARGEST:
        raise ValueError(f"must be below {LARGEST:g} m, not {value!r:.60}")
    return found


def angle(value: object) -> float:
    """Radians: ``angle("180 deg") == math.pi``.

    Raises:
        ValueError: for anything but a finite number with a unit of angle, or without a unit.
    """
    return _quantity(value, ANGLES, "an angle in radians, such as 1.2 or '70 deg'")


def number(value: object) -> float:
    """A finite number without a unit; a truth value is none.

    Raises:
        ValueError: for anything else.
    """
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise ValueError(f"must be a number, not {value!r:.60}")  # noqa: TRY004 - pydantic wants a ValueError
    return _finite(value)


def _quantity(value: object, units: dict[str, float], wanted: str) -> float:
    if not isinstance(value, str):
        if isinstance(value, bool) or not isinstance(value, int | float):
            raise ValueError(f"must be {wanted}, not {value!r:.60}")  # noqa: TRY004 - pydantic wants a ValueError
        return _finite(value)
    digits, unit = split(value)
    if unit not in units:
        raise ValueError(f"must be {wanted}, not {value!r:.60}; units: {', '.join(units)}")
    try:
        return _finite(float(digits) * units[unit])
    except ValueError as error:
        raise ValueError(f"must be {wanted}, not {value!r:.60}") from error


def split(text: str) -> tuple[str, str]:
    """``'60deg'`` and ``'60 deg'`` into digits and unit."""
    stem = text.strip().rstrip("abcdefghijklmnopqrstuvwxyz")
    return stem.rstrip(), text.strip()[len(stem) :]


def _finite(value: float) -> float:
    try:
        result = float(value)
    except OverflowError:
        result = math.inf
    if not math.isfinite(result):
        raise ValueError(f"must be finite, not {result}")
    return result
