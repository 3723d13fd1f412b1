"""``plogic perceive``: an image or Γ, or a calibrated pair, to an interpretation; several views to a panorama.

A video's frames are such views.

A pair gives the interpretation of one notional viewpoint, the left camera's (§3.3). Nothing is written where something
is wrong with the input.
"""

import json
import sys
from collections.abc import Callable, Sequence
from dataclasses import replace
from itertools import chain
from pathlib import Path
from shlex import quote
from time import monotonic
from typing import TYPE_CHECKING, Any

from numpy.typing import NDArray

from geometry.camera import Camera
from geometry.errors import PlogicError
from geometry.files.plain_files import name_of
from geometry.files.pose_files import Placed, read_poses
from kb.clouds.cloud import KnowledgeBase
from kb.files.folder import parts_of
from plogic.base.clock import Stopwatch
from plogic.base.errors import InputError
from plogic.cycle.delta import Options
from plogic.face.shown.options import Marks, Perceiving
from plogic.face.shown.printed import written
from plogic.face.shown.progress import beating
from plogic.facts.caveats import caveats
from plogic.facts.document import Interpretation
from plogic.facts.interpretation import text_of
from plogic.facts.situation import stopped_in
from plogic.run.cameras import GivenCamera, Shot, camera_beside, image_by, shot_of
from plogic.run.document import place_of, placed_in, surpassed
from plogic.run.perceive import perceiver_of
from plogic.run.silence.beforehand import beforehand
from plogic.run.sources import detected, gamma_of, is_gamma, kb_of
from plogic.run.video.video import is_video
from plogic.run.video.views import Input, views_in
from plogic.scene.readings.unfinished import REASONS
from plogic.scene.worlds.predictions import Doubt, said
from sensing.appearance import Gamma
from sensing.files.gamma_files import read_gamma
from sensing.files.whole_files import check_places, write_files
from sensing.simulated.physics import INSTALL, NO_PHYSICS, has_physics

if TYPE_CHECKING:
    from plogic.sequence.views.panorama import Look, Panorama


Say = Callable[[str], None]


ON_STDOUT = "-", ""
"""Where no file is named: the document; or, on a terminal, for which it is no text, its worlds alone."""
HOW = "the whole interpretation (JSON): -o FILE, or a pipe behind this command, or -o -"
UNFINISHED = 3
"""Exit status: the deadline was reached, with the best answer so far printed and marked."""


def perceive_command(inputs: Sequence[str], options: Perceiving, *, say: Say, write: Say) -> int:
    """Read, interpret, write; returns the exit status. ``say``: what people are told; ``write``: stdout.

    Raises:
        InputError, CameraError and the like: what is wrong with the input.
    """
    if not options.out and not sys.stdout.isatty():
        options = replace(options, out="-")
    clock = Stopwatch()
    with beating(lambda: clock.here or ("asking why" if "document" in clock.seconds else "perceiving")) as above:
        say, write = above(say), above(write)
        if options.stereo is not None:
            return _of_pair(inputs, options, options.stereo, clock, say, write)
        if len(inputs) == 1 and options.poses is None and not is_video(inputs[0]):
            return _of_one(inputs[0], options, clock, say, write)
        return _of_sequence(inputs, options, clock, say, write)


def _of_one(source: str, options: Perceiving, clock: Stopwatch, say: Say, write: Say) -> int:
    _check_places(options, [source])
    with clock.stage("read"):
        kb = kb_of(options.kb)
        shot = None if is_gamma(source) else shot_of(source, options.camera)
    if shot is None and options.camera.named:
        say(f"{name_of(source)}: a Γ has a camera of its own: {options.camera.named[0]} is not used")
    for note in shot.notes if shot else ():
        say(f"{source}: {note}")
    gamma, image = gamma_of(source, shot, kb, clock)
    _tell_of(kb, options.kb, say)
    with clock.stage("index"):
        perceiver = perceiver_of(kb, options.generator)
    document = perceiver(gamma, _chosen(options), image, clock)
    if options.deadline is None and document["doubts"]:
        from plogic.sequence.unposed.reading import doubts_weighed

        with clock.stage("doubts"):
            document = doubts_weighed(document)
    status = _write_all(document, options, image, clock, write)
    amiss = surpassed(document).values(), caveats(document), _impossible(document), _doubts(document)
    for line in (*_silence(document, gamma, kb), *_summary(document, clock), *chain(*amiss)):
        say(line)
    return status


