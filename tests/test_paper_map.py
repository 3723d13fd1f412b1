"""The documents name real things.

Docs/paper-map.md (every item, its modules and its tests), docs/glossary.md, docs/how-it-works.md.
"""

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent
MAP = (ROOT / "docs" / "paper-map.md").read_text(encoding="utf-8")
PAGES = ["paper-map.md", "glossary.md", "how-it-works.md", "conventions.md"]
ROWS = {
    cells[0]: cells
    for line in MAP.splitlines()
    if (cells := [c.strip() for c in line.strip("|").split("|")])[0].startswith("§")
}
COUNTS = {2: 8, 3: 8, 4: 4, 5: 7, 6: 3}
ITEMS = [
    *(f"§1 {name}" for name in ("Σ", "Γ", "Δh", "Δi", "Δp")),
    *(f"§{section}.{number}" for section, most in COUNTS.items() for number in range(1, most + 1)),
    "§7",
    *(f"§8 {name}" for name in ("program", "worlds", "explanations", "duplicates", "score", "posterior")),
    *(f"§8 trap ({letter})" for letter in "abcdefg"),
    "§9.8",
]
FILE = re.compile(r"`((?:[\w.]+/)+\w+\.py)(?:::(\w+))?`")


def test_no_item_is_missing_and_none_is_invented():
    assert list(ROWS) == ITEMS


@pytest.mark.parametrize("item", ITEMS)
def test_an_item_has_modules_and_tests_or_says_later(item):
    _, what, modules, tests, note = ROWS[item]
    assert what
    if FILE.search(modules):
        assert FILE.search(tests), f"{item} has modules and no test"
    else:
        assert "*later*" in note
        assert not tests


@pytest.mark.parametrize("item", ITEMS)
def test_modules_are_code_and_tests_are_tests(item):
    _, _, modules, tests, _ = ROWS[item]
    assert not [path for path, _ in FILE.findall(modules) if path.startswith("tests/")]
    assert not [path for path, _ in FILE.findall(tests) if not path.startswith("tests/")]


@pytest.mark.parametrize("page", PAGES)
def test_every_file_and_every_test_that_is_named_exists(page):
    named = FILE.findall((ROOT / "docs" / page).read_text(encoding="utf-8"))
    assert named
    missing = [path for path, _ in named if not (ROOT / path).is_file()]
    assert not missing
    absent = [
        f"{path}::{test}"
        for path, test in named
        if test and f"\ndef {test}(" not in (ROOT / path).read_text(encoding="utf-8")
    ]
    assert not absent
