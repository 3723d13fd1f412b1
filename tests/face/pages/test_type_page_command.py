"""``plogic kb show KB TYPE --html FILE`` through the console script."""

from __future__ import annotations

import json

from console import document, good, plogic

EXAMPLE = "first"


def test_the_page_is_written_whole_or_to_stdout(tmp_path):
    file = tmp_path / "t2.html"
    done = plogic("kb", "show", "towers", "t2", "--html", file)
    assert (done.returncode, done.stdout, done.stderr) == (0, "", f"wrote {file}\n")
    assert file.read_text(encoding="utf-8") == good("kb", "show", "towers", "t2", "--html", "-")
    assert [path.name for path in tmp_path.iterdir()] == ["t2.html"]


def test_the_only_type_needs_no_name():
    assert "<title>box – plogic</title>" in good("kb", "show", EXAMPLE, "--html", "-")


def test_what_is_wrong_is_one_line():
    for args, code, words in [
        (("towers", "--html", "-"), 1, "towers: a page shows one object type: name it; there are: t1, t2"),
        (("towers", "t3", "--html", "-"), 1, "t3: no such object type; there are: t1, t2"),
        (("towers", "t3"), 1, "t3: no such object type; there are: t1, t2"),
        (("towers", "t2", "--html", "-", "--json"), 2, "--html and --json do not go together"),
        (("towers", "t2", "--html", "/nowhere/page.html"), 1, "/nowhere"),
    ]:
        done = plogic("kb", "show", *args)
        assert (done.returncode, done.stdout) == (code, ""), args
        assert words in done.stderr.splitlines()[-1], args


def test_a_type_can_be_shown_alone_as_text():
    text = good("kb", "show", "towers", "t2")
    assert text.startswith("object t2\n")
    assert "object t1" not in text
    assert [kind["name"] for kind in document("kb", "show", "towers", "t1", "--json")["types"]] == ["t1"]
    assert json.loads(good("kb", "show", "towers", "--json"))["format"] == "kb_show/1"
