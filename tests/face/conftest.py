"""One document of the towers, and one browser for all tests of pages."""

from __future__ import annotations

import pytest
from one_browser import chromium, flat_chromium
from towers_document import document

__all__ = ["chromium", "flat_chromium", "towers"]


@pytest.fixture(scope="session")
def towers():
    return document()
