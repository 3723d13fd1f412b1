"""A painted cube in pictures of another renderer: poses put wrong on purpose come back, and what is absent is told."""

from dataclasses import replace

import cv2
import numpy as np
import pytest
from painted_cube import CAMERA, CORNER, cube, picture, pose_towards
from scipy.spatial.transform import Rotation

from geometry.bodies.resting import Plane, resting_faces
from geometry.bodies.standing import Contact, Known, Noise
from geometry.camera import Camera
from geometry.frames import inverse, transform_points
from kb.surfaces.surface import Surface
from sensing.pixels.crop import crop_of
from sensing.pixels.drawn import Paint
from sensing.pixels.energy import NO_FIT, choice, fit_of, printed, trusted
from sensing.pixels.photo import Photo
from sensing.pixels.refine import FINE, different, half_turns, moved, refined, starts_about

TRUE = pose_towards(CORNER, 0.60, 0.0, (0.0, 0.0))


@pytest.fixture(scope="module")
def paint():
    return Paint(cube())


@pytest.fixture(scope="module")
def photo():
    return Photo(picture([TRUE], seed=3), CAMERA)


def off(paint, pose, truth=TRUE):
    """ADD, in diameters."""
    vertices = paint.mesh.vertices
    apart = transform_points(pose, vertices) - transform_points(truth, vertices)
    return np.linalg.norm(apart, axis=1).mean() / paint.diameter


def disturbed(paint, turn=(0.0, 0.0, 0.0), shift=(0.0, 0.0, 0.0)):
    return moved(TRUE, paint.middle, np.concatenate([np.radians(turn), shift]))


@pytest.mark.parametrize(
    ("turn", "shift"),
    [
        ((0, 0, 0), (0, 0, 0)),
        ((0, 0, 0), (0, 0, 0.048)),
        ((0, 0, 0), (0, 0, -0.048)),
        ((0, 0, 0), (0.006, -0.006, 0)),
        ((10, 0, 0), (0, 0, 0)),
        ((0, -10, 4), (0, 0, 0.03)),
    ],
)
def test_a_pose_that_is_off_comes_back(paint, photo, turn, shift):
    """8 % of the distance, 7 px across, 10° of tilt, and both."""
    pose, fit, hopeless, spread, released = refined(photo, paint, disturbed(paint, turn, shift))
    assert off(paint, pose) < 0.02
    assert fit.odds > 8.0
    assert not hopeless
    assert released is None
    turned = cv2.Rodrigues(pose[:3, :3] @ TRUE[:3, :3].T)[0].ravel()
    step = np.append(turned, (pose - TRUE)[:3] @ np.append(paint.middle, 1.0))
    assert step @ np.linalg.solve(spread, step) < 16.8  # χ² of six, 0.99
    assert 0.0005 < np.sqrt(spread[5, 5]) < 0.02


@pytest.mark.parametrize("shift", [0.03, -0.03, 0.0])
def test_paint_that_is_not_the_objects_pulls_nothing(photo, shift):
    """Where no print correlates with the photo, edges alone say in the end where the cube is."""
    from painted_cube import paint as print_of

    other = Paint(replace(cube(), texture=print_of(seed=11)))
    pose, fit, *_ = refined(photo, other, disturbed(other, (0, 4, 0), (0, 0, shift)))
    assert fit.correlation < 0.2
    assert off(other, pose) < 0.01


def test_print_is_trusted_as_far_as_any_correlates():
    fit = NO_FIT._replace(correlation=0.1)
    assert trusted([fit]) == 0.0
    assert trusted([fit, fit._replace(correlation=0.35)]) == pytest.approx(0.5)
    assert trusted([fit._replace(correlation=0.6), fit]) == 1.0


def test_in_a_picture_without_it_nothing_fits(paint):
    empty = Photo(np.random.default_rng(0).integers(0, 255, (CAMERA.height, CAMERA.width, 3), dtype=np.uint8), CAMERA)
    found = refined(empty, paint, TRUE)
    assert found is not None
    assert found.hopeless
    assert found.fit.odds < 0.0


def test_the_right_pose_fits_better_than_wrong_ones(paint, photo):
    crop = crop_of(photo, paint, TRUE, FINE)
    wrong = [
        disturbed(paint, (0, 0, 0), (0, 0, 0.03)),
        disturbed(paint, (15, 0, 0)),
        disturbed(paint, (0, 0, 90)),
        disturbed(paint, (180, 0, 0)),
    ]
    best, scores = choice([fit_of(crop, paint, pose) for pose in (*wrong, TRUE)])
    assert best == len(wrong)
    assert scores[best] > max(scores[:best]) + 3.0


