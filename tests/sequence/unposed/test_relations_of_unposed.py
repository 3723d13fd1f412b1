"""How a hypothesis without a pose stands to others, by an ideal detector's reports (§3.8)."""

from __future__ import annotations

from collections import Counter
from dataclasses import replace

import numpy as np
import pytest
from made_prospects import CAMERA, body, camera_at, towers

from geometry.bodies.overlap import solid_overlap
from geometry.frames import from_rotation_translation, inverse, rotation_from_quat_xyzw
from geometry.visibility.composition import possible_triples
from geometry.visibility.occlusion import occlusion
from geometry.visibility.rays import RayMesh
from geometry.visibility.roc import ROC20, coarse
from plogic.match.gamma.data import data_of
from plogic.match.judged.expectation import hidden_by, pose_of
from plogic.match.judged.rivals import solid_of
from plogic.sequence.next_view.expected import Body
from plogic.sequence.unposed import drawn, standing
from plogic.sequence.unposed.drawn import At, Prior
from plogic.sequence.unposed.relations import lawful, placed, posterior, states
from plogic.sequence.unposed.standing import Reports, Stander, Target

VIEW = camera_at(9, 0, 2)


def target(x, *others, opaque=True, hit=0.9):
    """What is known of ``x`` without its pose, where every feature that is to be seen is detected."""
    bodies = [Body(b.id, b.cloud, inverse(VIEW) @ b.reference_from_object, b.opaque) for b in (x, *others)]
    posed = [
        pose_of(towers().type(b.cloud.name), b.reference_from_object, data_of([], CAMERA), towers()) for b in bodies
    ]
    everyone = range(len(bodies))

    def visible(i, beside):
        hidden = [hidden_by(posed[i], posed[j]) for j in beside if j != i]
        return posed[i].candidate & ~np.any([np.zeros(len(posed[i].uv), bool), *hidden], axis=0)

    def reports(which, detected):
        return Reports(detected[which], np.full(which.sum(), hit), np.full(which.sum(), 0.001))

    standers = []
    for i in everyone[1:]:
        known = visible(i, everyone[1:])
        standers.append(Stander(bodies[i], posed[i].at[known], reports(known, visible(i, everyone))))
    facing = posed[0].in_lobe & ~posed[0].self_hidden
    prior = Prior(bodies[0].cloud, facing, tuple(bodies[1:]), CAMERA)
    own = reports(posed[0].candidate, visible(0, everyone))
    inside = posed[0].in_image[facing]
    return Target(prior, opaque, inside, np.flatnonzero(inside), own, tuple(standers))


def told(subject):
    found = states(subject, posterior(subject))
    shares = Counter()
    for state, share in found.items():
        shares[coarse(state[0])] += share
    return shares


FRONT, BACK, ASIDE = body("h1", "t1", 2, 0.4), body("h2", "t2", -1, 0), body("h3", "t2", 0, 3.5)


def test_what_hides_is_before_what_it_hides_whoever_has_no_pose():
    assert told(target(FRONT, BACK))["partially_occludes"] > 0.9
    assert told(target(BACK, FRONT))["partially_occluded_by"] > 0.9


def test_what_hides_nothing_is_beside():
    assert told(target(ASIDE, BACK))["non_occludes"] > 0.9


def test_what_has_no_evidence_is_hidden():
    subject = target(body("h2", "t2", -0.5, 0), body("h1", "t1", 5, 0))
    subject.reports.detected[:] = False
    shares = told(subject)
    assert shares["totally_occluded_by"] + shares["partially_occluded_by"] > 0.95
    assert shares["totally_occluded_by"] > 0.5


def test_it_is_a_distribution_over_the_twenty_and_the_same_again():
    found = states(target(FRONT, BACK), posterior(target(FRONT, BACK)))
    assert sum(found.values()) == pytest.approx(1.0, abs=1e-12)
    assert {relation for (relation,) in found} <= set(ROC20)
    assert found == states(target(FRONT, BACK), posterior(target(FRONT, BACK)))


