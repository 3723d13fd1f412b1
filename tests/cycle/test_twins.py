"""Two types that look alike are equally probable wherever one of them stands, and what is left out is told."""

from __future__ import annotations

import shutil

import pytest
from console import good

from plogic import perceive


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


def test_rivals_that_are_not_weighed_are_told(twins):
    for i in range(4):
        shutil.copytree(twins / "two/objects/twin", twins / f"two/objects/other{i}", dirs_exist_ok=True)
        file = twins / f"two/objects/other{i}/object.yaml"
        file.write_text(file.read_text().replace("object: twin", f"object: other{i}", 1))
    scene = twins / "scene of one"
    good("simulate", "--kb", twins / "one", "--objects", 1, "--gamma", "--seed", 3, "-o", scene)
    document = perceive(scene / "gamma.json", twins / "two").document
    status = [h["status"] for h in document["hypotheses"]]
    assert (status.count("accepted"), status.count("rival")) == (1, 2)
    beyond = [h["type"] for h in document["hypotheses"] if "only the best 2 such are weighed" in h.get("why", "")]
    assert len(set(beyond)) == 3