def _of_pair(inputs: Sequence[str], options: Perceiving, stereo: str, clock: Stopwatch, say: Say, write: Say) -> int:
    from plogic.sequence.views.standing import sharpened
    from sensing.files.stereo import fused, read_stereo

    if len(inputs) != 2 or options.poses:
        raise InputError("--stereo: takes two INPUTs, the left and the right one, and no --poses")
    if options.camera.named:
        raise InputError(f"{options.camera.named[0]}: --stereo tells both cameras; leave one of the two out")
    if any(map(is_video, inputs)):
        raise InputError("--stereo: takes pictures or Γ, and no video")
    _check_places(options, inputs)
    kb = kb_of(options.kb)
    calibration = read_stereo(stereo)
    cameras = calibration.left, calibration.right
    (left, image), (right, _) = (
        _side(source, camera, stereo, kb, clock) for source, camera in zip(inputs, cameras, strict=True)
    )
    gamma = fused(left, right, calibration.pair, kb.rates.sigma)
    _tell_of(kb, options.kb, say)
    perceiver, chosen = perceiver_of(kb, options.generator), _chosen(options)
    data, cycle = perceiver.cycle(gamma, chosen, clock)
    with clock.stage("both images"):
        cycle = sharpened(cycle, gamma, data, right, calibration.pair, perceiver)
    document = perceiver.document(gamma, data, cycle, chosen, image, clock)
    status = _write_all(document, options, image, clock, write)
    deep = sum(a.depth is not None for a in gamma.appearances)
    say(f"{len(right.appearances)} appearances in the right image; {deep} of the left one's have depth")
    amiss = surpassed(document).values(), caveats(document)
    for line in (*_silence(document, gamma, kb), *_summary(document, clock), *chain(*amiss)):
        say(line)
    return status


def _side(
    source: str, camera: Camera | None, stereo: str, kb: KnowledgeBase, clock: Stopwatch
) -> tuple[Gamma, NDArray[Any] | None]:
    """One side of a pair: Γ from its file, or detected in the picture."""
    if is_gamma(source):
        return read_gamma(source, kb.appearance_types), None
    if camera is None:
        raise InputError(f"{source}: an image needs its camera: {stereo} must have left and right")
    picture = image_by(camera, source, stereo)
    return detected(picture, camera, kb, clock), picture


def _chosen(options: Perceiving) -> Options:
    """The options of the cycle; its deadline is counted from now on."""
    end = monotonic() + options.deadline if options.deadline else None
    return Options(options.reading, options.reconsider, options.smoothing, end, options.dv_over)


def _tell_of(kb: KnowledgeBase, folder: str, say: Say) -> None:
    """Say what of Σ is never found, what of it is no solid, and which part cannot be checked on this machine."""
    for line in beforehand(kb, folder):
        say(line)
    if kb.gravity and not has_physics():
        say(f"who holds whom is not checked, for {NO_PHYSICS}: {INSTALL}")


def _check_places(options: Perceiving, inputs: Sequence[str]) -> None:
    """Raise InputError where a file that will be written is named twice, SensingError where none can be, or is read."""
    named = [Path(path) for path in (options.report, options.picture, options.timings) if path]
    if Path("-") in named:
        raise InputError("-: standard output is the interpretation's; name a file for the page, picture or timings")
    named += [Path(options.out)] * (options.out not in ON_STDOUT)
    for path in named:
        if named.count(path) > 1:
            raise InputError(f"{path}: is named for two outputs")
    check_places(named, [*inputs, options.camera.file, options.poses, options.stereo, *parts_of(options.kb)])


def _write_all(
    document: Interpretation, options: Perceiving, image: NDArray[Any] | None, clock: Stopwatch, write: Say
) -> int:
    """Write what was found, and give the exit status.

    Everything is made first, then written: a failure leaves nothing half done.
    """
    text, files = text_of(document), dict[Path, bytes]()
    if options.report:
        from plogic.face.pages.one_file import page

        files[Path(options.report)] = page(document).encode()
    if options.picture:
        files[Path(options.picture)] = picture_of(document, image, options.marks)
    if options.timings:
        timings = {"format": "timings/1", "seconds": clock.seconds, "total": clock.total}
        files[Path(options.timings)] = json.dumps(timings, indent=1).encode()
    if options.out not in ON_STDOUT:
        files[Path(options.out)] = text.encode()
    write_files(files)
    if options.out in ON_STDOUT:
        write(text if options.out else f"{_worlds(document)}\n{HOW}")
    return UNFINISHED if document.get("unfinished") else 0


