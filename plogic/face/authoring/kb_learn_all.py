"""What is learned of types, by all processes together: what is remembered is not done again.

Every cloud, and the turns that were tried with it, are put into the user's cache folder as soon as they are there, so
that who begins again after an end goes on from there.

* ``Learned``: of one type
"""

import hashlib
import os
from collections.abc import Callable, Collection, Iterable, Sequence
from contextlib import suppress
from functools import partial
from pathlib import Path
from typing import NamedTuple, TypeVar

import numpy as np

from geometry.files.remembered import cache_folder, forget_files_beside
from kb.clouds.cloud import KnowledgeBase, ObjectType
from kb.clouds.learned import LearnedCloud, cloud_bytes, read_cloud
from kb.errors import CloudError
from kb.learning.observations import DIRECTIONS, Observations
from kb.learning.photo import PaintedMesh
from kb.learning.symmetry_trials import DIRECTIONS as NEW
from kb.learning.symmetry_trials import Trial, read_trials, trials_bytes
from kb.shown.cautions import compound_sizes, compounds_text
from plogic.base.errors import InputError
from plogic.base.jobs import ChildDiedError, growing
from plogic.face.authoring.kb_learn_look import Step, Task, done, fitted, key_of, looks, turns_tried
from plogic.face.shown.options import Learning
from plogic.face.shown.progress import Work
from sensing.errors import SensingError
from sensing.files.whole_files import write_whole
from sensing.simulated.body import read_mesh

Found = TypeVar("Found")

FITTED = 15.0
"""What it takes to make a cloud of what was seen, in views: 2.5 s where one takes 0.17 s."""
WORK = DIRECTIONS + FITTED + NEW
"""What a type takes, in views (``Work``)."""


class Learned(NamedTuple):
    """``cloud``: None where nothing of the type comes again; ``trials``: None where nobody asked for them."""

    cloud: LearnedCloud | None
    trials: list[Trial] | None


def no_print(detector: str) -> str:
    """Why there is no cloud."""
    return (
        f"no keypoint of it comes again from view to view: its texture is too plain for {detector}; "
        "write junctions, patches, markers or colour blobs into object.yaml by hand"
    )


def learned(
    kinds: Sequence[ObjectType],
    turned: Collection[str],
    kb: KnowledgeBase,
    options: Learning,
    work: Work,
    painted: PaintedMesh | None = None,
) -> dict[str, Learned]:
    """By name, what is remembered of types with a mesh file, or learned and put there.

    ``turned``: those of which trials are wanted; ``painted``: the one type, where a photo was laid on it.

    Raises:
        InputError: a process died. SensingError: a mesh cannot be drawn.
    """
    everything = _Everything(kinds, turned, kb, options, work, painted)
    try:
        # a forked process would inherit the locks of OpenCV's threads, and wait for them for ever
        growing(done, everything.begun(), options.jobs, everything.then)
    except ChildDiedError as error:
        raise InputError(
            f"a process that rendered ended ({error}): where memory is short, fewer --jobs than {options.jobs}"
        ) from None
    return everything.result()


