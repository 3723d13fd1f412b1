"""The knowledge base of a dataset's models: learned anew, or read where it has been kept; and with some types only."""

from __future__ import annotations

import tempfile
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from kb.clouds.cloud import UNKNOWN_SUPPORT
from plogic.base.errors import InputError
from plogic.face.shown.options import Learning
from plogic.run.bop.models import ids_of, model_ids, model_names

if TYPE_CHECKING:
    from collections.abc import Callable, Collection, Iterator

    from kb.clouds.cloud import KnowledgeBase


@contextmanager
def known(
    models: Path, kept: Path | None, seed: int, say: Callable[[str], None]
) -> Iterator[tuple[KnowledgeBase, dict[str, int]]]:
    """The knowledge base of all the models, and the BOP number of each of its types.

    ``kept``: the folder where it is read from, or, where there is none, written to; None for one that is dropped.

    Raises:
        InputError: Nothing can be learned of the models, or what is kept lacks some of them. KBError: it is no
            knowledge base.
    """
    from kb.files.read import read_kb

    with tempfile.TemporaryDirectory(prefix="plogic-photos-") as place:
        folder = kept or Path(place) / "kb"
        if not folder.exists():
            _learn(folder, models, seed, say)
        kb = read_kb(folder)
        named = numbers_of(kb, models)
        lacking = sorted(set(model_ids(models)) - set(named.values()))
        if lacking:
            raise InputError(
                f"{folder}: the knowledge base lacks types of {models}: numbers {', '.join(map(str, lacking))}; "
                "in a folder that does not exist it is learned anew"
            )
        yield kb, named


def numbers_of(kb: KnowledgeBase, models: Path) -> dict[str, int]:
    """The BOP number of each type that a folder of models knows by its name, or that is named by its number."""
    numbers = model_names(models) | ids_of([kind.name for kind in kb.types], {})
    return {kind.name: numbers[kind.name] for kind in kb.types if kind.name in numbers}


def _learn(folder: Path, models: Path, seed: int, say: Callable[[str], None]) -> None:
    from plogic.face.authoring.kb_learn import learn_command
    from plogic.face.authoring.kb_types import import_command

    folder.parent.mkdir(parents=True, exist_ok=True)
    import_command(models, folder, None, as_json=False)
    learn_command(str(folder), [], Learning(detector="sift", jobs=2, seed=seed), say=say)


def of_types(kb: KnowledgeBase, names: Collection[str]) -> KnowledgeBase:
    """Σ with these types alone; its words stay."""
    return replace(kb, types=tuple(kind for kind in kb.types if kind.name in names))


def resting(kb: KnowledgeBase, *, maybe: bool) -> KnowledgeBase:
    """The knowledge base that says ``gravity: maybe``, or ``gravity: false``."""
    return replace(kb, gravity=False, maybe=maybe, unknown_support=UNKNOWN_SUPPORT, ground=None)