def test_without_detections_it_is_the_prior(monkeypatch):
    """Against poses drawn here, one by one: even in the image, in log depth and rotation, no volume shared."""
    monkeypatch.setattr(drawn, "UNLIKE", 0.0)
    monkeypatch.setattr(standing, "UNLIKE", 0.0)
    subject = target(FRONT, BACK, hit=0.0)
    for reports in (subject.reports, subject.standers[0].reports):
        reports.detected[:] = False
    shares, rng, counted = told(subject), np.random.default_rng(7), Counter()
    other = subject.standers[0].body
    y, solids = (
        placed(other.cloud, other.reference_from_object),
        [solid_of(towers().type(n).surface.solid) for n in ("t1", "t2")],
    )
    while sum(counted.values()) < 400:
        ray = CAMERA.rays(rng.uniform(-0.5, [639.5, 479.5]))
        R = rotation_from_quat_xyzw(rng.normal(size=4))
        middle = ray / ray[2] * np.exp(rng.uniform(*np.log(subject.prior.depth)))
        pose = from_rotation_translation(R, middle - R @ subject.prior.cloud.middle)
        if not solid_overlap(solids[0], pose, solids[1], other.reference_from_object):
            counted[coarse(occlusion(placed(subject.prior.cloud, pose), y, CAMERA))] += 1
    assert len(counted) > 2
    assert {name: shares[name] for name in counted} == pytest.approx({n: c / 400 for n, c in counted.items()}, abs=0.08)


def test_glass_hides_nothing_so_what_is_missed_behind_it_says_nothing():
    clear = target(FRONT, BACK, opaque=False)
    nothing_missed = target(FRONT, Body("h2", BACK.cloud, BACK.reference_from_object, opaque=True), opaque=False)
    for one in nothing_missed.standers:
        one.reports.detected[:] = True
    assert told(clear) == told(nothing_missed)


def test_no_pose_shares_volume():
    subject = target(FRONT, BACK)
    other = subject.standers[0].body.reference_from_object
    solids = [solid_of(towers().type(n).surface.solid) for n in ("t1", "t2")]
    found = posterior(subject)
    depths = [solid_overlap(solids[0], pose, solids[1], other) for pose in found.poses[found.near]]
    assert len(depths) > 100
    assert np.mean(np.array(depths) > 1e-3 * solids[0].volume) < 0.02


def test_what_is_not_closed_has_no_inside():
    subject = target(FRONT, BACK)
    here = subject.standers[0].body
    at = At(here.reference_from_object[None, :3, :3], here.middle[None])
    assert not np.isfinite(subject.log_likelihood(at)).any()
    rays = here.cloud.rays
    sheet = replace(here.cloud, rays=RayMesh(rays.vertices, rays.triangles[1:]))
    opened = replace(subject.prior, cloud=replace(subject.prior.cloud, rays=sheet.rays))
    beside = (replace(subject.standers[0], body=replace(here, cloud=sheet)),)
    assert np.isfinite(replace(subject, prior=opened, standers=beside).log_likelihood(at)).all()


def test_what_stands_to_several_goes_with_how_these_stand():
    subject = target(FRONT, BACK, ASIDE)
    two = [placed(one.body.cloud, one.body.reference_from_object) for one in subject.standers]
    known = occlusion(two[0], two[1], CAMERA)
    found = states(subject, posterior(subject))
    assert len(found) > 1
    assert all((x_y, known, x_z) in possible_triples() for x_y, x_z in found)


def test_a_third_in_front_excludes_what_composition_excludes():
    """Z covers all of y: what is before some of y cannot be beside z."""
    found = {
        ("partially_occludes_po", "non_occludes_dc"): 0.5,
        ("partially_occludes_po", "partially_occluded_by_po"): 0.25,
    }
    left = lawful(found, {(0, 1): "totally_occluded_by_ntpp"})
    assert left == {("partially_occludes_po", "partially_occluded_by_po"): 1.0}
