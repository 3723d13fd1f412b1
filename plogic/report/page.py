"""``page``: an interpretation as one HTML file that works offline under a strict content security policy.

The policy allows nothing by default, images only as ``data:``, and of scripts and styles only the two whose SHA-256 it
names: the page's own. The document travels as JSON in a data block, so no name in it is ever read as markup or script.
"""

from __future__ import annotations

import base64
import hashlib
import html
import json
from importlib.resources import files
from string import Template
from typing import Any

from plogic.report.errors import ReportError

SCRIPTS = ("model.js", "elements.js", "dots.js", "picture.js", "panels.js", "scene.js", "webgl.js", "canvas.js", "stage.js")
"""The parts of the script, in the order in which they build on each other."""


def page(document: dict[str, Any]) -> str:
    """Return the report of an ``interpretation/1`` document as one self-contained HTML page.

    The same document gives the same bytes. Keys that are missing leave their section empty.

    Raises:
        ReportError: the document holds NaN, an infinity or a value that is no JSON.
    """
    style, script = _asset("page.css"), _script()
    return Template(_asset("page.html")).substitute(
        title=html.escape(_title(document)),
        style=style,
        style_hash=content_hash(style),
        script=script,
        script_hash=content_hash(script),
        data=embedded(document),
    )


def embedded(document: dict[str, Any]) -> str:
    """Return the document as JSON that is safe inside a ``<script>``: ``<``, ``>`` and ``&`` only as escapes."""
    try:
        text = json.dumps(document, ensure_ascii=True, allow_nan=False, separators=(",", ":"))
    except (TypeError, ValueError) as mistake:
        raise ReportError(f"interpretation: cannot be written as JSON: {mistake}") from mistake
    return text.replace("<", "\\u003c").replace(">", "\\u003e").replace("&", "\\u0026")


def content_hash(text: str) -> str:
    """Return the source expression ``sha256-...`` by which a content security policy names the text."""
    return "sha256-" + base64.b64encode(hashlib.sha256(text.encode()).digest()).decode()


def _script() -> str:
    body = "\n".join(_asset(name) for name in SCRIPTS)
    return f"\n(() => {{\n'use strict';\n{body}}})();\n"


def _asset(name: str) -> str:
    return (files("plogic.report") / "assets" / name).read_text(encoding="utf-8")


def _title(document: dict[str, Any]) -> str:
    accepted = [
        str(h.get("label") or h.get("type")) for h in document.get("hypotheses", []) if h.get("status") == "accepted"
    ]
    return f"{', '.join(accepted) or 'nothing known'} – plogic"
