"""Floors and rooms: imports go down, also those inside functions; rooms and files stay small."""

from __future__ import annotations

import ast
from itertools import combinations

import networkx as nx
import pytest
from architecture import FLOORS, PACKAGES, ROOT, drawing, floor_of, imports, modules, room_of, rooms, statements

FEWEST_IMPORTS = 1000
"""Fewer would mean that the files have not been read."""
NAMES_ONLY = frozenset({"kb.errors"})
"""The modules of the KB that ``sensing`` may import: type names come as plain strings, so that no more is ever
needed."""
MOST_ROOMS, MOST_FILES, MOST_LINES = 6, 25, 400


def folders():
    """The folders that hold code or what is installed with it."""
    found = [folder for top in PACKAGES for folder in [ROOT / top, *(ROOT / top).rglob("*")]]
    return [folder for folder in found if folder.is_dir() and folder.name != "__pycache__"]


def place(module, line):
    return f"{modules()[module].relative_to(ROOT)}:{line}"


def test_every_floor_is_there_and_no_other():
    assert {floor_of(room_of(module)) for module in modules()} == set(FLOORS)


def test_imports_go_down():
    assert len(imports()) > FEWEST_IMPORTS
    height = {floor: n for n, floor in enumerate(FLOORS)}
    upward = [
        f"{place(module, line)}: {name}"
        for module, line, name in imports()
        if height[floor_of(name)] > height[floor_of(module)]
    ]
    assert upward == []


def test_no_room_imports_itself_through_others():
    assert [circle for circle in nx.strongly_connected_components(rooms()) if len(circle) > 1] == []


def test_an_import_inside_a_function_counts_and_one_for_the_type_checker_does_not(tmp_path):
    file = tmp_path / "file.py"
    file.write_text("if TYPE_CHECKING:\n    import a\nelse:\n    import b\ndef f():\n    import c\n")
    nodes = [node for node in statements(file) if isinstance(node, ast.Import)]
    assert sorted(node.names[0].name for node in nodes) == ["b", "c"]


def test_no_import_is_relative():
    nodes = [(module, node) for module, path in modules().items() for node in statements(path)]
    assert [place(m, node.lineno) for m, node in nodes if isinstance(node, ast.ImportFrom) and node.level] == []


def test_evidence_is_blind_to_object_types():
    """``sensing`` may know the KB's type names, never its object types (the house's rule)."""
    found = [(module, line, name) for module, line, name in imports() if module.startswith("sensing")]
    assert found
    assert [place(m, line) for m, line, name in found if name.startswith("kb") and name not in NAMES_ONLY] == []


def test_a_floor_has_few_rooms():
    many = {
        floor: inside
        for floor in FLOORS[:-2]
        if len(inside := [room for room in rooms() if floor_of(room) == floor and room != floor]) > MOST_ROOMS
    }
    assert many == {}


def test_a_folder_has_few_files():
    counts = {str(f.relative_to(ROOT)): sum(file.is_file() for file in f.iterdir()) for f in folders()}
    assert len(counts) > len(PACKAGES)
    assert {folder: count for folder, count in counts.items() if count > MOST_FILES} == {}


def test_a_file_is_short():
    files = [*modules().values(), *(ROOT / "benchmarks").rglob("*.py"), *(ROOT / "docs").glob("*.py")]
    lengths = {str(f.relative_to(ROOT)): len(f.read_text(encoding="utf-8").splitlines()) for f in files}
    assert {name: length for name, length in lengths.items() if length > MOST_LINES} == {}


def test_nothing_lies_loose_in_plogic():
    assert [file.name for file in (ROOT / "plogic").iterdir() if file.is_file()] in (
        ["__init__.py"],
        ["__init__.py", "py.typed"],
        ["py.typed", "__init__.py"],
    )


def names_of_rooms():
    """The last part of each room's name, floors and rooms of ``plogic`` and the packages beside it."""
    return [*PACKAGES, *(room.rpartition(".")[2] for room in rooms() if room.startswith("plogic."))]


def alike(a, b):
    """Whether two names are one word, or one is the other with a letter more."""
    short, long = sorted((a, b), key=len)
    return a == b or short in {long[:n] + long[n + 1 :] for n in range(len(long))}


@pytest.mark.parametrize(("a", "b"), [("cycle", "cycle"), ("programs", "program"), ("gate", "grate")])
def test_names_that_are_alike(a, b):
    assert alike(a, b)
    assert not alike(a, "scene")


def test_no_two_rooms_are_named_alike():
    assert [pair for pair in combinations(names_of_rooms(), 2) if alike(*pair)] == []


def test_the_drawing_shows_every_room_and_every_import_that_follows_from_no_others():
    text = drawing()
    drawn = nx.transitive_reduction(rooms())
    assert [room for room in rooms() if f">{room.rpartition('.')[2]}</text>" not in text] == []
    assert [edge for edge in drawn.edges if f"{edge[0]} imports {edge[1]}<" not in text] == []
