"""Types that show too little to be accepted, however well they are detected."""

from dataclasses import replace

import pytest

from kb.files.folder import shipped
from kb.files.read import read_kb
from plogic.run.silence.too_few import VIEWS, seldom_found

FIRST = read_kb(shipped("first"))


def with_features(*names):
    """The box with these of its features alone."""
    (kind,) = FIRST.types
    kept = tuple(feature for feature in kind.features if feature.name in names)
    return replace(FIRST, types=(replace(kind, features=kept, all_features=kept),))


@pytest.mark.parametrize("name", ["first", "paper", "towers"])
def test_of_shipped_types_nothing_is_said(name):
    assert list(seldom_found(read_kb(shipped(name)))) == []


def test_a_box_with_stickers_on_one_side_alone_is_seldom_found_and_why_is_told():
    names = [feature.name for feature in FIRST.types[0].features if feature.type == "sticker"]
    (line,) = seldom_found(with_features(*names))
    assert line.startswith(f"box: from {VIEWS} of {VIEWS} directions all around it would not be accepted")
    assert "4 are demanded" in line


def test_one_of_which_something_worse_is_known_is_not_asked():
    assert list(seldom_found(with_features(), {"box"})) == []
    assert list(seldom_found(with_features())) == []
