"""``page``: an interpretation as one HTML file that works offline."""

from __future__ import annotations

from typing import TYPE_CHECKING

from plogic.face.pages.one_file import PageParts, one_file

if TYPE_CHECKING:
    from plogic.facts.document import Interpretation

PARTS = PageParts(
    folder="report",
    scripts=(
        "model.js",
        "sides.js",
        "signs.js",
        "dots.js",
        "picture.js",
        "panels.js",
        "scene.js",
        "webgl.js",
        "canvas.js",
        "stage.js",
    ),
    first="worlds",
    unscripted="The numbers are also in the interpretation's JSON, at the end of this file.",
)


def page(document: Interpretation) -> str:
    """Return the report of an ``interpretation/1`` document as one self-contained HTML page.

    The same document gives the same bytes. Keys that are missing leave their section empty.

    Raises:
        PageError: the document holds NaN, an infinity or a value that is no JSON.
    """
    accepted = [h.get("label") or h["type"] for h in document.get("hypotheses", []) if h["status"] == "accepted"]
    return one_file(PARTS, ", ".join(accepted) or "nothing known", document)
