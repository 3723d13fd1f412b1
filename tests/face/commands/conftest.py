"""The demo, run once, and an interpretation in doubt: what every command is tried on."""

from __future__ import annotations

import json

import pytest


@pytest.fixture(scope="session")
def demo_run(tmp_path_factory):
    """The finished process of ``plogic demo -o FOLDER``, and the folder; tests only read there."""
    from console import plogic

    folder = tmp_path_factory.mktemp("demo") / "new" / "demo"
    return plogic("demo", "-o", folder), folder


@pytest.fixture(scope="session")
def demo(demo_run):
    """The demo's folder."""
    run, folder = demo_run
    assert run.returncode == 0, run.stderr
    return folder


@pytest.fixture(scope="session")
def gamma(demo):
    """The demo's Γ as a document."""
    return json.loads((demo / "gamma.json").read_text())
