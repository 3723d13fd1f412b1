"""``page``: an interpretation as one HTML file that works offline."""

from __future__ import annotations

from typing import Any

from plogic.face.pages.one_file import PageParts, one_file

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


def page(document: dict[str, Any]) -> str:
    """Return the report of an ``interpretation/1`` document as one self-contained HTML page.

    The same document gives the same bytes. Keys that are missing leave their section empty.

    Raises:
        PageError: the document holds NaN, an infinity or a value that is no JSON.
    """
    accepted = [
        str(h.get("label") or h.get("type")) for h in document.get("hypotheses", []) if h.get("status") == "accepted"
    ]
    return one_file(PARTS, ", ".join(accepted) or "nothing known", document)
