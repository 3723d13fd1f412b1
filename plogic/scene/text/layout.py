"""How program text is written: atoms by the table of names, numbers so that ProbLog reads them back exactly."""

import json
from collections.abc import Iterable
from dataclasses import dataclass

from plogic.facts.dependence import Dependence, Scene
from plogic.facts.hypothesis import FeatureFact, Hypothesis
from plogic.logic.safety.atoms import Names
from plogic.scene.readings.world_weights import causes_of


@dataclass(frozen=True)
class Writer:
    """A scene, its graph of dependence and its names: what each layer of the text is written from."""

    scene: Scene
    graph: Dependence
    names: Names

    def atoms(self, *labels: str) -> str:
        """``h1, f3``: the labels' atoms as arguments."""
        return ", ".join(self.names.atom(label) for label in labels)

    def fact(self, predicate: str, *labels: str) -> str:
        """A fact about labels: ``in_image(h1, f3).``."""
        return f"{predicate}({self.atoms(*labels)})."

    def node(self, h: Hypothesis, inner: str) -> str:
        """``h1/f3``: a part or a feature of a hypothesis."""
        return f"{self.names.atom(h.id)}/{self.names.atom(inner)}"

    def feature(self, h: Hypothesis, f: FeatureFact) -> str:
        """``h1, f3``."""
        return self.atoms(h.id, f.id)

    def list(self, labels: Iterable[str]) -> str:
        """``[h1, h2]``."""
        return f"[{self.atoms(*labels)}]"


def number(value: float) -> str:
    """The shortest text that reads back as the same float."""
    return repr(float(value))


def coordinate(value: float) -> str:
    """Metres, to a tenth of a millimetre, without a negative zero."""
    text = f"{value:.4f}"
    return text[1:] if text.startswith("-") and float(text) == 0 else text


def quoted(label: str) -> str:
    """A user's label for a comment, on one line whatever it holds."""
    return json.dumps(label)


def disjunction(heads: list[tuple[str, str]], body: str = "", per_line: int = 3) -> str:
    """An annotated disjunction: ``0.5::a; 0.5::b.``, a few heads a line; labels may use variables of the ``body``."""
    written = [f"{label}::{head}" for label, head in heads]
    lines = ["; ".join(written[i : i + per_line]) for i in range(0, len(written), per_line)]
    return ";\n  ".join(lines) + (f" :-\n  {body}." if body else ".")


def title(number_of_layer: int, meaning: str) -> str:
    """The heading of a layer."""
    return f"% ==== ({number_of_layer}) {meaning}"


def possible_causes(w: Writer, appearance: str) -> list[tuple[str, str]]:
    """What can cause an appearance, each with its share: ``("0.7", "chosen(a1, h1/f3)")``, noise last."""
    causes, claimants = causes_of(w.scene, appearance), w.scene.claimants.get(appearance, [])
    named = [(p, w.node(h, f.id)) for p, (h, f) in zip(causes.claimants, claimants, strict=True)]
    heads = [(p, f"chosen({w.names.atom(appearance)}, {cause})") for p, cause in [*named, (causes.noise, "noise")]]
    return [(number(p), head) for p, head in heads if p > 0]
