"""``plogic perceive LEFT RIGHT --stereo FILE``: a calibrated pair to an interpretation of one notional viewpoint, the left camera's (§3.3)."""

from __future__ import annotations

from time import monotonic
from typing import TYPE_CHECKING, Any

from plogic.base.errors import InputError
from plogic.face.commands.perceive_command import UNFINISHED, places, summary, tell_unchecked, write_all
from plogic.run.sources import detected, is_gamma, kb_of

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence

    from numpy.typing import NDArray

    from geometry.camera import Camera
    from kb.clouds.cloud import KnowledgeBase
    from plogic.base.clock import Stopwatch
    from sensing.appearance import Gamma


def stereo_command(
    inputs: Sequence[str],
    kb_folder: str,
    out: str,
    options: Mapping[str, Any],
    *,
    say: Callable[[str], None],
    write: Callable[[str], None],
) -> int:
    """Read, interpret, write; returns the exit status. Nothing is written where something is wrong with the input."""
    from plogic.base.clock import Stopwatch
    from plogic.base.jobs import processors
    from plogic.base.remembered import cache_folder
    from plogic.cycle.delta import Options
    from plogic.facts.interpretation import text_of
    from plogic.run.perceive import Perceiver
    from plogic.sequence.views.standing import sharpened
    from sensing.files.stereo import fused, read_stereo
    from sensing.files.whole_files import check_places

    if len(inputs) != 2 or options.get("poses"):
        raise InputError("--stereo: takes two INPUTs, the left and the right one, and no --poses")
    check_places(places(out, options))
    clock = Stopwatch()
    kb = kb_of(kb_folder)
    tell_unchecked(kb, say)
    calibration = read_stereo(options["stereo"])
    cameras = calibration.left, calibration.right
    (left, image), (right, _) = (
        _read(source, camera, options, kb, clock) for source, camera in zip(inputs, cameras, strict=True)
    )
    gamma = fused(left, right, calibration.pair, kb.rates.sigma)
    perceiver = Perceiver(kb, cache_folder("indices"), processors(), options["generator"])
    end = monotonic() + options["deadline"] if options.get("deadline") else None
    chosen = Options(options["reading"], options["reconsider"], options["smoothing"], end)
    data, cycle = perceiver.cycle(gamma, chosen, clock)
    with clock.stage("both images"):
        cycle = sharpened(cycle, gamma, data, right, calibration.pair, perceiver)
    document = perceiver.document(gamma, data, cycle, chosen, image, clock)
    write_all(document, text_of(document), out, options, image, clock, write)
    deep = sum(a.depth is not None for a in gamma.appearances)
    say(f"{len(right.appearances)} appearances in the right image; {deep} of the left one's have depth")
    say(summary(document, clock))
    return UNFINISHED if document.get("unfinished") else 0


def _read(
    source: str, camera: Camera | None, options: Mapping[str, Any], kb: KnowledgeBase, clock: Stopwatch
) -> tuple[Gamma, NDArray[Any] | None]:
    """One side: Γ from its file, or detected in the picture."""
    from sensing.files.gamma_files import read_gamma
    from sensing.files.images import read_image

    if is_gamma(source):
        return read_gamma(source, kb.appearance_types), None
    if camera is None:
        raise InputError(f"{source}: an image needs its camera: {options['stereo']} must have left and right")
    picture = read_image(source)
    height, width = picture.shape[:2]
    if (camera.width, camera.height) != (width, height):
        raise InputError(
            f"{options['stereo']}: the camera is {camera.width}x{camera.height}, but {source} is {width}x{height}"
        )
    return detected(picture, camera, kb, clock), picture