class _Everything:
    """What is known so far, and what comes next."""

    def __init__(
        self,
        kinds: Sequence[ObjectType],
        turned: Collection[str],
        kb: KnowledgeBase,
        options: Learning,
        work: Work,
        painted: PaintedMesh | None,
    ) -> None:
        self._kinds = {kind.name: kind for kind in kinds}
        self._turned, self._kb, self._options, self._work, self._painted = turned, kb, options, work, painted
        self._clouds: dict[str, bytes | None] = {}
        self._trials: dict[str, list[Trial]] = {}
        self._seen: dict[str, dict[range, list[Observations]]] = {name: {} for name in self._kinds}
        self._stages: dict[str, str] = {}
        self._folder, self._keys = cache_folder("clouds"), dict[str, str]()

    def begun(self) -> list[Step]:
        """The first steps of each type; what is remembered is taken."""
        return [step for kind in self._kinds.values() for step in self._first(kind)]

    def _first(self, kind: ObjectType) -> list[Step]:
        cloud = self._remembered(kind, "", kept_cloud)
        if cloud is None:
            return self._staged(kind.name, f"0 of {DIRECTIONS} views", looks(kind.name, self._task(kind)))
        self._work.say(f"{kind.name}: was learned before ({self._place(kind, '')})")
        self._work.skip(DIRECTIONS + FITTED)
        return self._with_cloud(kind, cloud)

    def _with_cloud(self, kind: ObjectType, cloud: bytes) -> list[Step]:
        """What follows where the cloud is there: the trials, where they are asked for and not there."""
        self._clouds[kind.name] = cloud
        trials = (
            [] if kind.name not in self._turned or kind.surface is None else self._remembered(kind, TURNS, read_trials)
        )
        if trials is None and kind.surface is not None:
            shape = np.array(kind.surface.vertices), np.array(kind.surface.triangles)
            call = partial(turns_tried, self._task(kind), *shape, cloud)
            return self._staged(kind.name, "symmetries", [Step(kind.name, call)])
        self._work.skip(NEW)
        return self._finished(kind.name, trials or [])

    def _finished(self, name: str, trials: list[Trial]) -> list[Step]:
        self._trials[name] = trials
        self._stages.pop(name, None)
        self._tell()
        return []

    def _staged(self, name: str, stage: str, steps: list[Step]) -> list[Step]:
        self._stages[name] = f"{name}: {stage}"
        self._tell()
        return steps

    def _tell(self) -> None:
        """Of the first type that is not finished."""
        first = next(iter(self._stages.values()), None)
        if first is not None:
            self._work.at(first)

    def then(self, step: Step, result: object) -> Iterable[Step]:
        """Take a result; what it makes possible."""
        kind = self._kinds[step.name]
        if step.part:
            assert isinstance(result, list)  # noqa: S101 - of views
            return self._viewed(kind, step.part, result)
        if kind.name in self._clouds:
            assert isinstance(result, list)  # noqa: S101 - of trials
            self._remember(kind, TURNS, trials_bytes(result))
            self._work.step(NEW)
            return self._finished(kind.name, result)
        self._work.step(FITTED)
        if result is None:
            self._clouds[kind.name] = None
            self._work.skip(NEW)
            return self._finished(kind.name, [])
        assert isinstance(result, bytes)  # noqa: S101 - the file of a cloud
        self._remember(kind, "", result)
        cloud = read_cloud(result)
        compounds, together, largest = compound_sizes(cloud)
        groups = f", {together} of them in {compounds_text(compounds, largest)}" if compounds else ""
        self._work.say(f"{kind.name}: {len(cloud.at)} features{groups}, {len(cloud.feature)} appearances")
        return self._with_cloud(kind, result)

    def _viewed(self, kind: ObjectType, part: range, views: list[Observations]) -> list[Step]:
        """Of some directions; once all are there, a cloud can be made."""
        seen = self._seen[kind.name]
        seen[part] = views
        self._work.step(len(part))
        count = sum(len(some) for some in seen)
        if count < DIRECTIONS:
            return self._staged(kind.name, f"{count} of {DIRECTIONS} views", [])
        whole = [view for some in sorted(seen, key=lambda some: some.start) for view in seen[some]]
        seen.clear()
        call = partial(fitted, self._task(kind), self._kb.f_ref, self._painted, whole)
        return self._staged(kind.name, "features", [Step(kind.name, call)])

    def result(self) -> dict[str, Learned]:
        """In the file's precision, as it will come the next time: equal hit rates stay equal."""
        return {
            name: Learned(
                None if cloud is None else read_cloud(cloud), self._trials[name] if name in self._turned else None
            )
            for name, cloud in ((name, self._clouds[name]) for name in self._kinds)
        }

    def _task(self, kind: ObjectType) -> Task:
        return Task(str(kind.mesh_file), kind.mesh_scale, self._options.detector, self._options.seed)

    def _place(self, kind: ObjectType, what: str) -> Path | None:
        """Where it is remembered."""
        assert kind.mesh_file is not None  # noqa: S101 - the caller looked
        if self._folder is None:
            return None
        how = (self._kb.f_ref, self._options.detector, self._options.seed, self._painted is not None)
        key = self._keys.get(kind.name) or key_of(read_mesh(kind.mesh_file, kind.mesh_scale), how)
        self._keys[kind.name] = key
        if what and kind.surface is not None:
            shape = np.ascontiguousarray(kind.surface.vertices).tobytes() + kind.surface.triangles.tobytes()
            key = hashlib.sha256(f"{what} {key}".encode() + shape).hexdigest()
        return self._folder / f"{key}.npz"

    def _remembered(self, kind: ObjectType, what: str, read: Callable[[bytes], Found]) -> Found | None:
        place = self._place(kind, what)
        if place is None:
            return None
        try:
            found = read(place.read_bytes())
        except (OSError, CloudError):
            return None
        with suppress(OSError):  # who may only read it uses it all the same
            os.utime(place)
        return found

    def _remember(self, kind: ObjectType, what: str, content: bytes) -> None:
        place, why = self._place(kind, what), "there is no home folder; XDG_CACHE_HOME may name another"
        if place is not None:
            try:
                place.parent.mkdir(parents=True, exist_ok=True)
                write_whole(place, content)
                forget_files_beside(place)
            except (OSError, SensingError) as error:
                why = str(error)
            else:
                return
        if not what:
            self._work.say(f"{kind.name}: is not remembered for the next time: {why}")


TURNS = "turns"
"""Of what is remembered of a type beside its cloud, the trials."""


def kept_cloud(content: bytes) -> bytes:
    """The content; raises CloudError where it is not what was written.

    An archive's own checksums are of its arrays, not of their names.
    """
    if cloud_bytes(read_cloud(content)) != content:
        raise CloudError("is not what was written")
    return content
