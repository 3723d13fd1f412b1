"""`perceive --dv-over instances`: every ev by dv over the instances in Δ (§5.1, the variant of the paper's §9)."""

from __future__ import annotations

import json
from types import SimpleNamespace

import numpy as np
import pytest
from console import document, good, plogic
from synthetic import camera_pose, perceiver, scene, towers

from plogic.cycle.judging import over_instances
from plogic.cycle.state import Cycle, Trace
from plogic.facts.hypothesis import Hypothesis
from plogic.measures.distinctiveness import distinctiveness, instance_counts
from sensing.files.gamma_files import gamma_to_dict

OVER_T1 = {"apex": 1.0, "corner": 1 - 8 / 58, "patch": 1 - 50 / 58}
"""By hand: the tower has 8 corners and 50 patches, and of an apex there is no instance."""


@pytest.fixture(scope="module")
def one_tower():
    """A scene with the wedge tower alone, and a tenth of what is missed: ev is neither 1 nor the same by both dv."""
    rng = np.random.default_rng(8062)
    return scene(rng, {"t1": camera_pose(rng, (3.5, 6.0))})


@pytest.fixture(scope="module")
def told(one_tower, tmp_path_factory):
    folder = tmp_path_factory.mktemp("dv")
    (folder / "gamma.json").write_text(json.dumps(gamma_to_dict(one_tower.gamma)))
    for over in ("types", "instances"):
        good("perceive", "gamma.json", "--kb", "towers", "--dv-over", over, "-o", f"{over}.json", cwd=folder)
    return folder


def share(features, dv):
    """P(ev) by its definition: dv of concordant features over dv of all in the image."""
    rows = [f for f in features if f["in_image"]]
    return sum(dv[f["type"]] for f in rows if f["expected"] == f["detected"]) / sum(dv[f["type"]] for f in rows)


@pytest.mark.parametrize(("over", "dv"), [("types", None), ("instances", OVER_T1)])
def test_p_ev_is_the_formula_with_that_dv_and_the_program_gives_it(told, over, dv):
    read = json.loads((told / f"{over}.json").read_text())
    dv = dv or distinctiveness(instance_counts(towers().types))
    (row,) = [h for h in read["hypotheses"] if h["status"] == "accepted"]
    assert row["type"] == "t1"
    assert row["p_ev"] == pytest.approx(share(row["features"], dv), abs=1e-9)
    answers = document("query", told / f"{over}.json", f"present({row['id']})", "--json")["answers"]
    assert answers[0]["probability"] == pytest.approx(row["p_ev"], abs=1e-9)
    assert read["measures"]["dv"] == pytest.approx(dv)
    assert sum(read["measures"]["p_dv"].values()) == pytest.approx(1.0)


def test_the_two_differ_and_later_commands_say_which(told):
    types, instances = (document("measures", told / f"{over}.json", "--json") for over in ("types", "instances"))
    assert (types["dv_over"], instances["dv_over"]) == ("types", "instances")
    assert types["hypotheses"][0]["ev"] != instances["hypotheses"][0]["ev"]
    assert types["hypotheses"][0]["ev_over_instances"] == pytest.approx(instances["hypotheses"][0]["ev"])
    assert types["features"] == instances["features"], "both tell dv over types and over instances"
    assert "dv over the instances in Δ" in good("measures", told / "instances.json")
    assert "dv over the instances in Δ" in good("explain", told / "instances.json", "present(h1)")
    assert "instances in Δ," not in good("measures", told / "types.json")


def test_where_nothing_is_found_dv_is_that_over_types(tmp_path, one_tower):
    empty = {**gamma_to_dict(one_tower.gamma), "appearances": []}
    (tmp_path / "gamma.json").write_text(json.dumps(empty))
    read = document("perceive", "gamma.json", "--kb", "towers", "--dv-over", "instances", cwd=tmp_path)
    assert read["measures"]["dv"] == pytest.approx(distinctiveness(instance_counts(towers().types)))


def test_what_has_no_ev_above_0_by_it_is_released(one_tower):
    """With one instance of every feature type but the one that was found, what was found weighs nothing."""
    (belief,) = [b for b, _ in perceiver().accepted(one_tower.gamma)]
    missed = belief.told(matches=np.where(belief.candidate, -1, belief.matches))
    cycle, dv = over_instances(Cycle((missed,), (), (), (), Trace()), towers())
    assert not cycle.accepted
    assert cycle.rejected[0].status == "rejected"
    assert "dv over the instances" in cycle.rejected[0].why
    assert dv == distinctiveness(instance_counts(towers().types))


def test_with_one_feature_type_alone_in_delta_dv_is_that_over_types():
    def of(*names):
        return SimpleNamespace(all_features=[SimpleNamespace(type=name) for name in names])

    corners, both = of("corner", "corner"), of("corner", "patch")
    found = Hypothesis("corners", np.eye(4), opaque=True, known_type=corners, ev_reconsidered=0.5)
    kb = SimpleNamespace(types=(corners, both))
    assert over_instances(Cycle((found,), (), (), (), Trace()), kb)[1] == {"corner": 0.25, "patch": 0.75}


def test_several_views_refuse_it(tmp_path, told):
    done = plogic("perceive", told / "gamma.json", told / "gamma.json", "--kb", "towers", "--dv-over", "instances")
    assert done.returncode == 1
    assert "--dv-over instances: is of one image" in done.stderr
