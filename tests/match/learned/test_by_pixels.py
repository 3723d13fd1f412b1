"""Learned types where the photo is known: its pixels move poses and count as evidence; without it nothing changes."""

import numpy as np
import pytest
from painted_cube import CAMERA, CORNER, cloud, cube, picture, pose_towards, seen, write_knowledge

from geometry.frames import transform_points
from kb.files.read import read_kb
from plogic.base.clock import Stopwatch
from plogic.cycle.delta import Options
from plogic.face.python.interpretation import Interpretation
from plogic.face.shown.tables import measures
from plogic.facts.interpretation import situation_of, text_of
from plogic.facts.pixel_table import PixelTable
from plogic.match.judged.evidence import SUREST_MISSED, as_fitted, evidence
from plogic.match.learned.learned_pixels import Seen, by_odds
from plogic.run.perceive import Perceiver
from plogic.scene.asking.explanations import present
from sensing.detectors.detector import detect
from sensing.pixels.photo import Photo

TRUE = pose_towards(CORNER, 0.60, 0.0, (0.0, 0.0))


@pytest.fixture(scope="module")
def perceiver(tmp_path_factory):
    return Perceiver(read_kb(write_knowledge(tmp_path_factory.mktemp("kb"), {"cube": cloud(seen())})))


def gamma_of(perceiver, image):
    return detect(image, CAMERA, perceiver.kb.appearance_types, perceiver.kb.words)


@pytest.fixture(scope="module")
def photo(perceiver):
    """A picture of the cube, and its Γ."""
    image = picture([TRUE], seed=3)
    image.flags.writeable = False
    return image, gamma_of(perceiver, image)


@pytest.fixture(scope="module")
def there(perceiver, photo):
    """Its data, and the cube that is found in them."""
    data, [found] = accepted(perceiver, photo[1], photo[0])
    return data, found


@pytest.fixture(scope="module")
def documents(perceiver, photo):
    """Its interpretation in the score reading, and that of the Γ alone."""
    image, gamma = photo
    return perceiver(gamma, Options(), image), perceiver(gamma, Options())


def accepted(perceiver, gamma, image=None):
    data, cycle = perceiver.cycle(gamma, Options(), Stopwatch(), image=image)
    return data, list(cycle.accepted)


@pytest.fixture(scope="module")
def one_behind(perceiver, there):
    """Data, the cube that is found in them, and a hypothesis of the same outline farther away."""
    data, found = there
    farther = TRUE.copy()
    farther[:3, 3] *= 1.3
    behind = perceiver.models["cube"].settle(farther, data, perceiver.kb, rounds=0)
    return data, found, behind.told(pixels=30.0)


def off(pose):
    vertices = cube().vertices
    apart = transform_points(pose, vertices) - transform_points(TRUE, vertices)
    return np.linalg.norm(apart, axis=1).mean() / np.linalg.norm(np.ptp(vertices, axis=0))


@pytest.mark.parametrize("seed", [3, 4, 5])
def test_the_pose_is_at_least_as_good_and_says_how_well_pixels_fit(perceiver, seed):
    image = picture([TRUE], seed=seed)
    gamma = gamma_of(perceiver, image)
    (_, [without]), (_, [with_it]) = accepted(perceiver, gamma), accepted(perceiver, gamma, image)
    assert without.pixels is None
    assert with_it.pixels is not None
    assert with_it.pixels > 8.0
    assert off(with_it.camera_from_object) < max(0.01, off(without.camera_from_object))


def test_evidence_has_the_pixels_once(perceiver, there):
    """``worth`` and ``surplus`` without them, and what they add; what is missed costs nothing besides."""
    data, found = there
    bare, whole = evidence(found.told(pixels=None), data, perceiver.kb), evidence(found, data, perceiver.kb)
    assert bare.surplus > 0.0
    assert whole.surplus - bare.surplus == pytest.approx(found.pixels)
    assert whole.ratio - bare.ratio == pytest.approx(found.pixels)
    nothing = found.told(pixels=-3.0, matches=np.full(len(found.uv), -1), residual=np.full(len(found.uv), np.nan))
    missed = evidence(nothing.told(pixels=None), data, perceiver.kb)
    assert missed.surplus < SUREST_MISSED
    assert evidence(nothing, data, perceiver.kb).surplus == pytest.approx(SUREST_MISSED - 3.0)


def test_a_photo_of_something_else_costs_what_only_keypoints_see(perceiver, photo):
    """Γ of the cube with a photo in which it is not: the pixels speak against it, and nothing is accepted."""
    image, gamma = photo
    other = np.random.default_rng(1).integers(0, 255, image.shape, dtype=np.uint8)
    _, found = accepted(perceiver, gamma, other)
    assert found == [] or max(h.pixels for h in found) < 0.0


def test_a_pixel_counts_once_for_what_stands_in_front(perceiver, one_behind):
    """A hypothesis behind the cube, of the same outline and print, is told with the cube masked: nothing is left."""
    data, found, behind = one_behind
    index = perceiver.models["cube"]
    assert index.beside(behind, [], data).pixels == 30.0
    assert abs(index.beside(behind, [found], data).pixels) < 3.0
    assert index.beside(found, [behind], data).pixels == pytest.approx(found.pixels, abs=3.0)


