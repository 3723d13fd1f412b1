"""Outputs that cannot be written are told before any work: one clear line, exit 1, nothing written."""

from __future__ import annotations

import json

import pytest
from refusals import ONE, assert_lines, refused

OUTPUTS = {
    (
        "perceive",
        "gamma.json",
        "--kb",
        "towers",
        "-o",
        "no/out.json",
        "--report",
        "page.html",
    ): "no/out.json: cannot be written: No such directory",
    (
        "perceive",
        "gamma.json",
        "--kb",
        "towers",
        "-o",
        "out.json",
        "--report",
        "no/page.html",
    ): "no/page.html: cannot be written: No such directory",
    (
        "perceive",
        "gamma.json",
        "--kb",
        "towers",
        "-o",
        "out.json",
        "--timings",
        "no/t.json",
    ): "no/t.json: cannot be written: No such directory",
    (
        "perceive",
        "gamma.json",
        "--kb",
        "towers",
        "--picture",
        "no/p.png",
    ): "no/p.png: cannot be written: No such directory",
    (
        "perceive",
        "gamma.json",
        "--kb",
        "towers",
        "-o",
        "folder.json",
        "--report",
        "page.html",
    ): "folder.json: cannot be written: Is a directory",
    (
        "perceive",
        "gamma.json",
        "--kb",
        "towers",
        "-o",
        "empty.png/x",
        "--report",
        "page.html",
    ): "empty.png/x: cannot be written: Not a directory",
    (
        "perceive",
        "gamma.json",
        "--kb",
        "towers",
        "-o",
        "x.json",
        "--timings",
        "x.json",
    ): "x.json: is named for two outputs",
    ("report", "interpretation.json", "-o", "no/page.html"): "no/page.html: cannot be written: No such directory",
    ("report", "interpretation.json", "-o", "folder.json"): "folder.json: cannot be written: Is a directory",
    ("simulate", "--kb", "towers", "-o", "empty.png"): "empty.png: exists already and is not an empty folder",
    ("simulate", "--kb", "towers", "-o", "empty.png/x"): "empty.png/x: cannot be written",
    ("demo", "-o", "empty.png"): "empty.png: cannot be written: empty.png is no folder",
}


@pytest.mark.parametrize("args", OUTPUTS, ids=" ".join)
def test_an_output_that_cannot_be_written(args, inputs, gamma):
    (inputs / "gamma.json").write_text(json.dumps({**gamma, "appearances": [ONE]}))
    assert_lines(refused(inputs, *args), [OUTPUTS[args]])