def _worlds(document: Interpretation) -> str:
    """The ranked worlds for people."""
    from plogic.face.shown.tables import text_of_table, worlds

    return text_of_table(worlds(document)).rstrip()


def picture_of(document: Interpretation, image: NDArray[Any] | None, marks: Marks = "few") -> bytes:
    """The overlay of figure 5 as PNG; ``image`` (H, W, 3) uint8, blue first; ``marks`` as ``overlay`` takes them."""
    import cv2

    from plogic.face.shown.overlay import overlay

    return bytes(cv2.imencode(".png", overlay(document, image, marks))[1].tobytes())


def _doubts(document: Interpretation) -> list[str]:
    """What the relations of accepted objects predict in vain (§3.8); of others the document says it."""
    accepted = {h["id"] for h in document["hypotheses"] if h["status"] == "accepted"}
    return [said(Doubt.of(row)) for row in document["doubts"] if set(row["args"]) <= accepted]


def _impossible(document: Interpretation) -> list[str]:
    """A line for each accepted hypothesis that no possible world holds."""
    return [
        f"{h['id']} {h['type']}: {h.get('why')}"
        for h in document["hypotheses"]
        if h["status"] == "accepted" and h["probability"] == 0.0
    ]


def _silence(document: Interpretation, gamma: Gamma, kb: KnowledgeBase) -> list[str]:
    """Why an answer is empty; nothing of one that is not, or that a deadline left so."""
    if stopped_in(document) or any(h["status"] != "rejected" for h in document["hypotheses"]):
        return []
    from plogic.run.silence.causes import why_nothing

    return why_nothing(document, gamma, kb)


def _summary(document: Interpretation, clock: Stopwatch) -> list[str]:
    """How much was found, whether that is all, and how long it took; then a line an object, with its place."""
    stopped, placed = stopped_in(document), placed_in(document)
    found = f"{len(placed)} object{'s' * (len(placed) > 1)}" if placed else "no known object"
    found = f"{found}; {REASONS[stopped]}" if stopped else found
    stages = ", ".join(f"{name} {seconds * 1000:.0f} ms" for name, seconds in clock.seconds.items())
    return [f"{len(document['appearances'])} appearances; {found}; {stages}", *placed]


def _of_sequence(inputs: Sequence[str], options: Perceiving, clock: Stopwatch, say: Say, write: Say) -> int:
    """Interpret frame after frame, with a line each on ``say``.

    Where a frame cannot be read, what was made of those before it is written first.
    """
    from plogic.logic.safety.author import observes
    from plogic.sequence.constancy.sight_lines import View
    from plogic.sequence.views.panorama import Panorama, ahead, panorama_document

    if options.dv_over != "types":
        raise InputError("--dv-over instances: is of one image; give one INPUT, or leave it out")
    for key in ("report", "picture", "timings"):
        if getattr(options, key):
            raise InputError(f"--{key}: is made of one frame; give one INPUT, or leave it out")
    _check_places(options, inputs)
    kb = kb_of(options.kb)
    _tell_of(kb, options.kb, say)
    if observes(kb.rules):
        say(
            "rules.pl: over several views it counts who is present; relations are of one view, and are not told to rules"
        )
    frames = views_in(inputs, options.every)
    poses, foreseen = _placed_frames([frame.name for frame in frames if frame.fault is None], options.poses)
    in_turn = iter(poses)
    poses = [None if frame.fault is not None else next(in_turn) for frame in frames]
    images = [frame.name for frame in frames if not is_gamma(frame.name)]
    tells = {camera_beside(name, options.camera).file for name in images}
    if options.poses is None and len(images) > len(tells) and tells != {None}:
        by = "--camera" if options.camera.file else " and ".join(sorted(filter(None, tells)))
        say(f"all images are taken to be from the one place that {by} tells; where the camera moved, give --poses")
    panorama = Panorama(perceiver_of(kb, options.generator), _chosen(options))
    looks, failed = _looks(panorama, list(zip(frames, poses, strict=True)), options.camera, clock, say)
    last = looks[-1][1].view.gamma
    told = [ahead(panorama, View("ahead", last, placed.world_from_camera)) for placed in foreseen]
    text = text_of(panorama_document(panorama, looks, told))
    written(text, options.out or "-", say=lambda _: None, write=lambda text: write(text if options.out else HOW))
    if failed is not None:
        raise failed
    return UNFINISHED if any(look.interpretation.get("unfinished") for _, look in looks) else 0


