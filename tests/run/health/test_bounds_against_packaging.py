"""Versions, bounds and conditions of requirements are read as the package ``packaging`` reads them."""

from importlib.metadata import distribution, distributions

import pytest
from packaging.markers import Marker
from packaging.requirements import Requirement
from packaging.specifiers import SpecifierSet

from plogic.run.health.installation import admits, holds, requirements

VERSIONS = [
    "4.10.1",
    "1",
    "2.17.7",
    "2.17.7.post2",
    "1.9.post1",
    "1.0",
    "1.0.1",
    "1.10",
    "1.9",
    "2.0rc1",
    "2.0.dev3",
    "2.0",
    "2.0.post1",
    "2026.8.0",
    "2.17.7.post1",
]
BOUNDS = ["", ">=1", ">=1.0,<2", "<6,>=4.10", "==1.0", "!=1.0", ">1.9", "<=1.10", ">=2.17.7.post1", ">=2024.1"]
MARKERS = [
    "python_version == '3.11' and platform_machine == 'x86_64' and sys_platform == 'linux'",
    "python_version in '3.12 3.13'",
    'python_version < "3.9" or sys_platform != "win32"',
    "python_version >= '3.10'",
    'os_name not in "nt java" and (python_version < "3.100")',
    "extra == 'bench'",
    "platform_python_implementation == 'CPython'",
]


@pytest.mark.parametrize("bounds", BOUNDS)
def test_bounds(bounds):
    wanted = {version: SpecifierSet(bounds).contains(version, prereleases=True) for version in VERSIONS}
    assert bounds in ("", ">=1") or set(wanted.values()) == {True, False}
    assert {version: admits(bounds, version) for version in VERSIONS} == wanted


@pytest.mark.parametrize("marker", MARKERS)
def test_conditions(marker):
    assert holds(marker, "bench") == Marker(marker).evaluate({"extra": "bench"})


def test_the_requirements_of_all_that_is_installed():
    """Of those without extras: the same names hold here."""
    installed = {one.metadata["Name"]: one for one in distributions() if one.requires}
    assert len(installed) > 10
    wanted = {name: _named(one) for name, one in installed.items()}
    assert {name: [r.name for r in requirements(one) if not r.extra] for name, one in installed.items()} == wanted
    assert len([one for one in requirements(distribution("plogic")) if not one.extra]) >= 17


def _named(one):
    read = map(Requirement, one.requires)
    return [r.name for r in read if "extra" not in str(r.marker) and (r.marker is None or r.marker.evaluate())]
