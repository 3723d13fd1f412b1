"""The kinds of type models, one row each; and all types of a knowledge base, made ready by their kinds.

* ``KINDS``: the table in which a kind is registered
* ``Models``: the types of all kinds, by name
"""

from collections.abc import Callable, Iterator, Mapping
from importlib import import_module
from pathlib import Path
from typing import NamedTuple

from kb.clouds.cloud import KnowledgeBase, ObjectType
from plogic.match.judged.type_models import Setup, TypeModel, TypeModels

FAST = "index"
"""The generator of every day, of the kinds that need not be asked for."""


class Kind(NamedTuple):
    """One kind: how its types are made ready, and which of a knowledge base it ``holds``.

    ``asked``: only where that generator is.
    """

    name: str
    models: Callable[[Setup], TypeModels]
    holds: Callable[[ObjectType, KnowledgeBase], bool]
    asked: bool = False


def _of(path: str) -> Callable[[Setup], TypeModels]:
    """What makes the types of a kind ready; the module is read when a type is of it."""

    def made(setup: Setup) -> TypeModels:
        module, _, name = path.partition(":")
        models: TypeModels = getattr(import_module(module), name).of(setup)
        return models

    return made


KINDS = (
    Kind("learned", _of("plogic.match.learned.learned_models:LearnedModels"), lambda kind, _: kind.learned is not None),
    Kind(
        "quadruples",
        _of("plogic.match.plain.plain_models:Quadruples"),
        lambda kind, _: kind.learned is None,
        asked=True,
    ),
    Kind(
        "softposit", _of("plogic.match.plain.plain_models:SoftPosit"), lambda kind, _: kind.learned is None, asked=True
    ),
    Kind(
        "oriented",
        _of("plogic.match.oriented.oriented_models:OrientedModels"),
        lambda _, kb: kb.rates.sigma_angle is not None,
    ),
    Kind("hand", _of("plogic.match.hand.hand_models:HandModels"), lambda _, __: True),
)
"""All kinds, each read when a type is of it; a type is of the first that holds it."""
GENERATORS = FAST, *(kind.name for kind in KINDS if kind.asked)
"""Who may propose poses of hand-modelled types."""


class Models(Mapping[str, "TypeModel"]):
    """All object types of some kinds, by name in the order of their names, made ready; ``kinds``: each by its name."""

    def __init__(self, kinds: Mapping[str, TypeModels]) -> None:
        self.kinds = kinds
        self._models = dict(sorted(item for kind in kinds.values() for item in kind.models.items()))

    def __getitem__(self, name: str) -> TypeModel:
        return self._models[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._models)

    def __len__(self) -> int:
        return len(self._models)


def models_of(kb: KnowledgeBase, dv: Mapping[str, float], folder: Path | None = None, generator: str = FAST) -> Models:
    """All types of a knowledge base that have features; ``folder``: where results may be kept between runs."""
    rows = [kind for kind in KINDS if not kind.asked or kind.name == generator]
    held: dict[str, list[ObjectType]] = {}
    for each in sorted(
        kb.types, key=lambda t: t.name
    ):  # of types that are equal in all but their names the first is found
        if each.features:
            held.setdefault(next(kind.name for kind in rows if kind.holds(each, kb)), []).append(each)
    return Models({row.name: row.models(Setup(held[row.name], kb, dv, folder)) for row in rows if row.name in held})