def _looks(
    panorama: "Panorama",
    frames: Sequence[tuple[Input, Placed | None]],
    camera: GivenCamera,
    clock: Stopwatch,
    say: Say,
) -> "tuple[list[tuple[str, Look]], PlogicError | None]":
    """Frame after frame, up to one that cannot be used, and what is wrong with that; raised where it is the first."""
    looks: list[tuple[str, Look]] = []
    told = set[str]()  # notes of a camera: what is true of many frames is said of the first
    for number, (frame, pose) in enumerate(frames, 1):
        try:
            shot = None if frame.video is None and is_gamma(frame.name) else frame.shot(camera)
            for note in shot.notes if shot else ():
                if note not in told:
                    say(f"{frame.name}: {note}")
                    told.add(note)
            clock.inner = Stopwatch()
            with clock.stage(f"view {number} of {len(frames)}"):
                look = _looked(panorama, frame, shot, pose, f"v{number}", clock.inner)
        except PlogicError as error:
            if not looks:
                raise
            say(f"v{number} {frame.name}: cannot be used; what is written is of the {len(looks)} before it")
            return looks, error
        looks.append((frame.name, look))
        say(_line(frame.name, look, panorama))
        doubt = look.interpretation.get("camera_doubt")
        if doubt is not None and not any("camera_doubt" in earlier.interpretation for _, earlier in looks[:-1]):
            say(f"{frame.name}: {doubt['why']}")
    return looks, None


def _placed_frames(frames: Sequence[str], poses: str | None) -> tuple[list[Placed | None], list[Placed]]:
    """The pose of each frame, None where its own file must tell it, and the poses without a frame, if all is known.

    A pose is a frame's if it bears its name, or the end of its path; where none bears any, the first is the first
    frame's, and so on. Raises InputError or CameraError.
    """
    if poses is None:
        return [None] * len(frames), []
    listed = read_poses(poses)
    named = [placed for placed in listed if placed.frame is not None]
    foreseen = [placed for placed in listed if placed.frame is None]
    found = [_named(frame, named) for frame in frames]
    if not any(found) and len(named) == len(frames):
        return list(named), foreseen
    lost = [
        f"{frame}: {poses} has no pose of this name" for frame, one in zip(frames, found, strict=True) if one is None
    ]
    if lost:
        raise InputError("\n".join(lost))
    return found, foreseen


def _named(frame: str, poses: Sequence[Placed]) -> Placed | None:
    """The one pose of this name; of the longest common end of the path where there are several."""
    parts = Path(frame).parts
    fit = [
        (len(own), placed) for placed in poses if (own := Path(str(placed.frame)).parts) and parts[-len(own) :] == own
    ]
    return max(fit, key=lambda pair: pair[0])[1] if fit else None


def _looked(
    panorama: "Panorama", frame: Input, shot: Shot | None, placed: Placed | None, name: str, clock: Stopwatch
) -> "Look":
    from plogic.sequence.constancy.sight_lines import View

    gamma, image = gamma_of(frame.name, shot, panorama.perceiver.kb, clock)
    pose = gamma.camera.world_from_camera if placed is None else placed.world_from_camera
    if pose is None:
        alone = (
            f"; or take each frame by itself: plogic batch {quote(str(frame.video))}" if frame.video is not None else ""
        )
        raise InputError(
            f"{frame.name}: where its camera stood is not known: give --poses FILE, or T_world_camera in its camera{alone}"
        )
    there = replace(gamma, camera=replace(gamma.camera, world_from_camera=pose))  # one camera file serves all frames
    return panorama.look(View(name, there, pose), image, clock)


def _ago(views: int) -> str:
    return f", {views} view{'s' * (views > 1)} ago" if views else ""


def _line(frame: str, look: "Look", panorama: "Panorama") -> str:
    """One line: what was recalled, what was found, what is known now and where it is in this view's camera frame."""
    events = [step["event"] for step in look.interpretation["trace"]]
    told = [f"{events.count('recall')} recalled"] * ("recall" in events) + ["no search"] * ("no search" in events)
    stopped = stopped_in(look.interpretation)
    told += [REASONS[stopped]] if stopped else []
    told += [f"gone: {', '.join(look.gone)}"] * bool(look.gone)
    known = [
        f"{k.id} {k.standing.object_type.name} ({k.probability:.3f}{_ago(k.age)})"
        f" {place_of(k.standing.before(look.view).tolist())}"
        for k in panorama.known
    ]
    seen = f"{look.view.id} {frame}: {len(look.view.gamma.appearances)} appearances"
    return f"{seen}; {'; '.join([*told, *(known or ['no known object'])])}"
