"""One browser for all tests of a folder, and one without WebGL; both skipped with a reason where there is none."""

from __future__ import annotations

import pytest
from browser import Browser, missing


def _started(folder, *flags):
    if missing():
        pytest.skip(f"not installed: {missing()}")
    browser = Browser(folder, *flags)
    yield browser
    browser.close()


@pytest.fixture(scope="session")
def chromium(tmp_path_factory):
    yield from _started(tmp_path_factory.mktemp("profile"))


@pytest.fixture(scope="session")
def flat_chromium(tmp_path_factory):
    yield from _started(tmp_path_factory.mktemp("flat"), "--disable-3d-apis")
