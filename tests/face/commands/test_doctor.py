"""``plogic doctor`` through the console script: what is broken is said in plain words, and repaired."""

from __future__ import annotations

import json
import os
from importlib.metadata import distribution
from pathlib import Path

import pytest
from console import plogic
from jsonschema import Draft202012Validator
from small_kb import write_small

from geometry.files.begun import file_beside, folder_beside, scratch
from kb.files.changes import CHANGE, writing
from plogic.face.commands.formats import schema_command
from plogic.run.health import remains
from plogic.run.health.installation import requirements

ROOT = Path(__file__).parents[3]


@pytest.fixture
def here(tmp_path):
    """Empty folders for caches and scratch files, as variables."""
    for name in ("cache", "scratch"):
        (tmp_path / name).mkdir()
    return {"XDG_CACHE_HOME": str(tmp_path / "cache"), "TMPDIR": str(tmp_path / "scratch")}


def found(*args, status, **env):
    """The findings by area and name, of a run that ends with ``status``, without a word on stderr."""
    done = plogic("doctor", "--json", *args, **env)
    assert (done.returncode, done.stderr) == (status, "")
    told = json.loads(done.stdout)
    assert list(Draft202012Validator(json.loads(schema_command("doctor"))).iter_errors(told)) == []
    assert told["healthy"] == (status == 0)
    return {(row["area"], row["name"]): row for row in told["findings"]}


def with_path(folder, **env):
    return env | {"PYTHONPATH": os.pathsep.join([str(folder), str(ROOT)])}


def metadata(folder, name, version, *lines):
    """Metadata of a package that claims to be installed."""
    place = folder / f"{name}-{version}.dist-info"
    place.mkdir(parents=True)
    (place / "METADATA").write_text(
        "\n".join(["Metadata-Version: 2.1", f"Name: {name}", f"Version: {version}", *lines, ""])
    )


def test_a_whole_installation_is_healthy(here):
    rows = found(status=0, **here)
    named = {name for area, name in rows if area == "installation"}
    assert {"Python", "plogic", *(one.name for one in requirements(distribution("plogic")) if not one.extra)} <= named
    assert {row["state"] for row in rows.values()} <= {"fine", "note"}
    done = plogic("doctor", **here)
    assert (done.returncode, done.stdout.splitlines()[-1]) == (0, "healthy")


def test_a_package_that_is_too_old_is_named_with_what_to_do(tmp_path, here):
    metadata(tmp_path / "fake", "trimesh", "4.0.1")
    row = found(status=1, **with_path(tmp_path / "fake", **here))["installation", "trimesh"]
    assert row["told"].startswith("4.0.1 is installed, and not >=4.")
    assert row["remedy"].startswith('pip install "trimesh>=4.')


def test_a_package_that_is_not_there_and_a_python_that_is_not_admitted(tmp_path, here):
    lines = "Requires-Python: >=3.99", "Requires-Dist: no-such-package>=3", "Requires-Dist: another; extra == 'bench'"
    metadata(tmp_path / "fake", "plogic", "0.9", *lines)
    (tmp_path / "fake/numpy-9.dist-info").mkdir()
    rows = found(status=1, **with_path(tmp_path / "fake", **here))
    missing = rows["installation", "no-such-package"]
    assert (missing["told"], missing["remedy"]) == ("is not installed", 'pip install "no-such-package>=3"')
    assert rows["installation", "Python"]["told"].endswith(", and not CPython >=3.99")
    assert ("installation", "another") not in rows


def test_metadata_without_a_version(tmp_path, here):
    (tmp_path / "fake/numpy-9.dist-info").mkdir(parents=True)
    row = found(status=1, **with_path(tmp_path / "fake", **here))["installation", "numpy"]
    assert row["state"] == "wrong"
    assert row["remedy"].startswith('pip install "numpy>=')


