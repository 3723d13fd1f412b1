"""``perceive`` and ``detect``: from an image or Γ to an interpretation."""

import warnings
from pathlib import Path
from time import monotonic
from typing import get_args

import numpy as np
from numpy.typing import NDArray

from geometry.camera import Camera
from plogic.base.clock import Stopwatch
from plogic.base.errors import InputError
from plogic.cycle.delta import Options
from plogic.face.python.arguments import seconds, share
from plogic.face.python.interpretation import Interpretation
from plogic.face.python.knowledge import KnowledgeBase
from plogic.face.python.pictures import Gamma, Image, shot_for
from plogic.facts.situation import DvOver, Reading, Reconsider
from plogic.run.sources import detected, is_gamma
from sensing import appearance
from sensing.files.gamma_files import gamma_from_dict, gamma_to_dict, read_gamma


def detect(image: Image, kb: KnowledgeBase | str | Path, camera: Camera | str | Path | None = None) -> Gamma:
    """Return Γ of an image: what the detectors report that the knowledge base has types for.

    Args:
        image: a file, or pixels (H, W, 3) uint8, blue first.
        kb: a knowledge base, its folder, or the name of a shipped one.
        camera: the image's camera, or its file; without it, one of EXIF's focal length, with a warning.

    Raises:
        Error: where the image, the knowledge base or the camera cannot be used.
    """
    shot = shot_for(image, camera, 3)
    return Gamma.of(detected(shot.image, shot.camera, loaded(kb).sigma, Stopwatch()))


def perceive(  # noqa: PLR0913 - the options of the command
    source: Image | appearance.Gamma,
    kb: KnowledgeBase | str | Path,
    camera: Camera | str | Path | None = None,
    *,
    reading: Reading = "score",
    reconsider: Reconsider = "to_B",
    dv_over: DvOver = "types",
    smoothing: float = 0.0,
    generator: str = "index",
    deadline: float | None = None,
) -> Interpretation:
    """Interpret an image or Γ with a knowledge base, as ``plogic perceive`` does.

    Args:
        source: an image's file, its pixels (H, W, 3) uint8 (blue first), Γ, or its file (``.json``).
        kb: a knowledge base, its folder, or the name of a shipped one.
        camera: an image's camera, or its file, or else EXIF's focal length, with a warning; Γ has its own.
        reading: ``"score"`` (the paper's), or ``"posterior"``.
        reconsider: how explained misses count: ``"to_B"``, ``"drop"`` or ``"reassign"`` (score reading).
        dv_over: what dv counts features over: ``"types"`` of the knowledge base, or ``"instances"`` in Δ.
        smoothing: ε of the score program's choices, 0 to below 0.5.
        generator: who proposes poses of hand-modelled types: ``"index"``, or ``"quadruples"`` or ``"softposit"``.
        deadline: seconds from when the knowledge base and Γ are there; what was found by then is marked ``unfinished``.

    Raises:
        Error: where any of these cannot be used.
    """
    checked(reading, reconsider, dv_over)
    smoothing, deadline = share("smoothing", smoothing, 0.5), seconds("deadline", deadline)
    kb = loaded(kb)
    gamma, image = gamma_and_image(source, kb, camera)
    perceiver = kb.perceiver(generator)
    end = None if deadline is None else monotonic() + deadline
    document = perceiver(gamma, Options(reading, reconsider, smoothing, end, dv_over), image)
    return Interpretation(document, image=image)


def loaded(kb: KnowledgeBase | str | Path) -> KnowledgeBase:
    """The knowledge base, read where a folder or a name is given."""
    return kb if isinstance(kb, KnowledgeBase) else KnowledgeBase.load(kb)


def gamma_and_image(
    source: Image | appearance.Gamma, kb: KnowledgeBase, camera: Camera | str | Path | None
) -> tuple[appearance.Gamma, NDArray[np.uint8] | None]:
    """Γ, and the image where there is one; of a Γ, which has a camera of its own, another is warned of."""
    if isinstance(source, appearance.Gamma):
        gamma = gamma_from_dict(gamma_to_dict(source), "gamma", kb.appearance_types)
    elif isinstance(source, str | Path) and is_gamma(str(source)):
        gamma = read_gamma(source, kb.appearance_types)
    else:
        shot = shot_for(source, camera, 4)
        return detected(shot.image, shot.camera, kb.sigma, Stopwatch()), shot.image
    if camera is not None:
        warnings.warn("a Γ has a camera of its own: camera is not used", stacklevel=3)
    return gamma, None


def checked(reading: str, reconsider: str, dv_over: str) -> None:
    """Raise InputError where an option has a value that it cannot have."""
    for name, value, known in (
        ("reading", reading, get_args(Reading)),
        ("reconsider", reconsider, get_args(Reconsider)),
        ("dv_over", dv_over, get_args(DvOver)),
    ):
        if value not in known:
            raise InputError(f"{name}: {value!r:.60} should be one of {', '.join(known)}")
