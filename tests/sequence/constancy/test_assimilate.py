"""An unknown object becomes a draft type, which is then perceived.

Through functions, and through the console script.
"""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest
from console import bytes_in, document, good
from written_kb import write_kb
from written_panoramas import EMPTY, NOTHING_ELSE, interpretation_of

from benchmarks.constancy.explained import unexplained_of
from benchmarks.constancy.scenes import constancy_kb, sequence
from geometry.camera import camera_to_dict
from geometry.errors import PlogicError
from kb.files.read import read_kb
from plogic.cycle.delta import Options
from plogic.face.authoring.kb_show import check_command
from plogic.face.authoring.kb_types import assimilate_command
from plogic.run.perceive import Perceiver
from plogic.sequence.constancy.decide import unknown_objects
from plogic.sequence.constancy.result import constancy_document, draft_type, seen_features
from sensing.files.gamma_files import appearance_to_dict, gamma_to_dict

SEED = 2003


@pytest.fixture(scope="module")
def kb():
    """Two types, neither of which is looked at here."""
    whole = constancy_kb(3)
    types = whole.types[:2]
    used = {feature.type for kind in types for feature in kind.features}
    rates = replace(whole.rates, hit=dict.fromkeys(sorted(used), 0.8), prior={kind.name: 0.2 for kind in types})
    return replace(whole, types=types, rates=rates)


@pytest.fixture(scope="module")
def moved(kb):
    """A sequence whose bodies are all unknown: four views, three of which are looked at."""
    whole = sequence(constancy_kb(3), SEED, 4)
    return replace(whole, known=tuple(False for _ in whole.known))


@pytest.fixture(scope="module")
def constancy(kb, moved):
    views = moved.views[:3]
    return unknown_objects(views, {v.id: [a.id for a in v.gamma.appearances] for v in views}, kb.rates)


@pytest.fixture(scope="module")
def panorama(moved, constancy, kb):
    views = [
        {
            "id": view.id,
            "frame": f"{view.id}.json",
            "T_world_camera": view.world_from_camera.tolist(),
            "interpretation": interpretation_of(
                camera_to_dict(view.gamma.camera),
                [appearance_to_dict(a, described=False) for a in view.gamma.appearances],
            ),
            **NOTHING_ELSE,
        }
        for view in moved.views[:3]
    ]
    head = {**EMPTY, "kb": {"name": kb.name, "digest": kb.digest}, "views": views}
    return head | constancy_document(constancy)


@pytest.fixture
def there(tmp_path, kb, panorama):
    """The KB's folder and the panorama's file."""
    write_kb(kb, tmp_path / "kb")
    (tmp_path / "panorama.json").write_text(json.dumps(panorama))
    return tmp_path


def own(moved, constancy, view):
    """The data of a view that are of the body that the first unknown object is of."""
    bodies = [
        moved.causes[v][d].object
        for f in constancy.unknown[0].features
        for v, d in f.data.items()
        if d in moved.causes[v]
    ]
    which = max(set(bodies), key=bodies.count)
    return {name for name, cause in moved.causes[view.id].items() if cause.object == which}


def explained(document, kind):
    """The data that hypotheses of a type explain, of those that are accepted."""
    mine = {h["id"] for h in document["hypotheses"] if h["type"] == kind and h["status"] == "accepted"}
    causes = document["worlds"][0]["causes"]
    return {name for name, cause in causes.items() if cause.split("/")[0] in mine}


def test_a_draft_is_found_again_and_explains_what_was_unexplained(kb, moved, constancy):
    kind = draft_type("draft", seen_features(constancy.unknown[0], moved.views), kb.f_ref)
    perceiver = Perceiver(replace(kb, types=(*kb.types, kind)))
    assert len(moved.views) > 2
    for view in moved.views[1:3]:
        seen = perceiver(view.gamma, Options(reading="posterior"))
        mine, truth = explained(seen, "draft"), own(moved, constancy, view)
        assert len(truth) > 10
        assert len(mine & truth) > 0.6 * len(truth)
        assert not mine & set(unexplained_of(seen))


def test_the_draft_stands_where_it_was(kb, moved, constancy):
    features = seen_features(constancy.unknown[0], moved.views)
    kind = draft_type("draft", features, kb.f_ref)
    assert np.allclose(np.mean([f.at for f in kind.features], axis=0), 0.0, atol=1e-9)
    middle = np.mean([f.at for f in features], axis=0)
    (accepted,) = [b for b, _ in Perceiver(replace(kb, types=(kind,))).accepted(moved.views[1].gamma)]
    world = moved.views[1].world_from_camera @ accepted.camera_from_object
    assert np.linalg.norm(world[:3, 3] - middle) < 0.03
    assert np.degrees(np.arccos((np.trace(world[:3, :3]) - 1) / 2)) < 3.0


