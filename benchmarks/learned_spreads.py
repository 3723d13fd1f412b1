"""Measure what is right and what is clutter in scenes.

What the constants of a learned type's likelihood stand on, each beside its figure.

Run as ``python benchmarks/learned_spreads.py KB [--seeds FIRST..LAST]``, KB being a folder with the types of ``plogic
bench recognition``, learned. The scenes are of its kind; their numbers are 5000 and more, for those below are the
benchmark's. Types are put where they are (*right*) and where they are not (*wrong*); ``learned_seen.py`` says what is
seen there.
"""

from __future__ import annotations

import argparse
import tempfile
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, cast

import numpy as np

from benchmarks.learned_seen import Seen, look, worths
from benchmarks.recognition import scenes
from benchmarks.tabletop.scene import recognition_scene
from geometry.frames import transform_points
from kb.files.read import read_kb
from plogic.match.gamma import side_looks
from plogic.match.gamma.data import data_of
from plogic.match.learned import agreement, sides
from plogic.match.learned import learned_match as looks
from plogic.match.learned import learned_poses as generate
from plogic.measures import crowding
from plogic.run.perceive import Perceiver
from sensing.detectors.detector import detect
from sensing.files.images import read_image
from sensing.simulated.body import read_mesh

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator
    from types import ModuleType

    from numpy.typing import NDArray

    from benchmarks.recognition.scenes import Case
    from benchmarks.recognition.score import Truth
    from kb.clouds.cloud import KnowledgeBase
    from plogic.match.learned.learned_models import LearnedIndex, LearnedModels

    Floats = NDArray[np.float64]

FIRST_SEED = 5000
"""Of scenes for development: no benchmark's are among them."""
SHOWN = 0.85
"""Visible fraction from which a right pose is looked at: what another object hides would be missed for no fault of the
constants."""
WRONG = 3
"""Wrong poses that are tried for each right one."""
FEWEST = 30
"""Matches from which a spread is told."""
SURPRISE = 6.0
"""Logarithm of the greatest likelihood ratio of one feature that counts in a mean, lest one alone decide it."""


def main(folder: str, first: int, last: int) -> None:
    """Print all figures."""
    kb = read_kb(folder)
    perceiver, right, wrong = Perceiver(kb), Seen(), Seen()
    worth: dict[bool, list[float]] = {True: [], False: []}
    indices = cast("LearnedModels", perceiver.models.kinds["learned"]).models
    for case in shown(kb, first, last):
        gamma = detect(read_image(case.image), case.camera, kb.sought, kb.words)
        data, rng = data_of(gamma.appearances, case.camera, perceiver.width), np.random.default_rng(case.seed)
        for truth in case.truths:
            if truth.fraction >= SHOWN and truth.type in indices:
                look(right, indices[truth.type], truth.camera_from_object, data, kb, true=True)
                for pose in aside(indices[truth.type], truth, case, rng):
                    look(wrong, indices[truth.type], pose, data, kb, true=False)
        for name, index in indices.items():
            for is_right, value in worths(index, data, kb, [t for t in case.truths if t.type == name]):
                worth[is_right].append(value)
    if not right.poses or not wrong.poses:
        raise SystemExit(f"scenes {first}..{last} show no object of {folder} by {SHOWN:.0%} and more")
    right_ones = f"{right.poses} right poses of objects shown by {SHOWN:.0%} and more"
    print(f"scenes {first}..{last}: {right_ones}, {wrong.poses} wrong ones")  # noqa: T201 - a script
    for lines in (
        keypoint_lines(right, wrong),
        side_lines(right, wrong),
        linked_lines(right, wrong),
        worth_lines(worth),
    ):
        print("\n".join(lines))  # noqa: T201


