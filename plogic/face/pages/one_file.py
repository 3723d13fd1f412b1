"""A document as one HTML file that works offline under a strict content security policy.

The policy allows nothing by default, images only as ``data:``, and of scripts and styles only the two whose SHA-256 it
names: the page's own. The document travels as JSON in a data block, so no name in it is ever read as markup or script.
"""

import base64
import hashlib
import html
import json
from collections.abc import Mapping
from dataclasses import dataclass
from importlib.resources import files
from string import Template

import numpy as np

from geometry.camera import camera_from_dict
from plogic.base.errors import BeliefError
from plogic.face.shown.against import missed_rings
from plogic.face.shown.edges import Stroke, edges_of
from plogic.face.shown.ground import ground_of, lines_in_picture
from plogic.facts.caveats import caveats
from plogic.facts.document import Interpretation


class PageError(BeliefError):
    """The document cannot be put into a page; the message says why."""


KIT = "kit"
"""The folder of what every page shares."""
SHARED = ("elements.js", "vectors.js", "stage.js", "webgl.js", "canvas.js", "textured.js")
"""The parts of the script that every page has, in the order in which they build on each other; a page's own come after
them."""


@dataclass(frozen=True)
class PageParts:
    """What a kind of page has of its own: ``main.html``, ``page.css`` and scripts in a folder of ``assets``."""

    folder: str
    scripts: tuple[str, ...]
    """In the order in which they build on each other."""
    first: str
    """The section that a keyboard skips to, by its id, such as ``worlds``."""
    unscripted: str
    """Where the numbers are for a reader whose browser runs no script: a sentence, as markup."""


def one_file(parts: PageParts, title: str, document: Mapping[str, object], **drawn: object) -> str:
    """Return the page of the document. The same document gives the same bytes.

    ``drawn``: what is computed for the page and is no part of the document, each in a data block of its name.

    Raises:
        PageError: the document holds NaN, an infinity or a value that is no JSON.
    """
    style = _asset(KIT, "page.css") + _asset(parts.folder, "page.css")
    script = _script(parts)
    return Template(_asset(KIT, "page.html")).substitute(
        title=html.escape(f"{title} – plogic"),
        first=parts.first,
        unscripted=parts.unscripted,
        main=_asset(parts.folder, "main.html"),
        style=style,
        style_hash=content_hash(style),
        script=script,
        script_hash=content_hash(script),
        data="".join(_block(name, value) for name, value in {"data": document, **drawn}.items()),
    )


def _block(name: str, value: object) -> str:
    return f'<script type="application/json" id="{name}">{embedded(value)}</script>\n'


def embedded(value: object) -> str:
    """Return the value as JSON that is safe inside a ``<script>``: ``<``, ``>`` and ``&`` only as escapes."""
    try:
        text = json.dumps(value, ensure_ascii=True, allow_nan=False, separators=(",", ":"))
    except (TypeError, ValueError) as mistake:
        named = value.get("format") if isinstance(value, Mapping) else None
        raise PageError(f"{named or 'the document'}: cannot be written as JSON: {mistake}") from mistake
    return text.replace("<", "\\u003c").replace(">", "\\u003e").replace("&", "\\u0026")


def content_hash(text: str) -> str:
    """Return the source expression ``sha256-...`` by which a content security policy names the text."""
    return "sha256-" + base64.b64encode(hashlib.sha256(text.encode()).digest()).decode()


def _script(parts: PageParts) -> str:
    body = "\n".join([*(_asset(KIT, name) for name in SHARED), *(_asset(parts.folder, name) for name in parts.scripts)])
    return f"\n(() => {{\n'use strict';\n{body}}})();\n"


def _asset(folder: str, name: str) -> str:
    return (files(__package__) / "assets" / folder / name).read_text(encoding="utf-8")


PARTS = PageParts(
    folder="report",
    scripts=(
        "model.js",
        "sides.js",
        "signs.js",
        "edges.js",
        "ground.js",
        "dots.js",
        "picture.js",
        "key.js",
        "panels.js",
        "scene.js",
        "paints.js",
        "eye.js",
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
    edges = {h: [_packed(stroke) for stroke in strokes] for h, strokes in edges_of(document).items()}
    camera = document.get("camera")
    size = (int(camera["width"]), int(camera["height"])) if camera else (0, 0)
    rows = [h for h in document.get("hypotheses", []) if h["status"] == "accepted" and h.get("outline")]
    missed = {h["id"]: rings for h in rows if (rings := missed_rings(h, size))}
    drawn = {"edges": edges, "missed": missed, "ground": _ground(document), "caveats": caveats(document)}
    return one_file(PARTS, ", ".join(accepted) or "nothing known", document, **drawn)


def _ground(document: Interpretation) -> dict[str, object] | None:
    """The likeliest support plane as ``ground.js`` reads it: ``lines`` by their ends, metres; the rest pixels."""
    ground = ground_of(document)
    if ground is None or "camera" not in document:
        return None
    camera = camera_from_dict(document["camera"])
    return {
        "name": ground.name,
        "step": ground.step,
        "lines": ground.lines[:, [0, -1]].round(4).tolist(),
        "drawn": [line.round(1).ravel().tolist() for line in lines_in_picture(ground, camera)],
        "feet": {
            h: at.round(1).tolist() for h, foot in ground.feet.items() if np.isfinite(at := camera.project(foot)).all()
        },
    }


def _packed(stroke: Stroke) -> list[object]:
    """A stroke as ``edges.js`` reads it: inner, hidden by its own object, hidden by, u, v, u, v and so on."""
    return [int(stroke.inner), int(stroke.self_hidden), [*stroke.hidden_by], *(x for uv in stroke.points for x in uv)]
