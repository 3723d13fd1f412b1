"""``type_page``: an object type as one HTML file that works offline."""

from __future__ import annotations

from typing import TYPE_CHECKING

from plogic.face.pages.one_file import PageParts, one_file
from plogic.face.pages.type_content import type_document

if TYPE_CHECKING:
    from kb.clouds.cloud import KnowledgeBase, ObjectType

PARTS = PageParts(
    folder="type",
    scripts=(
        "model.js",
        "eye.js",
        "lobes.js",
        "webgl.js",
        "canvas.js",
        "panels.js",
        "feature.js",
        "map.js",
        "stage.js",
    ),
    first="feature",
    unscripted="<code>plogic kb show</code> without <code>--html</code> prints the same type as text.",
)


def type_page(kb: KnowledgeBase, kind: ObjectType) -> str:
    """Return the page of one object type of the KB. The same KB gives the same bytes."""
    return one_file(PARTS, kind.name, type_document(kb, kind))
