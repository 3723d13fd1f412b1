"""The documents name real things.

Docs/paper-map.md (every item: its definition, the command that shows it, its modules and its tests), docs/glossary.md,
docs/how-it-works.md.
"""

import re
from pathlib import Path

import pytest
from click.testing import CliRunner

from cli import cli
from kb.files.schema import PartModel
from plogic.facts.vocabulary import VOCABULARY

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
    "§9.5",
    "§9.7",
    "§9.8",
    "§9.9",
    "§9.10",
]
NOT_BUILT = {
    "§9.1": {"unknown_occluder", "hides", "missed"},
    "§9.2": set(),
    "§9.3": {"matched"},
    "§9.4": set(),
    "§9.6": set(),
}
"""Items of §9 that docs/limits.md tells of, with the predicates that they would bring."""
FILE = re.compile(r"`((?:[\w.]+/)+\w+\.py)(?:::(\w+))?`")


def test_no_item_is_missing_and_none_is_invented():
    assert list(ROWS) == ITEMS


def test_what_of_abduction_is_not_built_is_a_limit_that_still_holds():
    """Every item of §9 is either in the map or among the limits; what a limit says is not there, is not there."""
    limits = (ROOT / "docs" / "limits.md").read_text(encoding="utf-8")
    assert {f"§9.{n}" for n in range(1, 11)} == {*NOT_BUILT, *(item for item in ITEMS if item.startswith("§9."))}
    assert set(NOT_BUILT) == set(re.findall(r"^  \| (§9\.\d+),", limits, re.MULTILINE))
    assert {entry.name for entry in VOCABULARY}.isdisjoint(set().union(*NOT_BUILT.values()))
    assert not {"is", "is_a", "joint"} & set(PartModel.model_fields)


@pytest.mark.parametrize("item", ITEMS)
def test_an_item_has_modules_and_tests_or_says_later(item):
    _, what, _, _, modules, tests, note = ROWS[item]
    assert what
    if FILE.search(modules):
        assert FILE.search(tests), f"{item} has modules and no test"
    else:
        assert "*later*" in note
        assert not tests


@pytest.mark.parametrize("item", ITEMS)
def test_modules_are_code_and_tests_are_tests(item):
    _, _, definition, _, modules, tests, _ = ROWS[item]
    assert not [path for path, _ in FILE.findall(definition + modules) if path.startswith("tests/")]
    assert not [path for path, _ in FILE.findall(tests) if not path.startswith("tests/")]


@pytest.mark.parametrize("item", ITEMS)
def test_an_item_is_stated_by_one_function_class_or_table(item):
    (named,) = FILE.findall(ROWS[item][2])
    path, name = named
    code = (ROOT / path).read_text(encoding="utf-8")
    assert re.search(rf"^(?:def|class) {name}\b|^{name}\b[^\n]* = ", code, re.MULTILINE), f"{path} states no {name}"


@pytest.mark.parametrize("command", sorted({cells[3] for cells in ROWS.values()}))
def test_the_command_that_shows_an_item_has_help_and_its_option(command):
    first, *words = command.strip("`").split()
    assert first == "plogic"
    helped = CliRunner().invoke(cli, [*(word for word in words if not word.startswith("--")), "--help"])
    assert helped.exit_code == 0
    assert all(f"{word} " in helped.stdout or f"{word}\n" in helped.stdout for word in words if word.startswith("--"))


@pytest.mark.parametrize("page", PAGES)
def test_every_file_and_every_test_that_is_named_exists(page):
    named = FILE.findall((ROOT / "docs" / page).read_text(encoding="utf-8"))
    assert named
    missing = [path for path, _ in named if not (ROOT / path).is_file()]
    assert not missing
    absent = [
        f"{path}::{test}"
        for path, test in named
        if path.startswith("tests/") and test and f"\ndef {test}(" not in (ROOT / path).read_text(encoding="utf-8")
    ]
    assert not absent
