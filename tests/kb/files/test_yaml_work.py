"""YAML that would take long is refused by what is counted before it is parsed."""

import pytest

from kb.files import yaml_text
from kb.files.yaml_text import MAX_NODES, SLOWLY_READ, load

ROWS = "- {a: [1, 2, 3], b: 'x y', c: 1.5e3}\n"


def wrong(text):
    (mistake,) = load("x.yaml", text.encode()).mistakes
    return str(mistake)


@pytest.mark.parametrize(
    ("text", "why"),
    [
        ("- 1\n" * (MAX_NODES + 1), "x.yaml:1:1: no YAML: more than 500000 lines and commas"),
        ("a: [" + "1," * (MAX_NODES + 1) + "1]", "x.yaml:1:1: no YAML: more than 500000 lines and commas"),
        ("[" * 2000 + " " * SLOWLY_READ, "x.yaml:1:1: no YAML: too many brackets, or spaces before a line"),
        (" " * 2000 + "a: 1\n" + "b: 1\n" * SLOWLY_READ, "x.yaml:1:1: no YAML: too many brackets, or spaces"),
        ("[" * 2000, "x.yaml:1:62: nested deeper than 60 levels"),
    ],
)
def test_what_would_take_long_is_refused(text, why):
    assert wrong(text).startswith(why)


@pytest.mark.parametrize("rows", [10, 2000])
def test_a_mistake_at_the_end_is_told_at_its_place_by_one_parser_or_the_other(rows, monkeypatch):
    asked = []
    composed = yaml_text._composed
    monkeypatch.setattr(yaml_text, "_composed", lambda text, *, pure: asked.append(pure) or composed(text, pure=pure))
    assert wrong(ROWS * rows + "- [1, 2").startswith((f"x.yaml:{rows + 1}:", f"x.yaml:{rows + 2}:1: no YAML"))
    assert asked == ([False, True] if rows == 10 else [False])
