"""What a slow machine adds to stderr: that a command goes on. Tests of what is said leave it out."""

import re

_SO_FAR = re.compile(r"^.*; \d+ \w+ so far\n", re.MULTILINE)


def without_so_far(text: str) -> str:
    """The text without the lines that ``plogic.face.shown.progress.beating`` writes every ten seconds."""
    return _SO_FAR.sub("", text)
