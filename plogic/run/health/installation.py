"""Python, plogic and each package that it needs, against the versions that it admits.

Nothing but the standard library is imported here, for any other package may be missing.
"""

import ast
import operator
import os
import platform
import re
import sys
from collections.abc import Callable, Iterator
from importlib.metadata import Distribution, PackageNotFoundError, distribution
from importlib.util import find_spec
from typing import Any, NamedTuple

from plogic.base.hidden import COMMAND, PACKAGES, hidden
from plogic.run.health.findings import Finding, State

AREA = "installation"
MODULES = {
    "opencv-python-headless": "cv2",
    "pybullet-arm64": "pybullet",
    "pytest-xdist": "xdist",
    "ruamel-yaml": "ruamel.yaml",
    "ruamel-yaml-clib": "_ruamel_yaml",
}
"""The modules of packages that are called otherwise."""
_REQUIREMENT = re.compile(r"\s*([\w.-]+)\s*(?:\[[^]]*\])?\s*\(?([^;()]*)\)?\s*(?:;(.*))?")
_BOUND = re.compile(r"\s*(>=|<=|==|!=|>|<)\s*([\w.!+]+)\s*")
_COMPARED: dict[str, Callable[[Any, Any], bool]] = {
    ">=": operator.ge,
    "<=": operator.le,
    "==": operator.eq,
    "!=": operator.ne,
    ">": operator.gt,
    "<": operator.lt,
}
_SIGNS: dict[type[ast.cmpop], str] = {
    ast.GtE: ">=",
    ast.LtE: "<=",
    ast.Eq: "==",
    ast.NotEq: "!=",
    ast.Gt: ">",
    ast.Lt: "<",
}


class Requirement(NamedTuple):
    """A package with the ``bounds`` of its version, ``>=4.10,<6``; ``extra``: for what it may be installed, else ''."""

    name: str
    bounds: str
    extra: str


def installation() -> Iterator[Finding]:
    """Python, plogic, and each package that this machine needs; those of extras where their version is not admitted."""
    try:
        own = distribution("plogic")
    except PackageNotFoundError:
        yield Finding(AREA, "plogic", "wrong", "has no metadata: it is not installed", "pip install plogic")
        return
    yield _python(own)
    told = hidden((*PACKAGES, COMMAND))
    yield Finding(AREA, "plogic", "wrong" if told else "fine", told or own.version)
    for one in requirements(own):
        found = _package(one)
        if not one.extra or found.state != "fine":
            yield found


def _python(own: Distribution) -> Finding:
    version, bounds = platform.python_version(), str(own.metadata["Requires-Python"] or "")
    if platform.python_implementation() != "CPython" or not admits(bounds, version):
        told = f"{platform.python_implementation()} {version}, and not CPython {bounds}"
        return Finding(AREA, "Python", "wrong", told, "make an environment with another: python3.13 -m venv")
    return Finding(AREA, "Python", "fine", version)


def _package(one: Requirement) -> Finding:
    wanted = f'pip install "{one.name}{one.bounds}"'
    wrong: State = "note" if one.extra else "wrong"
    try:
        version = distribution(one.name).version
    except PackageNotFoundError:
        if one.extra:
            return Finding(AREA, one.name, "fine", f"is not installed, and needed for plogic[{one.extra}] alone")
        return Finding(AREA, one.name, "wrong", "is not installed", wanted)
    except Exception as error:  # noqa: BLE001 - metadata can be damaged in any way
        return Finding(
            AREA, one.name, wrong, f"has metadata that cannot be read: {error}", f"{wanted} --force-reinstall"
        )
    if not isinstance(version, str) or not admits(one.bounds, version):
        return Finding(AREA, one.name, wrong, f"{version} is installed, and not {one.bounds}", wanted)
    if not _is_there(one.name):
        told = f"{version} is installed, but its module is not there"
        return Finding(AREA, one.name, wrong, told, f"{wanted} --force-reinstall")
    return Finding(AREA, one.name, "fine", version)


def _is_there(name: str) -> bool:
    """Whether there is the module of a package."""
    name = re.sub(r"[-_.]+", "-", name).lower()
    try:
        return find_spec(MODULES.get(name, name.replace("-", "_"))) is not None
    except (ImportError, ValueError):
        return False


def requirements(own: Distribution) -> list[Requirement]:
    """What the metadata of a package names for this machine, in its order."""
    found = []
    for text in own.requires or []:
        match = _REQUIREMENT.fullmatch(text)
        marker = (match[3] or "").strip() if match else ""
        extra = re.search(r"extra\s*==\s*['\"]([\w.-]+)['\"]", marker)
        if match and (not marker or holds(marker, extra[1] if extra else "")):
            found.append(Requirement(match[1], match[2].replace(" ", ""), extra[1] if extra else ""))
    return found


def admits(bounds: str, version: str) -> bool:
    """Whether bounds, ``>=4.10,<6``, admit a version; a bound of another form is taken to."""
    found = [match for bound in bounds.split(",") if (match := _BOUND.fullmatch(bound))]
    return all(_admits(match[1], _ordered(version), _ordered(match[2])) for match in found)


def _admits(sign: str, version: tuple[tuple[int, ...], int], bound: tuple[tuple[int, ...], int]) -> bool:
    """Trials of a version, and what was published after it, are neither below it nor above it."""
    if sign in "<>" and version[0] == bound[0] and not bound[1]:
        return False
    return _COMPARED[sign](version, bound)


def _ordered(version: str) -> tuple[tuple[int, ...], int]:
    """What orders versions: the numbers, and -1 for a trial of them (``4.0rc1``), 2 for ``4.0.post2``, else 0."""
    match = re.match(r"v?(?:\d+!)?(\d+(?:\.\d+)*)(.*)", version)
    numbers = [int(number) for number in match[1].split(".")] if match else []
    while numbers and not numbers[-1]:
        numbers.pop()
    rest = match[2] if match else ""
    later = re.match(r"[._-]?post(\d+)", rest)
    return tuple(numbers), int(later[1]) if later else -1 if re.match(r"[._-]?(a|b|c|rc|dev|pre)", rest) else 0


def holds(marker: str, extra: str = "") -> bool:
    """Whether a condition of a requirement, ``python_version < "3.12" and sys_platform == "linux"``, holds here."""
    here = {
        "python_version": ".".join(platform.python_version_tuple()[:2]),
        "python_full_version": platform.python_version(),
        "platform_machine": platform.machine(),
        "platform_system": platform.system(),
        "platform_python_implementation": platform.python_implementation(),
        "implementation_name": sys.implementation.name,
        "sys_platform": sys.platform,
        "os_name": os.name,
        "extra": extra,
    }
    return _holds(ast.parse(marker, mode="eval").body, here)


def _holds(node: ast.expr, here: dict[str, str]) -> bool:
    if isinstance(node, ast.BoolOp):
        each = [_holds(value, here) for value in node.values]
        return all(each) if isinstance(node.op, ast.And) else any(each)
    if not isinstance(node, ast.Compare):
        return False
    names = [
        here.get(side.id, "") if isinstance(side, ast.Name) else _text(side) for side in (node.left, *node.comparators)
    ]
    if isinstance(node.ops[0], ast.In | ast.NotIn):
        return (names[0] in names[1]) == isinstance(node.ops[0], ast.In)
    is_version = all(re.match(r"\d", name) for name in names)
    one, other = map(_ordered, names) if is_version else names
    return _COMPARED[_SIGNS[type(node.ops[0])]](one, other)


def _text(node: ast.expr) -> str:
    return node.value if isinstance(node, ast.Constant) and isinstance(node.value, str) else ""