@pytest.mark.parametrize(
    ("reading", "says"), [("posterior", "in log-odds"), ("score", "in log-odds, it is accepted by that")]
)
def test_the_document_and_the_explanation_have_it(perceiver, photo, documents, reading, says):
    image, gamma = photo
    asked = Options(reading=reading)
    document, without = documents if asked == Options() else (perceiver(gamma, asked, image), perceiver(gamma, asked))
    (row,) = [h for h in document["hypotheses"] if h["status"] == "accepted"]
    assert row["pixels"] > 8.0
    situation = situation_of(document)
    assert situation.hypotheses[0].pixels == row["pixels"]
    (line,) = [line for line in present(situation, "present(h1)").summary if "the photo shows" in line]
    assert line.startswith("  for: drawn at its pose it is what the photo shows")
    assert f"{row['pixels']:+.3g} {says}" in line
    assert situation.hypotheses[0].pixel_table == PixelTable((), (row["pixels"],))
    assert all("pixels" not in h for h in without["hypotheses"])
    assert not any("photo" in line for line in present(situation_of(without), "present(h1)").summary)


def test_the_program_is_told_of_matches_what_they_say_alone(perceiver, there):
    """Pixels have a factor of their own, and what is missed costs no more than what is found brings."""
    data, found = there
    told, bare = (as_fitted(some, data, perceiver.kb) for some in (found, found.told(pixels=None)))
    assert np.array_equal(told, bare)
    few = np.flatnonzero(found.detected & found.candidate)[4:]
    matches = found.matches.copy()
    matches[few] = -1
    poor = found.told(matches=matches)
    assert evidence(poor.told(pixels=None), data, perceiver.kb).surplus < SUREST_MISSED
    (_, waived), (_, owing) = (as_fitted(some, data, perceiver.kb) for some in (poor, poor.told(pixels=None)))
    assert (waived >= owing).all()
    assert waived.sum() > owing.sum()


def test_of_what_views_suggest_the_pixels_choose(perceiver, photo):
    """The true pose comes first though views are for the others, unless for these beyond all measure; none is lost."""
    shown, paint = Photo(photo[0], CAMERA), perceiver.models["cube"].paint
    nearer, behind = TRUE.copy(), TRUE.copy()
    nearer[:3, 3] *= 0.85
    behind[:3, 3] *= -1.0
    poses = np.array([nearer, TRUE, behind])
    rows = by_odds(shown, paint, Seen(poses, np.array([5.0, 4.0, 3.0])))
    assert [pose.tolist() for _, pose in rows] == [TRUE.tolist(), nearer.tolist()]
    assert rows[0][0] > rows[1][0] + 3.0
    rows = by_odds(shown, paint, Seen(poses, np.array([1000.0, 4.0, 3.0])))
    assert [pose.tolist() for _, pose in rows] == [nearer.tolist(), TRUE.tolist()]


def test_pixels_are_told_by_who_is_before(perceiver, one_behind):
    """One behind the cube has a line for the cube's absence and one for its presence; the cube is before nobody."""
    data, found, behind = one_behind
    index = perceiver.models["cube"]
    table = index.pictured(behind, {"h1": found}, data).pixel_table
    assert table.occluders == ("h1",)
    assert table.odds[1] == index.beside(behind, [found], data).pixels
    assert table.odds[0] < 30.0
    assert index.pictured(found, {"h2": behind}, data).pixel_table == PixelTable((), (found.pixels,))
    assert index.pictured(behind, {}, data).pixel_table == PixelTable((), (30.0,))
    assert index.pictured(behind.told(pixels=None), {"h1": found}, data).pixel_table is None
    many = {f"h{i}": found for i in range(8)}
    assert index.pictured(behind, many, data).pixel_table[0::2] == (("h0", "h1", "h2", "h3", "h4", "h5"), ("h6", "h7"))


def test_the_same_photo_gives_the_same_bytes(perceiver, photo, documents):
    image, gamma = photo
    assert text_of(perceiver(gamma, Options(), image)) == text_of(documents[0])


def test_copies_of_the_process_come_to_the_same(perceiver, photo, there):
    image, gamma = photo
    _, one = there
    _, [other] = accepted(Perceiver(perceiver.kb, processes=2), gamma, image)
    assert np.array_equal(one.camera_from_object, other.camera_from_object)
    assert one.pixels == other.pixels


def test_a_pose_is_told_how_surely_it_is_right(perceiver, there, documents):
    """In the document, its table, the explanation and Python; a pose that is off is told to be so."""
    document, without = documents
    (row,) = [h for h in document["hypotheses"] if h["status"] == "accepted"]
    assert row["pose_probability"] > 0.9
    assert situation_of(document).hypotheses[0].pose_probability == row["pose_probability"]
    assert Interpretation(document).hypotheses[0].pose_probability == row["pose_probability"]
    told = f"within a tenth of its diameter of the true one (ADD) with probability {row['pose_probability']:.3f}"
    assert any(told in line for line in present(situation_of(document), "present(h1)").summary)
    assert "P(pose)" in [column.header for column in measures(document).columns]
    assert all("pose_probability" not in h for h in without["hypotheses"])
    assert "P(pose)" not in [column.header for column in measures(without).columns]
    data, found = there
    index, off_by = perceiver.models["cube"], TRUE.copy()
    off_by[:3, 3] *= 1.25
    wrong = index.settle(off_by, data, perceiver.kb, rounds=0).told(pixels=0.0)
    assert index.pictured(wrong, {}, data).pose_probability < 0.1
    assert index.pictured(found, {}, data).pose_probability == row["pose_probability"]
