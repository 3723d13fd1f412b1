"""Two types that look alike are equally probable wherever one of them stands, and what is left out is told."""

from __future__ import annotations

import shutil

import pytest
from console import good

from plogic import perceive
from plogic.cycle import state


@pytest.fixture(scope="module")
def twins(tmp_path_factory):
    """A knowledge base with one type, and one in which it has a twin."""
    folder = tmp_path_factory.mktemp("twins")
    good("kb", "new", folder / "one", "--example")
    shutil.copytree(folder / "one", folder / "two")
    shutil.copytree(folder / "one/objects/box", folder / "two/objects/twin")
    file = folder / "two/objects/twin/object.yaml"
    file.write_text(file.read_text().replace("object: box", "object: twin", 1))
    return folder


@pytest.mark.parametrize("seed", [1, 2, 6])
def test_both_are_equally_probable(twins, seed):
    scene = twins / f"scene{seed}"
    good("simulate", "--kb", twins / "one", "--objects", 2, "--gamma", "--seed", seed, "-o", scene)
    found = perceive(scene / "gamma.json", twins / "two", reading="posterior")
    accepted = [h for h in found.hypotheses if h.status == "accepted"]
    rivals = [h for h in found.hypotheses if h.status == "rival"]
    assert accepted
    for one in accepted:
        near = [h for h in rivals if abs(h.T_camera_object - one.T_camera_object).max() < 0.01]
        assert [{one.type, h.type} for h in near] == [{"box", "twin"}]
        assert [one.probability, near[0].probability] == pytest.approx([0.5, 0.5], abs=0.05)


def with_others(twins, number):
    """The knowledge base of two with so many more that look alike."""
    kb = twins / f"with {number}"
    shutil.copytree(twins / "two", kb)
    for i in range(number):
        shutil.copytree(twins / "two/objects/twin", kb / f"objects/other{i}")
        file = kb / f"objects/other{i}/object.yaml"
        file.write_text(file.read_text().replace("object: twin", f"object: other{i}", 1))
    return kb


def test_what_stands_elsewhere_does_not_change_what_equals_share(twins):
    kb = with_others(twins, 2)
    for objects in (1, 2):
        scene = twins / f"scene of {objects}"
        good("simulate", "--kb", twins / "one", "--objects", objects, "--gamma", "--seed", 6, "-o", scene)
        found = perceive(scene / "gamma.json", kb, reading="posterior")
        accepted = [h for h in found.hypotheses if h.status == "accepted"]
        assert len(accepted) == objects
        assert "unweighed" not in found.document
        assert [h.probability for h in found.hypotheses if h.status != "rejected"] == pytest.approx(
            [0.25] * 4 * objects, abs=0.02
        )


def test_rivals_that_are_not_weighed_are_told(twins, monkeypatch):
    monkeypatch.setattr(state, "MOST_EQUAL", 3)
    kb, scene = with_others(twins, 4), twins / "scene of many"
    good("simulate", "--kb", twins / "one", "--objects", 1, "--gamma", "--seed", 3, "-o", scene)
    found = perceive(scene / "gamma.json", kb)
    status = [h.status for h in found.hypotheses]
    assert (status.count("accepted"), status.count("rival")) == (1, 3)
    assert found.document["unweighed"] == {"h1": 2}
    beyond = [h for h in found.document["hypotheses"] if "no more are weighed" in h.get("why", "")]
    assert len({h["type"] for h in beyond}) == 2
    found.save(twins / "i.json")
    assert "h1 has 2 more rivals" in good("worlds", twins / "i.json")
    (told,) = {h["type"] for h in beyond if h["id"] == "r1"}
    lines = good("explain", twins / "i.json", "--missing", told, "--kb", kb).splitlines()
    assert lines[0].startswith("data: ")
    assert lines[-1].startswith("  why not: it would stand in the place of what it conflicts with")
