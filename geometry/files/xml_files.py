"""XML read safely: no entities, so that nothing is fetched and nothing grows, and no nesting that no document needs."""

import re
from xml.etree import ElementTree as ET

MAX_DEPTH = 60
"""Deepest nesting."""
_DECLARATION = re.compile(r"\A\s*<\?xml[^>]*\?>")


class XMLMistakeError(ValueError):
    """What is wrong with a text, and the ``line`` from 1, where it has one."""

    def __init__(self, message: str, line: int | None = None) -> None:
        super().__init__(message)
        self.line = line


def root_of(text: str, kind: str) -> ET.Element:
    """The root element of a document of a ``kind``, for errors; what its declaration says is not asked.

    Raises:
        XMLMistakeError: no XML, nested too deeply, or one that defines entities.
    """
    if entities := re.search("<!DOCTYPE|<!ENTITY", text):
        raise XMLMistakeError(f"defines entities, which no {kind} needs", text.count("\n", 0, entities.start()) + 1)
    try:
        root = ET.fromstring(without_declaration(text))  # noqa: S314 - no entities: see above
    except ET.ParseError as error:
        raise XMLMistakeError(f"is no XML: {error}", error.position[0]) from None
    level, depth = [root], 0
    while level:
        level, depth = [child for element in level for child in element], depth + 1
        if depth > MAX_DEPTH:
            raise XMLMistakeError(f"its elements are nested deeper than {MAX_DEPTH} levels, which no {kind} needs")
    return root


def without_declaration(text: str) -> str:
    """The text with blanks in the place of its declaration, so that lines and columns keep their numbers."""
    return _DECLARATION.sub(lambda found: re.sub(r"[^\n]", " ", found[0]), text)