def shown(kb: KnowledgeBase, first: int, last: int) -> Iterator[Case]:
    """Scenes by their numbers, as the benchmark would render them.

    Objects bear the KB's names of them, with or without YCB's number.
    """
    names = {kind.name.lstrip("0123456789_"): kind.name for kind in kb.types}
    shapes = [(names.get(name, name), read_mesh(mesh)) for name, mesh in scenes.ycb_meshes().items()]
    turns = {
        name: scenes.half_turns(mesh.vertices) for name, mesh in shapes if name.lstrip("0123456789_") in scenes.BOXES
    }
    with tempfile.TemporaryDirectory(prefix="plogic-spreads-") as folder:
        for number in range(first, last + 1):
            i = number % scenes.SCENES
            empty, hard = (
                i % scenes.EMPTY_EVERY == scenes.EMPTY_EVERY - 1,
                scenes.HARD[(i + i // scenes.EMPTY_EVERY) % len(scenes.HARD)],
            )
            scene = recognition_scene(shapes, number, empty=empty, hard=hard)
            yield scenes.case(scene, Path(folder) / f"{number}", number, hard, turns)


def aside(index: LearnedIndex, truth: Truth, case: Case, rng: np.random.Generator) -> list[Floats]:
    """Wrong poses (4, 4), as far away, turned in the image, where nothing of the type is nearer than its diameter."""
    camera, z = case.camera, truth.camera_from_object[2, 3]
    there = np.array(
        [transform_points(t.camera_from_object, index.centre[None])[0] for t in case.truths if t.type == truth.type]
    )
    result: list[Floats] = []
    for _ in range(100):
        roll, (x, y) = (
            rng.uniform(0.0, 2.0 * np.pi),
            rng.uniform(-0.4, 0.4, 2) * (camera.width, camera.height) / camera.f * z,
        )
        pose = truth.camera_from_object.copy()
        pose[:2, :3] = np.array([[np.cos(roll), -np.sin(roll)], [np.sin(roll), np.cos(roll)]]) @ pose[:2, :3]
        pose[:3, 3] = np.array([x, y, z]) - pose[:3, :3] @ index.centre
        if np.linalg.norm(there[:, :2] / there[:, 2:] - np.array([x, y]) / z, axis=1).min() * z > index.diameter:
            result.append(pose)
        if len(result) == WRONG:
            break
    return result


def fitted(own: Callable[[float], Floats], other: Floats, now: float, wild: float) -> tuple[float, float, float]:
    """Of N values the likeliest spread and the likeliest share of them that is as ``other`` (N,).

    And nats a value that ``now`` and ``wild`` lose.

    ``own``: spread to densities (N,). NaN where there are too few.
    """
    if len(other) < FEWEST:
        return np.nan, np.nan, np.nan
    shares, spreads = np.linspace(0.0, 0.9, 91), now * np.geomspace(0.2, 5.0, 81)
    says = np.array(
        [[float(np.log((1.0 - share) * near + share * other).mean()) for share in shares] for near in map(own, spreads)]
    )
    best = np.unravel_index(int(says.argmax()), says.shape)
    present = np.log((1.0 - wild) * own(now) + wild * other).mean()
    return float(spreads[best[0]]), float(shares[best[1]]), float(says.max() - present)


def bell(off: Floats, sigma: Floats | float) -> Floats:
    """(N,) normal density, and no less than 1e-12."""
    return np.asarray(np.exp(-0.5 * (off / sigma) ** 2) / (np.sqrt(2.0 * np.pi) * sigma) + 1e-12)


def line(module: ModuleType, name: str, measured: float, what: str) -> str:
    """One constant, its present value, what was measured for it, and what that is."""
    return row(f"{module.__name__.rpartition('.')[2]}.{name}", getattr(module, name), measured, what)


def row(name: str, now: float, measured: float, what: str) -> str:
    """A line of the table."""
    return f"{name:20} {now:8g} {measured:9.3f}  {what}"


def more(what: str) -> str:
    """A line that goes on with what the one before it says."""
    return f"{'':40}{what}"


def quantiles(values: Floats, percents: tuple[int, ...]) -> str:
    """``at 5, 50 %: 1.0 2.0``."""
    return (
        f"at {', '.join(map(str, percents))} %: {' '.join(f'{value:.1f}' for value in np.percentile(values, percents))}"
    )


def found_line(name: str, right: Seen, wrong: Seen, which: int) -> str:
    """How much was looked at: ``which`` is 0 of keypoints, 1 of sides."""
    (there, found), (its_there, its_found) = (
        seen.of("found").sum(axis=1).reshape(2, 2)[which] for seen in (right, wrong)
    )
    at_wrong = f"{its_found / its_there:.1%} of {its_there:.0f} at wrong ones"
    return f"{name}: found are {found / there:.1%} of {there:.0f} that are expected at right poses, {at_wrong}"


def keypoint_lines(right: Seen, wrong: Seen) -> list[str]:
    """Angle, size and descriptor of keypoints."""
    (turned, grown, apart), its = right.of("keypoints"), wrong.of("keypoints")
    lines = [found_line("keypoints", right, wrong, 0)]
    for name, off, clutter, most, what in (
        ("TURNS", turned, its[0], agreement.ANGLES, "radians that a right one is turned"),
        ("GROWTH", grown, its[1], agreement.SIZES, "logarithm by which the size of a right one is off"),
    ):
        sigma, share, loss = fitted(partial(bell, off), np.full(len(off), 0.5 / most), getattr(looks, name), looks.EVEN)
        lines.append(line(looks, name, sigma, f"{what}, standard deviation; now loses {loss:.3f} nats each"))
        lines.append(line(looks, "EVEN", share, f"share of them that is even; {spread_of(clutter, most)}"))
    pairs, fit, word, both = wrong.of("chance").sum(axis=1)
    return [
        *lines,
        line(
            looks,
            "POWER",
            power(its[2]),
            f"power by which clutter grows with the distance of descriptors; {its.shape[1]} of them",
        ),
        row("(right ones)", 1.0, power(apart), "the same of right ones"),
        line(
            looks,
            "BY_CHANCE",
            fit / pairs,
            f"share of {pairs:.0f} pairs at wrong poses that have a right angle and size",
        ),
        more(f"of those of one word {both / word:.3f}"),
        *gain_lines("keypoint gain", right, wrong),
    ]


def rms(values: Floats) -> float:
    """Root of the mean square."""
    return float(np.sqrt((values**2).mean()))


def spread_of(clutter: Floats, most: float) -> str:
    """The spread of clutter that is off by ``most`` at most, beside that which it has if it is even."""
    return f"clutter {rms(clutter):.3f}, were it even {most / np.sqrt(3.0):.3f}"


def power(shares: Floats) -> float:
    """Of N shares in (0, 1) the likeliest power p, where the part of them below a is a^p."""
    return float(-1.0 / np.log(np.maximum(shares, 1e-6)).mean())


def gain_lines(name: str, right: Seen, wrong: Seen) -> list[str]:
    """What features say by all of these constants together.

    The mean of a likelihood ratio over clutter is 1, if the model of clutter is right.
    """
    mine, its = right.of(name)[0], wrong.of(name)[0]
    mean = float(np.exp(np.minimum(its, SURPRISE)).mean())
    return [
        row(
            f"({name})",
            1.0,
            mean,
            f"mean likelihood ratio of {len(its)} features at wrong poses, if none is above e^{SURPRISE:g}",
        ),
        more(f"logarithm at right ones {mine.mean():.2f} in the mean, at wrong ones {its.mean():.2f}"),
    ]


def side_lines(right: Seen, wrong: Seen) -> list[str]:
    """Angle, colours and contrast of sides of edges."""
    (turned, colours, contrast, mean, varied, usual, fit), its = right.of("sides"), wrong.of("sides")
    clutter = its[:, its[1] < 1.0]
    if not len(turned) or not clutter.shape[1]:
        return [found_line("sides of edges", right, wrong, 1)]
    slope = float((clutter[1].mean() - colours.mean()) / clutter[1].var())

    def own(bright: float) -> Floats:
        spread = np.minimum(np.hypot(varied, bright), side_looks.EDGES)
        return bell(contrast - mean * (1.0 - (spread / side_looks.EDGES) ** 2), spread)

    facing, any_way, loss = fitted(
        partial(bell, turned), np.full(len(turned), 0.5 / sides.TURNED), sides.TURNS, sides.WILD
    )
    bright, wild, lost = fitted(own, usual, side_looks.BRIGHT, side_looks.WILD)
    return [
        found_line("sides of edges", right, wrong, 1),
        line(
            sides,
            "TURNS",
            facing,
            f"radians that a right one is turned, standard deviation; both lose {loss:.3f} nats each",
        ),
        line(sides, "WILD", any_way, f"share of them that is turned anyhow; {spread_of(clutter[0], sides.TURNED)}"),
        line(
            side_looks,
            "OFF",
            side_looks.OFF * float(np.quantile(colours, 0.95)),
            "bytes that colours of 95 % of right ones are off at most",
        ),
        more(f"within the limit are {np.mean(its[1] < 1.0):.0%} of the sides around that face so"),
        line(
            side_looks,
            "NEAREST",
            1.0 + slope * float(clutter[1].mean()),
            "right over clutter where colours are not off, by a straight line",
        ),
        line(side_looks, "LESS", slope, "by how much less that is where they are all the way off"),
        line(
            side_looks,
            "BRIGHT",
            bright,
            f"bytes that contrast is off besides how it varied when learned; with WILD loses {lost:.3f} nats each",
        ),
        line(side_looks, "WILD", wild, "share of right ones of any contrast"),
        line(side_looks, "EDGES", rms(mean), "bytes of contrast of what was learned, standard deviation"),
        row(
            "(looks_fit)",
            1.0,
            clutter[6].mean(),
            f"mean of that likelihood ratio over {clutter.shape[1]} of clutter of right colours",
        ),
        more(
            f"whose contrast has a standard deviation of {rms(clutter[2]):.1f} bytes; its logarithm at right ones {np.log(fit).mean():.2f}"
        ),
        *gain_lines("side gain", right, wrong),
    ]


def linked_lines(right: Seen, wrong: Seen) -> list[str]:
    """Correlation of being found, for each unit of closeness."""
    lines = [
        "pairs of expected features: correlation of being found, for each unit of closeness; and of those far apart"
    ]
    for name, seen in (("wrong", wrong), ("right", right)):
        points, sided = (
            (both / square, far / count) for both, square, far, count in seen.of("linked").sum(axis=1).reshape(2, 4)
        )
        lines.append(line(crowding, "LINKED", sided[0], f"with a side, at {name} poses; far apart {sided[1]:.3f}"))
        lines.append(row("(keypoints)", 1.0, points[0], f"of keypoints, at {name} poses; far apart {points[1]:.3f}"))
    return lines


def worth_lines(worth: dict[bool, list[float]]) -> list[str]:
    """What is given up before it is settled."""
    right, wrong = (np.array(worth[key] or [np.nan]) for key in (True, False))
    given_up = f"{np.mean(right < generate.WORTHLESS):.0%} of right ones and {np.mean(wrong < generate.WORTHLESS):.0%} of wrong ones"
    return [
        f"proposed poses: {len(right)} right, {len(wrong)} of types that are not there",
        line(generate, "WORTHLESS", right.min(), f"least worth of a right one; {given_up} have less than now"),
        more(f"right {quantiles(right, (1, 5, 25, 50))}"),
        more(f"wrong {quantiles(wrong, (25, 50, 75, 90, 99, 100))}"),
    ]


def seeds(text: str) -> tuple[int, int]:
    """``5000..5023`` as its ends. Raises ArgumentTypeError where it is none, or reaches below ``FIRST_SEED``."""
    first, _, last = text.partition("..")
    if not (first.isdecimal() and last.isdecimal() and int(first) <= int(last)):
        raise argparse.ArgumentTypeError(f"is to be FIRST..LAST, not {text}")
    if int(first) < FIRST_SEED:
        raise argparse.ArgumentTypeError(f"{first} is below {FIRST_SEED}: those scenes are the benchmark's")
    return int(first), int(last)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("kb", help="folder of a knowledge base with learned types")
    parser.add_argument(
        "--seeds",
        type=seeds,
        default=(FIRST_SEED, FIRST_SEED + 23),
        metavar="FIRST..LAST",
        help="scenes, 5000 and more",
    )
    arguments = parser.parse_args()
    main(arguments.kb, *arguments.seeds)