@pytest.mark.parametrize("name", ["numpy", "click"])
def test_a_package_that_cannot_be_imported_leaves_the_doctor_at_work(tmp_path, here, name):
    (tmp_path / "fake" / name).mkdir(parents=True)
    (tmp_path / "fake" / name / "__init__.py").write_text("raise ImportError('torn in two')")
    broken = with_path(tmp_path / "fake", **here)
    done = plogic("doctor", "--kb", "towers", **broken)
    assert (done.returncode, done.stderr) == (1 if name == "numpy" else 0, "")
    assert done.stdout.splitlines()[0] == "installation"
    if name == "numpy":
        assert (
            "caches\n  WRONG     look: cannot be looked at: ImportError: torn in two; mend the installation"
            in done.stdout
        )
        assert "limits\n" in done.stdout
    else:
        done = plogic("worlds", "x.json", **broken)
        line = "plogic: the installation is not whole: torn in two; plogic doctor tells more\n"
        assert (done.returncode, done.stdout, done.stderr) == (1, "", line)


def flip(file):
    content = bytearray(file.read_bytes())
    content[-1] ^= 1
    file.write_bytes(content)


SPOILT = {
    "a byte": lambda place: flip(place / "vertices.npy"),
    "an end": lambda place: os.truncate(place / "triangles.npy", 100),
    "a file gone": lambda place: (place / "triangles.npy").unlink(),
    "no manifest": lambda place: (place / "manifest.json").unlink(),
    "another manifest": lambda place: (place / "manifest.json").write_text("[1]"),
    "a manifest of nonsense": lambda place: (place / "manifest.json").write_text('{"key": 3, "arrays": {"a": []}}'),
    "renamed": lambda place: place.rename(place.with_name("f" * 64)),
}


@pytest.mark.parametrize("how", SPOILT)
def test_a_spoilt_cache_is_found_and_repaired(tmp_path, here, how):
    assert found("--kb", "towers", status=0, **here)["caches", "numba"]["state"] == "fine"
    place = next((tmp_path / "cache/plogic/surfaces").iterdir())
    SPOILT[how](place)
    row = found(status=1, **here)["caches", "surfaces"]
    assert row["told"].startswith("1 damaged of 2 entries, ")
    assert row["remedy"] == "plogic doctor --fix"
    assert found("--fix", status=0, **here)["caches", "surfaces"]["state"] == "repaired"
    assert found(status=0, **here)["caches", "surfaces"]["told"].startswith("1 entry, ")


def test_a_torn_cloud_and_what_was_begun_and_left(tmp_path, here):
    folder = tmp_path / "cache/plogic/clouds"
    folder.mkdir(parents=True)
    (folder / f"{'a' * 64}.npz").write_bytes(b"PK\3\4 torn")
    (folder / "of somebody else").write_bytes(b"")
    with folder_beside(folder / "place") as used:
        (folder / ".some.plogic-begun-abcdefgh").mkdir()
        (folder / ".other.plogic-begun-abcdefgh").write_bytes(b"")
        done = plogic("doctor", **here)
        assert "WRONG     clouds: 1 damaged of 1 entry, 9 bytes" in done.stdout
        assert "note      clouds: 2 entries begun in" in done.stdout
        assert done.stdout.splitlines()[-2:] == ["1 wrong", "plogic doctor --fix repairs 2 of what was found"]
        assert "healthy" in plogic("doctor", "--fix", **here).stdout
        assert sorted(path.name for path in folder.iterdir()) == [used.name, "of somebody else"]


@pytest.mark.parametrize(("content", "state"), [(b"", "wrong"), (b"\x80\x04\x95", "wrong"), (b"N.K\x01.", "fine")])
def test_compiled_loops_that_are_torn(tmp_path, monkeypatch, content, state):
    """Otherwise numba raises EOFError, and the command ends in an internal error."""
    monkeypatch.setattr(remains, "ROOT", tmp_path)
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    place = tmp_path / "sensing/views/__pycache__"
    place.mkdir(parents=True)
    (place / "loops.score-147.py311.nbi").write_bytes(content)
    assert [one.state for one in remains.caches(fix=False) if one.name == "numba"] == [state]
    assert [one.state for one in remains.caches(fix=True) if one.name == "numba"] == [
        state.replace("wrong", "repaired")
    ]
    assert [one.state for one in remains.caches(fix=False) if one.name == "numba"] == ["fine"]


