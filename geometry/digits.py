"""Whole numbers in the texts of strangers: Python reads some thousands of digits, and raises at more."""

import re
import sys

TOO_LONG = "holds a whole number of more digits than can be read"


def whole(text: str, most: int) -> int | None:
    """The number from 0 to ``most`` that ASCII digits are, zeros before it or not; None of any other text."""
    digits = text.lstrip("0")
    if not text.isascii() or not text.isdigit() or len(digits) > len(str(most)):
        return None
    number = int(digits or "0")
    return number if number <= most else None


def start_of_too_long(text: str, passed_over: str) -> int | None:
    """Where the first number of too many digits begins; none is looked for in what a pattern says."""
    pattern = rf"{passed_over}|(\d{{{sys.get_int_max_str_digits() + 1},}})"
    return next((found.start() for found in re.finditer(pattern, text) if found[1] is not None), None)
