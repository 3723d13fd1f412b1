"""The protocol of a kind of type models: how all object types of one kind are found and judged together (§7).

A kind is one folder below ``plogic.match`` and one row of ``plogic.match.kinds.KINDS``. The layers above ask these
methods, never what kind a type
has. The methods that have a body here state what most kinds do; a kind that derives from the protocol has them.

* ``TypeModel``: one object type, made ready
* ``TypeModels``: all types of one kind, made ready once for a knowledge base
* ``Search``: the search for them in one Γ
"""

from collections import Counter
from collections.abc import Callable, Generator, Mapping, Sequence
from pathlib import Path
from typing import ClassVar, NamedTuple, Protocol, TypeAlias

from geometry.arrays import Floats, Indices, Mask
from geometry.bodies.resting import RestingFaces
from geometry.bodies.standing import Known
from kb.clouds.cloud import KnowledgeBase, ObjectType
from plogic.base.clock import unhurried
from plogic.facts.hypothesis import Hypothesis
from plogic.match.gamma.data import Data

Found: TypeAlias = list[tuple[float, Hypothesis]]
"""Hypotheses with their log-likelihood ratios, best first."""

SURE = 5.0
"""Logarithm of the odds by which a type must explain its data better than clutter does, all its poses together: 150 to
1."""


class Ranks(NamedTuple):
    """rank(Type) (§5.3), in [0, 1]: of Γ, of clutter alone, and the best within one neighbourhood."""

    rank: float
    by_chance: float
    within_cell: float


class Given(NamedTuple):
    """What a search is given besides the free data.

    ``accepted``: Δi so far. ``hidden_of`` tells (F,) which features of a hypothesis Δi hides. ``seen`` is told the
    hypotheses of a type as soon as
    they are found, best first. ``tell`` is told what the trace shall say.
    """

    accepted: Sequence[Hypothesis]
    hidden_of: Callable[[Hypothesis], Mask]
    seen: Callable[[Found], None]
    tell: Callable[[str], None]

    def count(self, name: str) -> int:
        """The number of accepted hypotheses of a type."""
        return sum(posed.object_type.name == name for posed in self.accepted)


class Setup(NamedTuple):
    """What a kind is made of: at least one type, dv, and ``folder``, where results may be kept between runs."""

    types: Sequence[ObjectType]
    kb: KnowledgeBase
    dv: Mapping[str, float]
    folder: Path | None = None


class Request(NamedTuple):
    """One Γ that is searched by so many ``processes`` at most.

    ``check`` is called between stages, and may raise to end the search.
    """

    data: Data
    kb: KnowledgeBase
    check: Callable[[], None] = unhurried
    processes: int = 1


class TypeModel(Protocol):
    """One object type, made ready for search."""

    settled_when_found: ClassVar[bool]
    """Whether a search refines its hypotheses to the end.

    Then refinement beside Δi is worth while only for those that lack little, and what it comes to replaces them.
    """

    @property
    def object_type(self) -> ObjectType:
        """The type itself."""
        ...

    @property
    def points(self) -> Floats:
        """(F, 3) m, where its features are, object frame."""
        ...

    @property
    def centre(self) -> Floats:
        """(3,) m, its middle, object frame."""
        ...

    @property
    def weights(self) -> Floats:
        """(F,) dv of its features."""
        ...

    @property
    def anchors(self) -> Indices:
        """(K,) the features that hypotheses start from, of which one must be detected."""
        ...

    @property
    def resting(self) -> RestingFaces:
        """The faces that it stands on, with weights."""
        ...

    def ranks(self, here: Counter[str], by_chance: Counter[str]) -> Ranks:
        """The ranks given how many data there are of each appearance type, and how many clutter alone would give."""
        ...

    def proposals(self, data: Data, kb: KnowledgeBase, most: int) -> Found:
        """The hypotheses that the whole of Γ suggests, none left out to save time: at most ``most`` are refined."""
        ...

    def settle(
        self,
        pose: Floats | Hypothesis,
        data: Data,
        kb: KnowledgeBase,
        free: Mask | None = None,
        hidden: Mask | None = None,
        rounds: int = 2,
    ) -> Hypothesis:
        """The type at a pose camera_from_object (4, 4), or a hypothesis that is matched already.

        Matched (D7, D8), refined, and matched again.

        ``free`` (A,) the data that nobody else has claimed; ``hidden`` (F,) the features that accepted opaque objects
        hide.
        """
        ...

    def beside(self, posed: Hypothesis, others: Sequence[Hypothesis], data: Data) -> Hypothesis:  # noqa: ARG002 - a kind may have more to say
        """A hypothesis told anew what only the picture says of it, where these others may hide it."""
        return posed

    def pictured(self, posed: Hypothesis, others: Mapping[str, Hypothesis], data: Data) -> Hypothesis:  # noqa: ARG002 - a kind may have more to say
        """A hypothesis told what the photo says of it by which of these others, by id, are present."""
        return posed

    def significance(self, posed: Hypothesis) -> float:
        """The log-likelihood ratio that a hypothesis must exceed, beyond what any pose has."""
        ...


class Search(Protocol):
    """The search for all types of one kind in one Γ, again and again, as more of it is claimed."""

    at_once: ClassVar[int | None] = None
    """How many types are best asked together; None: all."""

    def votes(self) -> Mapping[str, float]:
        """How well at best a pose of each type is voted for by all of Γ, where that is known before a search."""
        return {}

    def promising(self, names: Sequence[str], left: Data, given: Given) -> Sequence[str]:  # noqa: ARG002 - a kind may have more to say
        """Those of some types that the free data vote for: of others no hypothesis is sought in them."""
        return names

    def propose(self, names: Sequence[str], left: Data, given: Given) -> Generator[Found]:
        """The hypotheses of each named type that the free data suggest, with their log-likelihood ratios, best first.

        There are none of a type of which no more are expected.
        """
        ...

    def standing(self, supports: Sequence[Known], left: Data, given: Given) -> Generator[Found]:  # noqa: ARG002 - not every kind can say
        """The hypotheses that the free data suggest on a plane, or on tops, of each type of which none is accepted."""
        yield from ()

    def stood(self, posed: Hypothesis, known: Known, others: Sequence[Hypothesis]) -> Hypothesis:  # noqa: ARG002 - as above
        """A hypothesis moved to where contact with a plane and the photo, where these others may hide it, agree."""
        return posed

    def demanded(self, model: TypeModel, posed: Hypothesis) -> float:
        """The log-likelihood ratio that a hypothesis must exceed in this Γ, beyond what any pose has."""
        return model.significance(posed)

    def reckon(self, odds: Mapping[str, float]) -> None:  # noqa: ARG002 - a kind may demand the same always
        """Be told by what log-odds the likeliest hypothesis of each type is there, with where it stands."""
        return

    def deepen(self, left: Data, *, accepted: bool) -> str | None:  # noqa: ARG002 - a kind may have more to say
        """Search further the next time, and why; None where that is not done.

        ``accepted``: whether Δi holds anything.
        """
        return None

    def tilted(self, posed: Hypothesis, left: Data) -> list[Floats]:  # noqa: ARG002 - a kind may have more to say
        """The poses (4, 4) that may fit as well in the place of a hypothesis."""
        return []


class TypeModels(Protocol):
    """All object types of one kind, made ready once for a knowledge base. ``models``: each by its name."""

    models: Mapping[str, TypeModel]

    def search(self, request: Request) -> Search:
        """The search in one Γ."""
        ...

    def make_ready(self) -> None:
        """Compute now what is otherwise computed when it is first asked for.

        What a copy of the process computes is lost with it.
        """
        return