def test_another_print_on_the_same_shape_is_not_it(photo):
    """Its outline fits, its print does not."""
    from painted_cube import paint as print_of

    other = Paint(replace(cube(), texture=print_of(seed=77)))
    own = Paint(cube())
    crop = crop_of(photo, own, TRUE, FINE)
    mine, its = (fit_of(crop, some, TRUE) for some in (own, other))
    assert its.edges > 0.5
    assert its.correlation < 0.5 * mine.correlation
    assert its.odds < 0.0
    assert mine.odds > 8.0


def test_a_camera_without_colours_shows_the_same_object(paint, photo):
    """Brightness is compared where there is nothing else: the pose comes back, and other print is told apart."""
    from painted_cube import paint as print_of

    grey = Photo(cv2.cvtColor(cv2.cvtColor(photo.image, cv2.COLOR_BGR2GRAY), cv2.COLOR_GRAY2BGR), CAMERA)
    assert (grey.grey, photo.grey) == (True, False)
    pose, fit, *_ = refined(grey, paint, disturbed(paint, (0, -10, 4), (0, 0, 0.03)))
    assert off(paint, pose) < 0.02
    assert fit.shown > 0.5  # what shows print in colours is not plain without
    assert fit.odds > 8.0
    crop = crop_of(grey, paint, TRUE, FINE)
    its = fit_of(crop, Paint(replace(cube(), texture=print_of(seed=77))), TRUE)
    assert its.correlation < 0.5 * fit.correlation
    assert its.odds < fit.odds - 8.0


def test_a_plain_cube_is_told_by_its_outline_and_creases(photo):
    """In clutter, where outlines beside it have edges by chance, the same is worth less."""
    grey = Paint(replace(cube(), texture=np.full_like(cube().texture, 150)))
    crop = crop_of(photo, grey, TRUE, FINE)
    fit, off_it = (fit_of(crop, grey, pose, whole=True) for pose in (TRUE, disturbed(grey, (25, 0, 10))))
    assert printed(fit) == 0.0
    assert fit.creases > 2.0 * off_it.creases
    assert fit.odds > 5.0 > off_it.odds
    rng = np.random.default_rng(2)
    image = photo.image.copy()
    for x, y in rng.integers(0, (CAMERA.width, CAMERA.height), (400, 2)):
        cv2.line(image, (int(x), int(y)), (int(x) + 30, int(y) + int(rng.integers(-30, 30))), (0, 0, 0), 2)
    own = grey.drawn(TRUE, CAMERA.K, (CAMERA.width, CAMERA.height)).mask
    image[own] = photo.image[own]
    cluttered = fit_of(crop_of(Photo(image, CAMERA), grey, TRUE, FINE), grey, TRUE, whole=True)
    assert cluttered.odds < fit.odds


def test_only_a_whole_fit_has_what_its_odds_are_of(paint, photo):
    crop = crop_of(photo, paint, TRUE, FINE)
    part, whole = (fit_of(crop, paint, TRUE, whole=some) for some in (False, True))
    assert part.score == whole.score
    assert part.creases == part.quiet == part.length == 0.0
    assert whole.creases != 0.0
    assert whole.quiet != 0.0


def test_what_is_before_it_tells_nothing_against_it(paint):
    """Half of the cube is behind another one: with that known, the pose fits, and more so than without."""
    near = pose_towards(CORNER, 0.45, 0.3, (0.10, 0.0))
    photo = Photo(picture([TRUE, near], seed=4), CAMERA)
    surface = Surface(paint.mesh.vertices, paint.mesh.triangles)
    told, untold = (
        fit_of(crop_of(photo, paint, TRUE, FINE, before), paint, TRUE) for before in ([(surface.rays, near)], [])
    )
    assert told.visible < 0.8 < untold.visible
    assert told.edges > untold.edges
    assert told.correlation > untold.correlation
    assert told.odds > 5.0


@pytest.mark.parametrize("wrong", [0.0, 0.03])
def test_what_contact_holds_elsewhere_leaves_it_when_it_is_released(paint, photo, wrong):
    """On the plane that the cube stands on it stays; from one that is 3 % farther it comes back, and is told there."""
    faces = resting_faces(paint.mesh.vertices)
    ups, offsets = faces.planes(TRUE)
    k = int(np.argmax(offsets))
    plane = Plane(ups[k], float(offsets[k] * (1.0 + wrong)))
    contact = Contact(Known(plane, np.zeros((3, 3)), Noise(0.02, 0.0005)), faces)
    found = refined(photo, paint, TRUE, contact=contact)
    assert found.released is not None
    assert off(paint, found.released) < 0.02
    assert off(paint, found.pose) < 0.02
    assert wrong == 0.0 or found.pose is found.released


def test_light_and_white_balance_change_little(paint, photo):
    """A gain and an offset for each channel, and a shade across the picture."""
    shade = np.linspace(0.6, 1.1, CAMERA.width)[None, :, None]
    image = np.clip(photo.image * shade * [0.8, 1.0, 1.15] + 8.0, 0, 255).astype(np.uint8)
    pose, fit, hopeless, *_ = refined(Photo(image, CAMERA), paint, disturbed(paint, (0, 0, 0), (0, 0, 0.03)))
    assert off(paint, pose) < 0.02
    assert fit.odds > 8.0
    assert not hopeless


