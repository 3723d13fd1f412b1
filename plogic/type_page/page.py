"""``type_page``: an object type as one HTML file that works offline, under the same strict policy as the report of an interpretation."""

from __future__ import annotations

import html
from importlib.resources import files
from string import Template
from typing import TYPE_CHECKING

from plogic.report.page import content_hash, embedded
from plogic.type_page.content import type_document

if TYPE_CHECKING:
    from kb.cloud import KnowledgeBase, ObjectType

SCRIPTS = ("model.js", "elements.js", "eye.js", "lobes.js", "webgl.js", "canvas.js", "panels.js", "feature.js", "map.js", "stage.js")
"""The parts of the script, in the order in which they build on each other."""


def type_page(kb: KnowledgeBase, kind: ObjectType) -> str:
    """Return the page of one object type of the KB. The same KB gives the same bytes."""
    style = _asset("plogic.report", "page.css") + _asset("plogic.type_page", "type.css")
    script = _script()
    return Template(_asset("plogic.type_page", "type.html")).substitute(
        title=html.escape(f"{kind.name} – plogic"),
        style=style,
        style_hash=content_hash(style),
        script=script,
        script_hash=content_hash(script),
        data=embedded(type_document(kb, kind)),
    )


def _script() -> str:
    body = "\n".join(_asset("plogic.type_page", name) for name in SCRIPTS)
    return f"\n(() => {{\n'use strict';\n{body}}})();\n"


def _asset(package: str, name: str) -> str:
    return (files(package) / "assets" / name).read_text(encoding="utf-8")
