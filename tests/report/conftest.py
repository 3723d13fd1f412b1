"""One browser for all tests of the page, skipped with a reason where there is none."""

from __future__ import annotations

import pytest
from browser import Browser, missing
from towers_document import document


@pytest.fixture(scope="session")
def towers():
    return document()


@pytest.fixture(scope="session")
def chromium(tmp_path_factory):
    if missing():
        pytest.skip(f"not installed: {missing()}")
    browser = Browser(tmp_path_factory.mktemp("profile"))
    yield browser
    browser.close()
