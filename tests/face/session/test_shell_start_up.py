"""The shell costs nothing where it is not used, and no terminal library where there is no terminal."""

from __future__ import annotations

import re
import subprocess
import sys

import pytest
from console import BIN, good


def imported(*args, stdin=""):
    command = [sys.executable, "-X", "importtime", str(BIN / "plogic"), *map(str, args)]
    run = subprocess.run(command, input=stdin, capture_output=True, text=True, check=False, timeout=60)
    assert run.returncode == 0, run.stderr[-500:]
    return {name.split(".")[0] for name in re.findall(r"^import time:.*\| +(\S+)$", run.stderr, re.MULTILINE)}


@pytest.mark.parametrize("args", [("--help",), ("shell", "--help")], ids=" ".join)
def test_help_imports_no_terminal_library(args):
    assert not imported(*args) & {"prompt_toolkit", "rich", "problog", "numpy"}


def test_lines_from_a_file_import_no_terminal_library(rain):
    found = imported("shell", rain, stdin="rain\n")
    assert "plogic" in found
    assert not found & {"prompt_toolkit", "problog"}


def test_the_command_is_in_the_help():
    assert re.search(r"^  shell +Ask, observe", good("--help"), re.MULTILINE)
    text = good("shell", "--help")
    assert "--reading" in text
    assert "--trust" in text
