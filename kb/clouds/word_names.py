"""The names of visual words, ``sift_w0000``: nobody knows one by name."""

import re

_NAME = re.compile(r"[a-z]+_w\d{4,}")


def is_word(name: str) -> bool:
    """Whether a type's name is that of a visual word, as ``kb.clouds.words.Words.names`` are."""
    return _NAME.fullmatch(name) is not None
