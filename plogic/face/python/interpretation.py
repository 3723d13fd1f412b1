"""An interpretation for Python: what a picture shows, and everything that can be asked of it."""

import base64
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Literal, Self, get_args

import numpy as np
from numpy.typing import NDArray

from kb.clouds.word_names import is_word
from plogic.base.errors import InputError
from plogic.face.python.arguments import count
from plogic.face.python.asking import Asked, Program
from plogic.face.session.blocks import Block, Column, Lines, Result, Rows, Table
from plogic.face.session.results import World, Worlds
from plogic.face.shown.figures import chance, interval, signed
from plogic.facts import document as rows
from plogic.facts import interpretation
from plogic.facts.situation import DvOver, Reading, Situation
from plogic.run.measured import Distinctive, Measure, measured
from plogic.scene.text.program_text import program_text, query_lines
from sensing.files.whole_files import write_whole

if TYPE_CHECKING:
    from plogic.face.python.pictures import Camera
    from plogic.face.python.settled import Settled


TITLES = {
    "ev": "ev",
    "ev_to_B": "to_B",
    "ev_drop": "drop",
    "ev_reassign": "reassign",
    "ev_over_instances": "ev, Δ's dv",
    "shanahan": "Shanahan",
    "posterior": "posterior",
    "dv": "dv",
    "dv_over_instances": "Δ's dv",
    "rank": "rank",
}
"""Titles of a hypothesis' measures in the table."""
LEGEND = (
    "ev          explanatory value of the hypothesis alone, ((A+B) - (C+D)) / (A+B+C+D), cells weighed by dv (§5.4)",
    "to_B        ev beside Δi (§5.5): what an accepted object hides is not expected, so that case C becomes B",
    "drop        the same, the C cells so explained leaving the sum",
    "reassign    as to_B, and the D items that another object claims leave the sum too",
    "ev, Δ's dv  ev alone, with dv over the instances in Δi, not over the types of Σo (§5.1)",
    "Shanahan    P(Q) over the sum of P(Q) of it and its rivals, Q being the explanation and no other (§5.7)",
    "posterior   P(present) in the posterior reading, given Γ, priors and rates (§8)",
    "dv          mean distinctiveness, 1 - |S(F)|/|S|, of its detected features over Σo; Δ's dv: over Δi (§5.1)",
    "rank        of its type: the greatest share of its dv that Γ can be matched to, whatever the pose (§5.3)",
)
"""The columns in words of the formalism."""
FEATURES = (
    Column("feature type"),
    Column("dv over types", right=True),
    Column("dv over instances in Δ", right=True),
)


@dataclass(frozen=True, repr=False)
class Measures(Rows[Measure]):
    """A row each hypothesis of Δh, in its order; ``features``: dv of each feature type; shown, one row of all words.

    ``dv_over``: what ev is weighed by, dv over the types of Σo or over the instances in Δ (§5.1).
    """

    hypotheses: tuple[Measure, ...]
    features: tuple[Distinctive, ...]
    dv_over: DvOver = "types"

    @property
    def rows(self) -> tuple[Measure, ...]:
        """The hypotheses' measures."""
        return self.hypotheses

    def blocks(self) -> tuple[Block, ...]:
        """Both tables."""
        columns = (Column("hypothesis"), Column("status"), *(Column(title, right=True) for title in TITLES.values()))
        rows = tuple((f"{h.type} {h.id}", h.status, *(_cell(h, name) for name in TITLES)) for h in self.hypotheses)
        named = [f for f in self.features if not is_word(f.type)]
        kinds = tuple((f.type, chance(f.over_types), chance(f.over_instances)) for f in named)
        if len(named) < len(self.features):
            kinds += (_words_row([f for f in self.features if is_word(f.type)]),)
        over = "" if self.dv_over == "types" else ", ev weighed by dv over the instances in Δ"
        legend = Lines("columns", LEGEND)
        return Table(f"hypotheses{over}", columns, rows), Table("feature types", FEATURES, kinds), legend


def measures_of(document: rows.Interpretation) -> Measures:
    """Return the measures of an interpretation.

    Raises SituationError where the posterior cannot be computed exactly.
    """
    return Measures(*measured(document), document["measures"].get("dv_over", "types"))


def _words_row(words: Sequence[Distinctive]) -> tuple[str, str, str]:
    """Hundreds of visual words in one row, with the ranges of their dv."""
    columns = [f.over_types for f in words], [f.over_instances for f in words if f.over_instances is not None]
    over, within = (f"{chance(min(c))} to {chance(max(c))}" if c else chance(None) for c in columns)
    return f"{len(words)} visual word{'s' * (len(words) > 1)}", over, within


def _cell(h: Measure, name: str) -> str:
    value: float | None = getattr(h, name)
    return signed(value) if name.startswith("ev") else chance(value)


