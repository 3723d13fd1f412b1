"""Where commands take their input from.

Knowledge bases, interpretations, programs, and Γ, its file or detected in a picture (``plogic.run.cameras``).
"""

from pathlib import Path
from typing import TYPE_CHECKING, Any

from geometry.files.plain_files import is_there
from plogic.base.clock import Stopwatch
from plogic.base.errors import InputError

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from geometry.camera import Camera
    from kb.clouds.cloud import KnowledgeBase
    from plogic.run.cameras import Shot
    from sensing.appearance import Gamma


def is_gamma(source: str) -> bool:
    """Whether an INPUT names a Γ and no image: JSON, or stdin."""
    return source == "-" or source.lower().endswith(".json")


def gamma_of(
    source: str, shot: "Shot | None", kb: "KnowledgeBase", clock: Stopwatch
) -> "tuple[Gamma, NDArray[Any] | None]":
    """Γ from its file, or detected in a picture; types that the KB does not know are mistakes of a file."""
    from sensing.files.gamma_files import read_gamma

    if shot is None:
        return read_gamma(source, kb.appearance_types), None
    return detected(shot.image, shot.camera, kb, clock), shot.image


def detected(picture: "NDArray[Any]", camera: "Camera", kb: "KnowledgeBase", clock: Stopwatch) -> "Gamma":
    """Γ of a picture (H, W, 3), BGR, by all detectors that report a type of the KB.

    Raises InputError where none does.
    """
    from sensing.detectors.detector import detect

    if not detectable(kb):
        raise InputError(_undetectable(kb))
    with clock.stage("detect"):
        return detect(picture, camera, kb.sought, kb.words)


MOST_NAMED = 12
"""Appearance types that an error names."""


def _remedies(kb: "KnowledgeBase") -> str:
    """What gives types features, each remedy once."""
    from kb.shown.cautions import remedy

    told = [remedy(kind, "--kb KB") for kind in kb.types] or ["plogic kb add NAME --mesh FILE --kb KB"]
    return "; ".join(dict.fromkeys(told))


def _undetectable(kb: "KnowledgeBase") -> str:
    """Why an image gives nothing with a knowledge base, and what would."""
    from sensing.detectors.detector import detectors

    if not any(kind.features for kind in kb.types):
        return f"{kb.name}: no type has features, so an image gives nothing: {_remedies(kb)}"
    known = sorted({name for make in detectors().values() for name in make().types})
    own, theirs = (
        ", ".join(names[:MOST_NAMED]) + ", ..." * (len(names) > MOST_NAMED) for names in (kb.appearance_types, known)
    )
    what = f"{kb.name}: no detector reports any of its appearance types ({own or 'there are none'})"
    return f"{what}: give a Γ file instead, or use types that detectors report ({theirs})"


def detectable(kb: "KnowledgeBase") -> bool:
    """Whether some registered detector reports a type of the KB's vocabulary."""
    from sensing.detectors.detector import detectors

    return any(set(make().types) & set(kb.appearance_types) for make in detectors(kb.words).values())


LARGEST_PROGRAM = 8 * 2**20
"""Bytes of a program or rules file that is read."""


def kb_of(folder: str) -> "KnowledgeBase":
    """Read a knowledge base; the name of a shipped one (`towers`) stands for its folder where no such folder exists.

    Its rules are held to the allow-list here, before any work is done with it. Raises KBError, ProgramError.
    """
    from geometry.files.remembered import cache_folder
    from kb.files.read import read_kb
    from plogic.logic.safety.atoms import Names
    from plogic.logic.safety.author import author_rules
    from plogic.scene.text.rules import defined

    kb = read_kb(kb_folder(folder), cache_folder(""))
    author_rules(kb.rules, Names({}, {}), defined())
    return kb


def kb_folder(name: str) -> Path:
    """The folder of a knowledge base, or of a shipped one. Raises KBError where it is neither."""
    from kb.files.folder import shipped

    path = Path(name)
    return path if is_there(path) or "/" in name else shipped(name)


def is_program(source: str) -> bool:
    """Whether a source names ProbLog text."""
    return source.lower().endswith((".pl", ".problog", ".pro"))


def program_text_of(path: str) -> str:
    """The text of a program or rules file; `-` is stdin. Raises InputError."""
    from geometry.files.plain_files import text_of

    return text_of(path, LARGEST_PROGRAM, InputError, "program")


def stdin_text() -> tuple[str, bool]:
    """What comes over stdin, and whether it is ProbLog text: no JSON, and not nothing. Raises InputError."""
    from geometry.files.plain_files import name_of, text_of
    from plogic.facts.interpretation import LARGEST

    text = text_of("-", LARGEST, InputError, "interpretation, nor a program")
    begin = text.lstrip()[:1]
    if begin in ("", "{", "["):
        return text, False
    size = len(text.encode())
    if size > LARGEST_PROGRAM:
        raise InputError(
            f"{name_of('-')}: has {size} bytes, more than the {LARGEST_PROGRAM} of a program that are read"
        )
    return text, True
