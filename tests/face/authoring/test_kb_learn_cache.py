"""What a remembered cloud depends on.

Every source file that decides it, the libraries, the mesh as it is rendered, the options.
"""

from __future__ import annotations

import contextlib
import tempfile
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from painted_cube import write_cube
from random_cloud import random_cloud

from geometry.files.remembered import OURS, ROOT, cache_folder, source_digest, sources
from kb.clouds.learned import cloud_bytes, read_cloud
from kb.errors import CloudError
from plogic.base.errors import InputError
from plogic.base.jobs import ChildDiedError
from plogic.face.authoring import kb_learn_all, kb_learn_words
from plogic.face.authoring import kb_learn_look as kb_learn_cache
from plogic.face.authoring.kb_learn_all import kept_cloud, learned
from plogic.face.authoring.kb_learn_look import DECIDES, fitted, key_of
from plogic.face.authoring.kb_learn_words import words_of
from plogic.face.authoring.kb_types import add_command, new_command
from plogic.face.shown.options import Learning
from plogic.face.shown.progress import Work
from plogic.run.sources import kb_of
from sensing.simulated.body import TexturedMesh

HOW = (600.0, "sift", 0, False)
FORMS = (
    "import {0}\n",
    "from pack import {1}\n",
    "from {0} import something\n",
    "def f():\n    from {0} import something\n",
)
"""How one module may import another."""


def mesh():
    square = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]])
    return TexturedMesh(
        square, np.array([[0, 1, 2], [0, 2, 3]]), square[:, :2], np.arange(48, dtype=np.uint8).reshape(4, 4, 3)
    )


def written(folder, imports, forms):
    """Modules ``pack/m0.py``, ... that import each other as asked.

    Each also names all the others for the type checker alone.
    """
    (folder / "pack").mkdir()
    for i, others in enumerate(imports):
        lines = [forms[(i + j) % len(forms)].format(f"pack.m{j}", f"m{j}") for j in others]
        typed = "".join(f"    from pack.m{j} import Type\n" for j in range(len(imports)))
        (folder / "pack" / f"m{i}.py").write_text(
            "".join(lines) + "import json\nif TYPE_CHECKING:\n    import os\n" + typed
        )
    return folder


def reached(imports):
    """Indices of what the first module imports, directly or not."""
    found, left = {0}, [0]
    while left:
        new = set(imports[left.pop()]) - found
        found |= new
        left += new
    return found


graphs = st.integers(1, 6).flatmap(
    lambda n: st.lists(st.sets(st.integers(0, n - 1), max_size=2), min_size=n, max_size=n)
)


@settings(max_examples=60, deadline=None, derandomize=True)
@given(graphs, st.permutations(FORMS), st.data())
def test_a_changed_byte_changes_the_digest_where_the_file_is_imported_and_nowhere_else(imports, forms, data):
    changed = data.draw(st.integers(0, len(imports) - 1))
    with tempfile.TemporaryDirectory() as name:
        folder, first = written(Path(name), imports, forms), "pack/m0.py"
        found = sources(folder, first, ["pack"])
        assert found == {f"pack/m{i}.py" for i in reached(imports)}
        before = source_digest(folder, found)
        assert source_digest(folder, sorted(found, reverse=True)) == before
        file = folder / "pack" / f"m{changed}.py"
        file.write_bytes(file.read_bytes() + b"#")
        assert (source_digest(folder, sources(folder, first, ["pack"])) == before) == (changed not in reached(imports))
        file.write_bytes(file.read_bytes()[:-1])
        assert source_digest(folder, sources(folder, first, ["pack"])) == before, "same content, same digest"


def test_what_lies_beside_an_installed_plogic_is_not_followed(tmp_path):
    (tmp_path / "pack").mkdir()
    (tmp_path / "pack" / "m0.py").write_text("import numpy\nfrom pack import m1\nfrom numpy import linalg\n")
    (tmp_path / "pack" / "m1.py").write_text("")
    for name in ("numpy/__init__.py", "numpy/linalg.py"):
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_text("this is not even Python")
    assert sources(tmp_path, "pack/m0.py", ["pack"]) == {"pack/m0.py", "pack/m1.py"}
    assert {name.split("/")[0] for name in sources(ROOT, DECIDES)} <= {*OURS}


def test_all_that_renders_looks_and_learns_decides_and_what_only_shows_does_not():
    found = sources(ROOT, DECIDES)
    learning = {f"kb/learning/{name}.py" for name in ("observations", "features", "photo")}
    seeing = {
        "sensing/detectors/keypoints.py",
        "sensing/simulated/stage.py",
        "sensing/simulated/body.py",
    }
    assert learning | seeing | {"kb/clouds/learned.py", "geometry/cones.py", "geometry/camera.py", DECIDES} <= found
    assert not any(name.startswith(("plogic/face/pages", "plogic/match/gamma")) for name in found)
    assert "kb/files/read.py" not in found


def test_the_same_asked_again_has_the_same_key_and_anything_else_another(monkeypatch):
    key, some = key_of(mesh(), HOW), mesh()
    assert key_of(mesh(), HOW) == key
    keys = {
        key,
        *(
            key_of(some, how)
            for how in [
                (500.0, *HOW[1:]),
                (600.0, "orb", 0, False),
                (600.0, "sift", 1, False),
                (600.0, "sift", 0, True),
            ]
        ),
    }
    keys.add(key_of(replace(some, texture=some.texture[::-1]), HOW))
    keys.add(key_of(replace(some, vertices=some.vertices * 0.1), HOW))
    keys.add(key_of(replace(some, triangles=some.triangles[::-1]), HOW))
    monkeypatch.setattr(cv2, "__version__", "0.0")
    keys.add(key_of(some, HOW))
    monkeypatch.undo()
    monkeypatch.setattr(kb_learn_cache, "source_digest", lambda *_: b"other code")
    keys.add(key_of(some, HOW))
    assert len(keys) == 10