@dataclass(frozen=True, eq=False)
class Hypothesis:
    """One hypothesis: that an object of this ``type`` stands at this pose.

    ``T_camera_object`` (4, 4) maps points of the object's frame to the camera's, metres. ``status`` is accepted, rival
    or rejected. ``cases`` gives each feature its case A, B, C or D of §4, None outside the image. ``interval`` bounds
    the probability. ``pose_probability``: P(its pose is within a tenth of its diameter of the true one (ADD), given
    that it is present), by a photo; None without one.
    """

    id: str
    type: str
    T_camera_object: NDArray[np.float64]
    ev: float | None
    p_ev: float | None
    probability: float
    interval: tuple[float, float]
    status: str
    cases: dict[str, str | None]
    pose_probability: float | None = None

    def __eq__(self, other: object) -> bool:
        return _plain(self) == _plain(other) if isinstance(other, Hypothesis) else NotImplemented

    def __hash__(self) -> int:
        return hash((self.id, self.type, self.probability))


@dataclass(frozen=True, repr=False)
class Hypotheses(Rows[Hypothesis]):
    """The hypotheses, accepted ones first, then rivals, then the best of the rejected."""

    hypotheses: tuple[Hypothesis, ...]

    @property
    def rows(self) -> tuple[Hypothesis, ...]:
        """The hypotheses."""
        return self.hypotheses

    def blocks(self) -> tuple[Block, ...]:
        """One table."""
        columns = (
            Column("hypothesis"),
            Column("status"),
            *(Column(n, right=True) for n in ("ev", "P(ev)", "probability")),
        )
        rows = tuple(
            (f"{h.type} {h.id}", h.status, signed(h.ev), chance(h.p_ev), chance(h.probability)) for h in self.hypotheses
        )
        return (Table("hypotheses", columns, rows),)


@dataclass(frozen=True)
class Relation:
    """A relation that geometry found of two hypotheses; its probability is that both are present."""

    relation: str
    args: tuple[str, str]
    probability: float
    interval: tuple[float, float]


@dataclass(frozen=True, repr=False)
class Relations(Rows[Relation]):
    """Who occludes whom, most probable first."""

    relations: tuple[Relation, ...]

    @property
    def rows(self) -> tuple[Relation, ...]:
        """The relations."""
        return self.relations

    def blocks(self) -> tuple[Block, ...]:
        """One table."""
        columns = (Column("probability", right=True), Column("relation"))
        rows = tuple((interval(*r.interval), f"{r.relation}({', '.join(r.args)})") for r in self.relations)
        return (Table("relations", columns, rows),)


class Picture(np.ndarray[tuple[int, ...], np.dtype[np.uint8]]):
    """An image (H, W, 3) uint8, blue first, that shows itself in a notebook."""

    def _repr_png_(self) -> bytes:
        import cv2

        return bytes(cv2.imencode(".png", np.asarray(self))[1].tobytes())