def test_the_same_input_gives_the_same_pose(photo):
    one, two = (refined(photo, Paint(cube()), disturbed(Paint(cube()), (5, 0, 0))) for _ in range(2))
    assert np.array_equal(one[0], two[0])
    assert one[1] == two[1]


def test_a_lens_is_taken_out(paint, photo):
    """The part of a distorted photo is that of OpenCV's undistorted one."""
    lens = np.array([-0.25, 0.06, 0.001, -0.002, 0.0])
    size = (CAMERA.width, CAMERA.height)
    ideal = Camera(*size, CAMERA.K)
    bent = Camera(*size, CAMERA.K, lens)
    grid = np.stack(np.meshgrid(np.arange(size[0]), np.arange(size[1])), -1).astype(float)
    rays = np.concatenate([bent.normalised(grid), np.ones((*grid.shape[:2], 1))], axis=-1)
    at = ideal.project(rays).astype(np.float32)
    distorted = cv2.remap(photo.image, at[..., 0], at[..., 1], cv2.INTER_CUBIC, borderMode=cv2.BORDER_REPLICATE)
    straight = cv2.undistort(distorted, CAMERA.K, lens)
    one = crop_of(Photo(distorted, bent), paint, TRUE, FINE)
    two = crop_of(Photo(straight, ideal), paint, TRUE, FINE)
    assert np.abs(one.lab - two.lab).mean() < 0.5
    pose, *_ = refined(Photo(distorted, bent), paint, disturbed(paint, (0, 0, 0), (0, 0, 0.03)))
    assert off(paint, pose) < 0.02


def test_out_of_sight_there_is_nothing_to_say(paint, photo):
    aside = disturbed(paint, (0, 0, 0), (3.0, 0, 0))
    behind = disturbed(paint, (0, 0, 0), (0, 0, -1.2))
    assert refined(photo, paint, aside) is None
    assert refined(photo, paint, behind) is None
    assert fit_of(crop_of(photo, paint, TRUE, FINE), paint, aside) == NO_FIT


def test_a_step_turns_about_the_middle(paint):
    step = np.array([0.1, -0.2, 0.3, 0.01, 0.02, -0.03])
    pose = moved(TRUE, paint.middle, step)
    middle = transform_points(TRUE, paint.middle[None])[0]
    assert transform_points(pose, paint.middle[None])[0] == pytest.approx(middle + step[3:])
    assert pose[:3, :3] @ TRUE[:3, :3].T == pytest.approx(Rotation.from_rotvec(step[:3]).as_matrix())
    assert moved(TRUE, paint.middle, np.zeros(6)) == pytest.approx(TRUE)


def test_starts_lie_about_the_pose_and_equal_ones_are_one(paint):
    starts = starts_about(TRUE, paint)
    assert len(different(starts, paint)) == len(starts) == 7
    assert len(different([TRUE, starts[0], TRUE, starts[1]], paint)) == 2
    depths = sorted(transform_points(start, paint.middle[None])[0, 2] for start in starts)
    assert depths[-1] / depths[0] == pytest.approx(1.06 / 0.94)


def test_half_turns_keep_the_middle_and_twice_they_are_none(paint):
    every = half_turns(TRUE, paint)
    assert len(different([TRUE, *every], paint)) == 4
    for k, pose in enumerate(every):
        assert transform_points(pose, paint.middle[None]) == pytest.approx(transform_points(TRUE, paint.middle[None]))
        assert half_turns(pose, paint)[k] == pytest.approx(TRUE, abs=1e-9)


def test_drawn_depth_is_that_of_rays_and_outside_there_is_none(paint):
    """Oracle: the cube's own ray structure, asked pixel by pixel."""
    drawn = paint.drawn(TRUE, CAMERA.K, (CAMERA.width, CAMERA.height))
    v, u = np.nonzero(drawn.mask)
    some = np.random.default_rng(1).choice(len(u), 200, replace=False)
    rays = CAMERA.rays(np.column_stack([u, v])[some])
    object_from_camera = inverse(TRUE)
    surface = Surface(paint.mesh.vertices, paint.mesh.triangles)
    far = surface.rays.first_hit(object_from_camera[:3, 3][None], rays @ object_from_camera[:3, :3].T)
    assert drawn.depth[v, u][some] == pytest.approx(far * rays[:, 2], rel=1e-6)
    box = paint.box(TRUE, CAMERA.K)
    assert u.min() >= box[0, 0] - 1
    assert u.max() <= box[1, 0] + 1
    assert np.isinf(drawn.depth[0, 0])
    assert not drawn.colour[0, 0].any()
