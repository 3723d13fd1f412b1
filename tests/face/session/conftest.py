"""Sessions for the tests: a program about wet grass, the two towers, and the console script."""

from __future__ import annotations

import pytest

RAIN = """0.3::rain.
0.5::sprinkler(front); 0.2::sprinkler('Back yard').
wet(G) :- sprinkler(G).
wet(G) :- garden(G), rain.
garden(front). garden('Back yard').
query(wet(_)).
"""


@pytest.fixture
def rain(tmp_path):
    """The file of a program."""
    (tmp_path / "rain.pl").write_text(RAIN)
    return tmp_path / "rain.pl"


@pytest.fixture(scope="session")
def towers_file(tmp_path_factory):
    """The interpretation of the worked example of §8 as a file."""
    from scene_file import towers_document

    from plogic.facts.interpretation import text_of

    path = tmp_path_factory.mktemp("towers") / "interpretation.json"
    path.write_text(text_of(towers_document()))
    return path