def test_a_user_without_a_home_has_no_cache(monkeypatch, tmp_path):
    def none(_=None):
        raise RuntimeError("Could not determine home directory.")

    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    assert cache_folder("clouds") == tmp_path / "plogic" / "clouds"
    monkeypatch.delenv("XDG_CACHE_HOME")
    monkeypatch.setattr(Path, "home", none)
    assert cache_folder("clouds") is None


@pytest.mark.parametrize("name", sorted(sources(ROOT, DECIDES)))
def test_every_source_that_decides_is_shipped(name):
    """The wheel holds these packages (pyproject.toml), so that an installed plogic finds what it hashes."""
    assert name.split("/")[0] in {"geometry", "kb", "sensing", "plogic"}


def test_a_kept_cloud_in_which_any_bit_is_wrong_is_learned_anew():
    """Also one that makes it the valid file of another cloud, as in the name of an array that need not be there."""
    cloud = replace(random_cloud(1, 3, 3), compound=np.array([1, 1, 0]))
    content = cloud_bytes(cloud)
    assert kept_cloud(content) == content
    valid = 0
    for place in range(len(content)):
        harmed = content[:place] + bytes([content[place] ^ 1 << place % 8]) + content[place + 1 :]
        if not valid:
            with contextlib.suppress(CloudError):
                valid += cloud_bytes(read_cloud(harmed)) != content
        with pytest.raises(CloudError):
            kept_cloud(harmed)
    assert valid > 0


class StoppedError(Exception):
    """By the user, say."""


def steps_of(monkeypatch, most=10**9):
    """What is asked of processes, of which none is begun.

    Nothing is seen, clouds are made up; it stops after ``most``.
    """
    asked = []

    def growing(_, steps, __, then):
        left = list(steps)
        while left:
            if len(asked) == most:
                raise StoppedError
            step = left.pop(0)
            made = cloud_bytes(random_cloud(len(step.name), 3, 3)) if step.call.func is fitted else []
            asked.append((step.name, "view" if step.part else step.call.func.__name__))
            left[:0] = then(step, [None] * len(step.part) if step.part else made)

    monkeypatch.setattr(kb_learn_all, "growing", growing)
    return asked


def learn(kb, turned, said=None):
    with Work(1.0, (said if said is not None else []).append) as work:
        return learned(kb.types, turned, kb, Learning(), work)


def test_who_was_stopped_goes_on_from_what_was_learned(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    new_command(tmp_path / "kb", None)
    for i, name in enumerate(("one", "other")):
        add_command(name, write_cube(tmp_path, 1.0 + i), "m", tmp_path / "kb", as_json=False)
    kb = kb_of(str(tmp_path / "kb"))
    whole = steps_of(monkeypatch)
    first = learn(kb, {"one"})
    views = whole.count(("one", "view"))
    assert views > 0
    assert whole[views:] == [
        ("one", "fitted"),
        ("one", "turns_tried"),
        *[("other", "view")] * views,
        ("other", "fitted"),
    ]
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "anew"))
    stopped = steps_of(monkeypatch, views + 2)
    with pytest.raises(StoppedError):
        learn(kb, {"one"})
    assert stopped == whole[: views + 2]
    rest, said = steps_of(monkeypatch), []
    again = learn(kb, {"one"}, said)
    assert rest == whole[views + 2 :]
    assert [line.partition(" (")[0] for line in said if "before" in line] == ["one: was learned before"]
    for name, (cloud, tried) in first.items():
        assert cloud_bytes(again[name].cloud) == cloud_bytes(cloud)
        assert again[name].trials == tried
        assert (tried is None) == (name == "other")
    nothing = steps_of(monkeypatch)
    learn(kb, ())
    assert nothing == []


def test_a_process_that_is_killed_is_one_clear_line(tmp_path, monkeypatch):
    def growing(*_):
        raise ChildDiedError("signal 9")

    monkeypatch.setattr(kb_learn_all, "growing", growing)
    new_command(tmp_path / "kb", None)
    with pytest.raises(InputError, match=r"ended \(signal 9\): where memory is short, fewer --jobs than 2"):
        learn(kb_of(str(tmp_path / "kb")), ())


def test_words_are_made_once_of_the_same_clouds(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    clouds = {name: random_cloud(seed, 30 + seed, 90) for seed, name in enumerate(("b", "a"))}
    made, worded = [], kb_learn_words.worded
    monkeypatch.setattr(kb_learn_words, "worded", lambda *some: made.append(some) or worded(*some))
    first, again = words_of(clouds, 0), words_of(dict(reversed(clouds.items())), 0)
    expected = worded(clouds, 0)
    assert len(made) == 1
    for words, named in (first, again):
        assert np.array_equal(words.centroids, expected[0].centroids)
        assert {name: cloud_bytes(cloud) for name, cloud in named.items()} == {
            name: cloud_bytes(cloud) for name, cloud in expected[1].items()
        }
    words_of(clouds, 1)
    words_of(clouds | {"a": replace(clouds["a"], hit=clouds["a"].hit * 0.5)}, 0)
    assert len(made) == 3
    monkeypatch.setattr(kb_learn_words, "cache_folder", lambda _: None)
    assert words_of(clouds, 0)[0].detector == "sift"
    assert len(made) == 4
