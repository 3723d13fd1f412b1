"""``plogic completion`` and ``plogic man``: made of the commands, and read by the programs that they are for."""

from __future__ import annotations

import os
import re
import shutil
import subprocess

import pytest
from console import BIN, good
from in_process import told

from cli import cli


@pytest.mark.parametrize("shell", ["bash", "zsh", "fish"])
def test_each_shell_gets_a_script_that_says_where_it_belongs(shell):
    text = "\n".join(told("completion", shell))
    assert f"plogic completion {shell} > " in text
    assert "_PLOGIC_COMPLETE" in text
    assert text.startswith("#compdef plogic" if shell == "zsh" else "# plogic completion")


def test_bash_takes_the_script_and_completes_commands():
    script = "\n".join(told("completion", "bash"))
    ask = 'COMP_WORDS=(plogic kb le); COMP_CWORD=2; _plogic_completion plogic; echo "${COMPREPLY[@]}"'
    done = subprocess.run(
        ["bash", "-c", f"{script}\n{ask}"],
        capture_output=True,
        text=True,
        check=True,
        env={"PATH": f"{BIN}:/usr/bin:/bin"},
    )
    assert done.stdout.split() == ["learn", "learn-rates"]


@pytest.mark.parametrize(
    "words",
    [
        "perceive i",
        "query i",
        "worlds i",
        "explain i",
        "report i",
        "batch i",
        "watch i",
        "settle i",
        "bop d",
        "program i",
        "kb check k",
        "kb show k",
        "perceive i.png --kb k",
        "query i.json --rules r",
    ],
)
def test_names_of_files_are_completed(words):
    asked = {"_PLOGIC_COMPLETE": "bash_complete", "COMP_WORDS": f"plogic {words}"}
    asked |= {"COMP_CWORD": str(len(words.split()))}
    done = subprocess.run(
        [str(BIN / "plogic")], capture_output=True, text=True, check=True, env={**os.environ, **asked}
    )
    assert done.stdout.startswith("file,")


def test_another_shell_is_bad_usage():
    assert "is not one of 'bash', 'zsh', 'fish'" in told("completion", "tcsh")[-1]


def test_the_manual_has_every_command_and_option():
    text = good("man")
    assert text.startswith(".TH PLOGIC 1")
    for name in cli.commands:
        assert f".SS plogic {name}".replace("-", "\\-") in text
    assert ".B \\-\\-digits" in text


@pytest.mark.skipif(shutil.which("groff") is None, reason="no groff")
def test_groff_finds_no_fault_in_the_manual():
    done = subprocess.run(
        ["groff", "-k", "-man", "-Tutf8", "-ww"], input=good("man").encode(), capture_output=True, check=True
    )
    assert [line for line in done.stderr.decode().splitlines() if "adjust line" not in line] == []
    assert "plogic explain" in re.sub("\x1b\\[[0-9;]*m|.\b", "", done.stdout.decode())
