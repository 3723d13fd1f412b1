"""``plogic perceive FRAME... --poses FILE``: a sequence of views with known camera motion to a panorama."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from time import monotonic
from typing import TYPE_CHECKING, Any

from geometry.errors import PlogicError
from plogic.base.errors import InputError
from plogic.face.commands.perceive_command import UNFINISHED, places, tell_unchecked
from plogic.facts.situation import stopped_in
from plogic.run.sources import gamma_of, image_of, is_gamma, kb_of
from plogic.scene.readings.unfinished import REASONS

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence

    from numpy.typing import NDArray

    from geometry.files.pose_files import Placed
    from plogic.sequence.views.panorama import Look, Panorama
    from plogic.sequence.views.standing import View

ONE_ONLY = ("report", "picture")
"""What is made of one frame."""


def sequence_command(
    frames: Sequence[str],
    kb_folder: str,
    out: str,
    options: Mapping[str, Any],
    *,
    say: Callable[[str], None],
    write: Callable[[str], None],
) -> int:
    """Read, interpret frame after frame, write; returns the exit status. A line a frame on ``say``.

    Where a frame cannot be read, what was made of those before it is written first. Raises InputError, CameraError and
    the like.
    """
    from plogic.base.jobs import processors
    from plogic.base.remembered import cache_folder
    from plogic.cycle.delta import Options
    from plogic.facts.interpretation import text_of
    from plogic.run.perceive import Perceiver
    from plogic.sequence.views.panorama import Panorama, ahead, panorama_document
    from sensing.files.whole_files import check_places, write_files

    _check(options)
    check_places(places(out, options))
    kb = kb_of(kb_folder)
    tell_unchecked(kb, say)
    poses, foreseen = placed_frames(frames, options.get("poses"))
    if options.get("poses") is None and not all(is_gamma(frame) for frame in frames):
        say("all images are taken to be from the one place that --camera tells; where the camera moved, give --poses")
    perceiver = Perceiver(kb, cache_folder("indices"), processors(), options["generator"])
    end = monotonic() + options["deadline"] if options.get("deadline") else None
    panorama = Panorama(perceiver, Options(options["reading"], options["reconsider"], options["smoothing"], end))
    looks, failed = _looks(panorama, frames, poses, options, say)
    camera = looks[-1][1].view
    told = [ahead(panorama, _moved(camera, placed)) for placed in foreseen]
    text = text_of(panorama_document(panorama, looks, told))
    if out == "-":
        write(text)
    else:
        write_files({Path(out): text.encode()})
    if failed is not None:
        raise failed
    return UNFINISHED if any(look.interpretation.get("unfinished") for _, look in looks) else 0


def _looks(
    panorama: Panorama,
    frames: Sequence[str],
    poses: Sequence[Placed | None],
    options: Mapping[str, Any],
    say: Callable[[str], None],
) -> tuple[list[tuple[str, Look]], PlogicError | None]:
    """Frame after frame, up to one that cannot be used, and what is wrong with that; raised where it is the first."""
    looks: list[tuple[str, Look]] = []
    for number, (frame, pose) in enumerate(zip(frames, poses, strict=True), 1):
        try:
            look = _looked(panorama, frame, pose, number, options)
        except PlogicError as error:
            if not looks:
                raise
            say(f"v{number} {frame}: cannot be used; what is written is of the {len(looks)} before it")
            return looks, error
        looks.append((frame, look))
        say(_summary(frame, look, panorama))
    return looks, None


def _check(options: Mapping[str, Any]) -> None:
    for key in (*ONE_ONLY, "timings"):
        if options.get(key):
            raise InputError(f"--{key}: is made of one frame; give one INPUT, or leave it out")


def placed_frames(frames: Sequence[str], poses: str | None) -> tuple[list[Placed | None], list[Placed]]:
    """The pose of each frame, None where its own file must tell it, and the poses at which there is no frame, where all that is known is told.

    A pose is a frame's if it bears its name, or the end of its path; where none bears any, the first is the first
    frame's, and so on. Raises InputError or CameraError.
    """
    if poses is None:
        return [None] * len(frames), []
    from geometry.files.pose_files import read_poses

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


def _looked(panorama: Panorama, frame: str, placed: Placed | None, number: int, options: Mapping[str, Any]) -> Look:
    from plogic.base.clock import Stopwatch
    from plogic.sequence.views.standing import View

    picture: NDArray[Any] | None = None if is_gamma(frame) else image_of(frame, options.get("camera"))
    gamma, image = gamma_of(frame, picture, options.get("camera"), panorama.perceiver.kb, Stopwatch())
    pose = gamma.camera.world_from_camera if placed is None else placed.world_from_camera
    if pose is None:
        raise InputError(
            f"{frame}: where its camera stood is not known: give --poses FILE, or T_world_camera in the Γ's camera"
        )
    there = replace(gamma, camera=replace(gamma.camera, world_from_camera=pose))  # one camera file serves all frames
    return panorama.look(View(f"v{number}", there, pose), image)


def _moved(view: View, placed: Placed) -> View:
    """The last view's camera elsewhere."""
    from plogic.sequence.views.standing import View

    return View("ahead", view.gamma, placed.world_from_camera)


def _summary(frame: str, look: Look, panorama: Panorama) -> str:
    """One line: what was recalled, what was found, what is known now."""
    events = [step["event"] for step in look.interpretation["trace"]]
    told = [f"{events.count('recall')} recalled"] * ("recall" in events) + ["no search"] * ("no search" in events)
    stopped = stopped_in(look.interpretation)
    told += [REASONS[stopped]] if stopped else []
    told += [f"gone: {', '.join(look.gone)}"] * bool(look.gone)
    known = ", ".join(
        f"{k.id} {k.standing.object_type.name} ({k.probability:.3f}{f', {k.age} views ago' if k.age else ''})"
        for k in panorama.known
    )
    return f"{look.view.id} {frame}: {len(look.view.gamma.appearances)} appearances; {'; '.join([*told, known or 'no known object'])}"