class Interpretation(Asked, Result):
    """What one picture shows: hypotheses, possible worlds, relations.

    Self-contained, so that no image or KB has to be at hand.
    """

    def __init__(self, document: rows.Interpretation, *, image: NDArray[np.uint8] | None = None) -> None:
        """Take an ``interpretation/1`` document, and its image (H, W, 3) uint8, blue first, if it is at hand."""
        self._document, self._image = document, image

    @classmethod
    def load(cls, path: str | Path) -> Self:
        """Read an ``interpretation.json``. Raises Error where it is none."""
        return cls(interpretation.read_interpretation(path))

    @property
    def document(self) -> rows.Interpretation:
        """The ``interpretation/1`` document."""
        return self._document

    @property
    def reading(self) -> Reading:
        """The reading that probabilities are of: score or posterior."""
        return self._document["reading"]

    def read_as(self, reading: Reading) -> Self:
        """Return the same hypotheses and facts in the other reading, for all that is asked of it."""
        if reading not in get_args(Reading):
            raise InputError(f"reading: {reading!r:.60} should be one of {', '.join(get_args(Reading))}")
        return type(self)({**self._document, "reading": reading}, image=self._image)

    def about(self, goal: str | None) -> Asked:
        """Return the same with what evidence says of posed objects, where the goal asks for it."""
        if goal is None or "evidence_r" not in goal or self.subject.evidence:
            return self
        from plogic.sequence.unposed.reading import weighed

        return type(self)(weighed(self._document), image=self._image)

    def withhold(self, *names: str) -> Self:
        """Return the same without the poses of these hypotheses: how they stand is then told by what is detected.

        Args:
            names: ids, or ``other.json:h2`` for a hypothesis of another image, which gets the first id that is free.

        Raises:
            Error: for what is no hypothesis that can be present.
        """
        from plogic.sequence.unposed.elsewhere import without_poses

        return type(self)(without_poses(self._document, names), image=self._image)

    @property
    def unfinished(self) -> bool:
        """Whether a deadline came before all was done; probabilities are then known within their intervals."""
        return bool(self._document.get("unfinished"))

    @property
    def camera(self) -> "Camera":
        """The camera."""
        from geometry.camera import camera_from_dict
        from plogic.face.python.pictures import Camera

        return Camera.of(camera_from_dict(self._document.get("camera")))

    @property
    def hypotheses(self) -> Hypotheses:
        """The hypotheses: accepted ones, rivals, and the best of the rejected."""
        return Hypotheses(tuple(_hypothesis(h) for h in self._document["hypotheses"]))

    @property
    def relations(self) -> Relations:
        """The relations between hypotheses."""
        return Relations(
            tuple(
                Relation(r["relation"], (r["args"][0], r["args"][1]), r["probability"], _interval(r))
                for r in self._document.get("relations", [])
            )
        )

    @cached_property
    def subject(self) -> Situation:
        """The typed situation that questions are put to."""
        return interpretation.situation_of(self._document)

    def measures(self) -> "Measures":
        """Return ev in each mode, Shanahan's value, the posterior, dv and rank.

        A row each hypothesis that is not rejected.
        """
        return measures_of(self._document)

    def settle(self, worlds: int = 1, *, drop: bool = False) -> "Settled":
        """Return what becomes of the objects of the best worlds where they are let go for two seconds.

        Who falls, tips, slides, or was pushed out of another. ``drop``: what is free is let go, too. Raises InputError
        without physics, and where nobody knows which way is up.
        """
        from plogic.face.python.settled import Settled
        from plogic.run.settling import settled

        return Settled(settled(self._document, count("worlds", worlds), drop=drop))

    def program(self) -> Program:
        """Return the ProbLog program with its queries.

        It runs unchanged in a stock ``problog``, with the same numbers.
        """
        return Program(program_text(self.subject) + "\n" + query_lines(self.subject), "interpretation.pl")

    def picture(self, marks: Literal["few", "all", "none"] = "few") -> Picture:
        """Return the hypotheses drawn over the image: (H, W, 3) uint8, blue first.

        ``marks`` of features: ``few``, where they are not hundreds; ``all``; or ``none``.
        """
        from plogic.face.shown.overlay import overlay

        return overlay(self._document, self.image, marks).view(Picture)

    @property
    def image(self) -> NDArray[np.uint8] | None:
        """The image (H, W, 3) uint8, blue first.

        The one that was perceived, else the one that is carried along, maybe smaller; or None.
        """
        from sensing.files.images import image_from

        carried = self._document.get("assets", {}).get("image")
        if self._image is not None or carried is None:
            return self._image
        return image_from(base64.b64decode(carried["base64"]), "the carried image")

    def report(self, path: str | Path) -> Path:
        """Write one self-contained page that works offline, and return its path."""
        from plogic.face.pages.one_file import page

        write_whole(Path(path), page(self._document).encode())
        return Path(path)

    def save(self, path: str | Path) -> Path:
        """Write an ``interpretation.json``, whole or not at all, and return its path."""
        write_whole(Path(path), interpretation.text_of(self._document).encode())
        return Path(path)

    def blocks(self) -> tuple[Block, ...]:
        """The hypotheses and the worlds that are listed."""
        types = {h["id"]: h["type"] for h in self._document["hypotheses"]}
        listed = tuple(
            World(
                w["probability"],
                tuple(w["present"]),
                self._causes(w.get("causes", {})),
                _interval(w),
                support=w.get("support"),
                stances=w.get("stances"),
            )
            for w in self._document.get("worlds", [])[:10]
        )
        low, high = self._document.get("unlisted_mass", (0.0, 0.0))
        return (*self.hypotheses.blocks(), *Worlds(listed, (low, high), (), types, self.subject.stopped).blocks())

    def _causes(self, listed: Mapping[str, str]) -> dict[str, str]:
        """The cause of every appearance; where only some are listed, the others are noise."""
        rest = self._document["appearances"] if self._document.get("causes_else") == "noise" else []
        return {a["id"]: "noise" for a in rest} | dict(listed)

    def __eq__(self, other: object) -> bool:
        return self._document == other.document if isinstance(other, Interpretation) else NotImplemented

    def __hash__(self) -> int:
        return hash((self.reading, tuple(h["id"] for h in self._document["hypotheses"])))


def _hypothesis(row: rows.HypothesisRow | rows.RejectedRow) -> Hypothesis:
    return Hypothesis(
        row["id"],
        row["type"],
        np.array(row["T_camera_object"], dtype=float),
        row.get("ev"),
        row.get("p_ev"),
        row.get("probability", 0.0),
        _interval(row),
        row["status"],
        {f["id"]: f.get("case") for f in row["features"]},
        row.get("pose_probability"),
    )


def _interval(row: rows.Verdict | rows.WorldRow | rows.RelationRow) -> tuple[float, float]:
    """The bounds that are told, else the probability twice."""
    low, high = row.get("interval") or (row.get("probability", 0.0),) * 2
    return low, high


def _plain(h: Hypothesis) -> tuple[object, ...]:
    rest = {name: value for name, value in vars(h).items() if name != "T_camera_object"}
    return h.T_camera_object.tolist(), rest
