"""What takes more memory than there is ends in one line, wherever it runs out."""

from __future__ import annotations

import json
import os
import resource
import subprocess
from pathlib import Path

import pytest
from console import BIN, SECONDS, good

EXAMPLES = Path(__file__).parents[3] / "examples"


def said(megabytes):
    what = "out of memory: the input, or the knowledge base, takes more than"
    return f"plogic: {what} the {megabytes} MB that a command may (PLOGIC_MEMORY, ulimit)\n"


def within(megabytes, *args, how="address space"):
    """The finished process that had so much address space, or memory."""

    def limit():
        if how == "address space":
            resource.setrlimit(resource.RLIMIT_AS, (megabytes << 20, megabytes << 20))

    command = [str(BIN / "plogic"), *map(str, args)]
    environment = os.environ | {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}
    environment |= {"PLOGIC_MEMORY": str(megabytes)} if how == "memory" else {}
    return subprocess.run(
        command, capture_output=True, text=True, timeout=SECONDS, check=False, preexec_fn=limit, env=environment
    )


@pytest.fixture(scope="module")
def large(tmp_path_factory):
    """An interpretation with a long trace, and a Γ of as many appearances as one may have."""
    folder = tmp_path_factory.mktemp("large")
    small = json.loads(good("perceive", EXAMPLES / "first_gamma.json", "--kb", "first"))
    (folder / "interpretation.json").write_text(json.dumps(small | {"trace": small["trace"] * 30_000}))
    camera = {"width": 640, "height": 480, "K": [[600, 0, 320], [0, 600, 240], [0, 0, 1]], "dist": []}
    rows = [
        {"id": f"a{i}", "type": "l_junction", "uv": [i % 640, i // 640], "detector": "junction", "angle": 0.1}
        for i in range(20_000)
    ]
    (folder / "gamma.json").write_text(json.dumps({"format": "gamma/1", "camera": camera, "appearances": rows}))
    return folder


@pytest.mark.parametrize("megabytes", [150, 200])
@pytest.mark.parametrize("args", [["worlds"], ["query", "present(h1)"]], ids=lambda args: args[0])
@pytest.mark.parametrize("how", ["address space", "memory"])
def test_of_an_interpretation(large, args, megabytes, how):
    command, *goal = args
    run = within(megabytes, command, large / "interpretation.json", *goal, how=how)
    assert (run.returncode, run.stdout, run.stderr) == (1, "", said(megabytes))


@pytest.mark.parametrize(
    ("value", "status"), [("x", 1), ("-1", 1), ("8 GB", 1), ("9" * 40, 1), ("8192", 0), ("0", 0), ("", 0)]
)
def test_the_limit_is_a_number_of_megabytes(value, status):
    command = [str(BIN / "plogic"), "query", str(EXAMPLES / "alarm.pl")]
    environment = os.environ | {"PLOGIC_MEMORY": value}
    run = subprocess.run(command, capture_output=True, text=True, timeout=SECONDS, check=False, env=environment)
    assert run.returncode == status
    line = f"plogic: PLOGIC_MEMORY={value[:40]!r} should be a number of MB, as 8192, or 0 for no limit\n"
    assert run.stderr == (line if status else "")


@pytest.mark.parametrize(
    ("how", "megabytes"),
    [("address space", each) for each in (150, 300, 460, 480, 500, 530, 600, 650)]
    + [("memory", each) for each in (40, 130, 190)],
)
def test_of_a_gamma(large, how, megabytes):
    """At each of these a library ended the process, with words of its own or none, or looked for memory for ever."""
    run = within(megabytes, "perceive", large / "gamma.json", "--kb", "towers", "--deadline", 1, how=how)
    assert (run.returncode, run.stdout, run.stderr) == (1, "", said(megabytes))


def test_what_is_enough_is_not_refused():
    """500 were enough before room was asked for, and 460 were not."""
    run = within(600, "perceive", EXAMPLES / "first_gamma.json", "--kb", "first", how="memory")
    assert run.returncode == 0, run.stderr


@pytest.mark.parametrize("megabytes", [100, 130, 220, 250])
def test_of_a_simulation(tmp_path, megabytes):
    """At these numpy and pybullet ended the process, or a mesh was called unreadable."""
    run = within(megabytes, "simulate", "--kb", "first", "-o", tmp_path / "scene", how="memory")
    assert (run.returncode, run.stdout, run.stderr) == (1, "", said(megabytes))
    assert not list(tmp_path.iterdir())