def test_lobes_hold_those_who_saw_and_the_body_hides_nothing_seen(kb, moved, constancy):
    features = seen_features(constancy.unknown[0], moved.views)
    kind = draft_type("draft", features, kb.f_ref)
    middle = np.mean([f.at for f in features], axis=0)
    blocked = total = 0
    for feature, seen in zip(kind.features, features, strict=True):
        (shown,) = feature.appearances
        for sighting in seen.sightings:
            towards = sighting.eye - seen.at
            far = float(np.linalg.norm(towards))
            assert np.arccos(np.clip(towards / far @ feature.rotation @ shown.lobe.axis, -1, 1)) < shown.lobe.half_angle
            assert shown.lobe.r_min < far * kb.f_ref / sighting.focal < shown.lobe.r_max
            if kind.surface is not None:
                blocked += int(
                    kind.surface.rays.blocks(sighting.eye - middle, feature.at[None], 0.004 * kind.surface.diameter)[0]
                )
            total += 1
    assert blocked <= 0.05 * total
    assert kind.opaque == (kind.surface is not None)


def test_through_the_console_script(there, moved, constancy):
    text = (there / "panorama.json").read_text()
    told = good("kb", "assimilate", "-", "u1", "--kb", there / "kb", "--name", "mug", stdin=text)
    assert told.startswith(f"mug: a draft of {len(constancy.unknown[0].features)} features, ")
    assert "no mistakes" in check_command(str(there / "kb"), as_json=False)
    view = moved.views[1]
    (there / "gamma.json").write_text(json.dumps(gamma_to_dict(view.gamma)))
    seen = document("perceive", there / "gamma.json", "--kb", there / "kb", "--reading", "posterior")
    assert len(explained(seen, "mug") & own(moved, constancy, view)) > 10


def assimilate(there, unknown="u1", name="mug", kb="kb", *, as_json=False):
    return assimilate_command(str(there / "panorama.json"), unknown, str(there / kb), name, as_json=as_json)


def test_what_is_written_is_read_as_it_was_made(there, kb, moved, constancy):
    told = json.loads(assimilate(there, as_json=True))
    made = draft_type("mug", seen_features(constancy.unknown[0], moved.views), kb.f_ref)
    read = read_kb(there / "kb").type("mug")
    assert told["format"] == "kb_assimilate/1"
    assert told["type"]["features"] == len(read.features) == len(made.features)
    assert np.allclose([f.at for f in read.features], [f.at for f in made.features], atol=1e-9)
    assert np.allclose([f.rotation for f in read.features], [f.rotation for f in made.features], atol=1e-6)
    assert np.allclose(read.lobes.cos_half, made.lobes.cos_half)
    assert (told["type"]["mesh"] == "hull") == (read.surface is not None)


def refused(there, *args, **options):
    """What is said where nothing is written."""
    before = bytes_in(there)
    with pytest.raises(PlogicError) as caught:
        assimilate(there, *args, **options)
    assert bytes_in(there) == before
    return str(caught.value)


def test_never_over_a_type(there):
    assimilate(there)
    assert "exists already" in refused(there)


def test_what_cannot_be_assimilated(there, panorama):
    assert "is no unknown object; there are: u1" in refused(there, "u99")
    assert "is no name for a type" in refused(there, name="../mug")
    few = json.loads(json.dumps(panorama))
    del few["unknown"][0]["features"][3:]
    (there / "panorama.json").write_text(json.dumps(few))
    assert "has 3 features, and a pose is taken from 4" in refused(there)


def test_types_that_the_kb_has_not(there):
    text = (there / "kb" / "kb.yaml").read_text()
    (there / "other").mkdir()
    (there / "other" / "kb.yaml").write_text(text[: text.index("detector:")].replace("a0", "b0"))
    assert "no appearance types of constancy; add them to kb.yaml" in refused(there, kb="other")


def test_a_shipped_kb_is_left_alone(there):
    before = bytes_in(there)
    with pytest.raises(PlogicError, match="is shipped with plogic"):
        assimilate_command(str(there / "panorama.json"), "u1", "towers", "mug", as_json=False)
    assert bytes_in(there) == before