def test_scratch_of_killed_processes_is_told_and_swept(tmp_path, here, monkeypatch):
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path / "scratch"))
    (tmp_path / "scratch/plogic-mine").mkdir()
    with scratch() as used:
        (tmp_path / "scratch/.scratch.plogic-begun-abcdefgh").mkdir()
        row = found(status=0, **here)["scratch", "folders"]
        assert (row["state"], row["told"][:40]) == ("note", "1 folder left by processes that were kil")
        assert found("--fix", status=0, **here)["scratch", "folders"]["state"] == "repaired"
        assert {path.name for path in (tmp_path / "scratch").iterdir()} == {used.name, "plogic-mine"}


def test_a_broken_knowledge_base_tells_its_mistakes(tmp_path, here):
    write_small(tmp_path / "kb", kb="name: 3\nzork: 1\n")
    done = plogic("doctor", "--kb", tmp_path / "kb", "--kb", "zork", "--kb", "first", **here)
    assert (done.returncode, done.stderr) == (1, "")
    assert done.stdout.count("WRONG     mistake: kb.yaml:") == 3
    assert "WRONG     mistake: no knowledge base 'zork' comes with plogic" in done.stdout
    assert "knowledge base first\n  ok        unfinished writes: none\n  ok        files: loads: 1 type" in done.stdout


def test_what_a_killed_writer_left_in_a_knowledge_base(tmp_path, here):
    kb = write_small(tmp_path / "kb")
    left = [
        tmp_path / ".kb.plogic-begun-abcdefgh",
        kb / ".kb.yaml.plogic-begun-abcdefg1",
        kb / "objects/.mug.plogic-begun-abcdefgh",
        kb / "objects/tent/.cloud.npz.plogic-begun-abc_efgh",
    ]
    others = kb / ".git", tmp_path / ".kb2.plogic-begun-abcdefgh", kb / ".notes.txt"
    for path in (*left, *others):
        path.mkdir()
    area = f"knowledge base {kb}", "unfinished writes"
    assert found("--kb", kb, status=1, **here)[area]["told"].startswith("4 files of a writer that was killed: ")
    assert found("--kb", kb, "--fix", status=0, **here)[area]["state"] == "repaired"
    assert (any(path.exists() for path in left), all(path.exists() for path in others)) == (False, True)
    with file_beside(kb / "kb.yaml", b"written now") as begun:
        assert found("--kb", kb, "--fix", status=0, **here)[area]["state"] == "fine"
        assert begun.read_bytes() == b"written now"


def test_who_is_changing_a_knowledge_base_and_a_change_that_was_cut_short(tmp_path, here):
    kb = write_small(tmp_path / "kb")
    area = f"knowledge base {kb}"
    with writing(kb):
        row = found("--kb", kb, status=0, **here)[area, "lock"]
        assert (row["state"], row["told"]) == ("note", f"process {os.getpid()} is changing it")
    (kb / CHANGE).mkdir()
    (kb / CHANGE / "rules.pl").write_text("odd :- present(_).\n")
    assert found("--kb", kb, "--fix", status=0, **here)[area, "change"]["state"] == "repaired"
    assert (kb / "rules.pl").read_text() == "odd :- present(_).\n"


def test_a_console_without_our_letters_and_a_folder_where_nothing_can_be_written(tmp_path, here):
    rows = found(status=0, PYTHONIOENCODING="ascii", **here)
    assert rows["console", "encoding"]["told"] == "writes ascii, which lacks signs that are printed, as \\u0393"
    done = plogic("doctor", PYTHONIOENCODING="ascii", **here)
    assert (done.returncode, done.stderr, done.stdout.isascii()) == (0, "", True)
    (tmp_path / "cache/plogic").write_text("a file where the caches would be")
    assert found(status=0, **here)["caches", str(tmp_path / "cache/plogic")]["told"] == "is empty"
