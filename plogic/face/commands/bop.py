"""``plogic bop``: a BOP dataset to the challenge's results file, with its scores where the truth is known."""

import json
from collections.abc import Callable
from contextlib import AbstractContextManager
from pathlib import Path
from typing import Any

from kb.clouds.cloud import KnowledgeBase
from kb.files.folder import parts_of
from plogic.base.clock import Stopwatch
from plogic.base.errors import InputError
from plogic.face.shown.options import Scoring
from plogic.face.shown.printed import written
from plogic.face.shown.progress import beating
from plogic.face.shown.tables import plain_table
from plogic.run.bop.dataset import Dataset, open_dataset
from plogic.run.bop.models import ids_of, model_ids, model_names, read_ids, read_models, unknown
from plogic.run.bop.recalls import Recalls, Scores, score, targets_of, views_of
from plogic.run.bop.results_file import Look, Run, results_text, run
from plogic.run.perceive import perceiver_of
from plogic.run.sources import detectable, kb_of
from sensing.detectors.detector import detect
from sensing.files.whole_files import check_places

NOTE = "AR_VSD is not computed: the mean of the two is not the challenge's AR, and is not to be compared with one"


def bop_command(
    folder: str,
    kb_folder: str,
    out: str,
    options: Scoring,
    *,
    say: Callable[[str], None],
    write: Callable[[str], None],
    look: Look | None = None,
) -> str:
    """Read, look, write the CSV whole, and give the text of the scores.

    ``look`` takes the place of the KB's own perceiver.

    Raises:
        PlogicError: What is wrong with the dataset, the KB or the places, before any work; nothing is written then.
    """
    if out == "-" and options.as_json:
        raise InputError("-o -: the results and --json cannot both be on stdout")
    if out != "-":
        check_places([Path(out)], parts_of(kb_folder))
    clock = Stopwatch()
    with beating(lambda: f"reading {folder} and {kb_folder}") as above:
        dataset = open_dataset(folder)
        kb = kb_of(kb_folder)
        ids = _ids(kb, options.ids, dataset, above(say))
        look = look or look_of(kb, clock)

    def during(name: str) -> AbstractContextManager[object]:
        return beating(lambda: f"{name}: {clock.here or 'perceiving'}")

    done = run(dataset, look, ids, say, timed=options.timed, during=during)
    if not done.cameras:
        raise InputError("\n".join([f"{folder}: none of its {done.frames} images could be perceived", *done.wrong[:3]]))
    with beating(lambda: "scoring") as above:
        scores, why = _scored(dataset, done, above(say))
    written(results_text(done.estimates), out, say=say, write=write)
    if out == "-":
        say(_text(scores, why))
        return ""
    return json.dumps(_document(out, done, scores, why), indent=1) if options.as_json else _text(scores, why)


def look_of(kb: KnowledgeBase, clock: Stopwatch | None = None) -> Look:
    """The KB's own perceiver: what it accepts, scored by its probability; ``clock`` tells what it is at.

    Raises InputError where no detector reports a type of the KB.
    """
    if not detectable(kb):
        raise InputError(
            f"{kb.name}: no detector reports any of its appearance types ({', '.join(kb.appearance_types[:8])})"
        )
    perceiver, watch = perceiver_of(kb), clock or Stopwatch()

    def look(image: Any, camera: Any) -> list[tuple[str, Any, float]]:  # noqa: ANN401 - arrays
        with watch.stage("detect"):
            gamma = detect(image, camera, kb.sought, kb.words)
        accepted = perceiver.accepted(gamma, image, watch)
        return [(h.object_type.name, h.camera_from_object, probability) for h, probability in accepted]

    return look


def _ids(kb: KnowledgeBase, path: str | None, dataset: Dataset, say: Callable[[str], None]) -> dict[str, int]:
    """BOP's numbers of the KB's types; what leads nowhere is said, and that nothing leads anywhere is an error."""
    names, stated = [kind.name for kind in kb.types], read_ids(path or dataset.ids)
    by_name = {} if dataset.models is None else model_names(dataset.models)
    ids = {name: by_name[name] for name in names if name in by_name} | ids_of(names, stated)
    lines = unknown(names, ids, stated, None if dataset.models is None else model_ids(dataset.models))
    if not ids:
        raise InputError("\n".join([f"{kb.name}: none of its types has a BOP number", *lines]))
    for line in lines:
        say(line)
    return ids


def _scored(dataset: Dataset, done: Run, say: Callable[[str], None]) -> tuple[Scores | None, str]:
    """The scores, or None and why there are none."""
    views, wrong = views_of(dataset, done)
    for line in wrong:
        say(line)
    if not views:
        return None, "not scored: no image has ground truth (scene_gt.json)"
    if dataset.models is None:
        return None, "not scored: there are no models (models/models_info.json)"
    try:
        models = read_models(dataset.models, {obj_id for view in views for obj_id in targets_of(view)})
    except InputError as error:
        return None, f"not scored: {error}"
    return score(views, models), NOTE


def _row(name: str, recalls: Recalls) -> dict[str, Any]:
    return {
        "object": name,
        "targets": recalls.targets,
        "AR_MSSD": recalls.ar_mssd,
        "AR_MSPD": recalls.ar_mspd,
        "mean of the two": recalls.mean_of_the_two,
        "ADD(-S) recall": recalls.add,
    }


def _rows(scores: Scores) -> list[dict[str, Any]]:
    return [_row("all", scores.together), *(_row(str(obj_id), recalls) for obj_id, recalls in scores.objects.items())]


def _text(scores: Scores | None, why: str) -> str:

    if scores is None:
        return why
    counts = f"{scores.images} images, {scores.estimates} estimates, {scores.absent} of them of objects that are not in their image"
    return f"{plain_table('recall against the ground truth', _rows(scores))}\n{counts}\n{why}"


def _document(out: str, done: Run, scores: Scores | None, why: str) -> dict[str, Any]:
    table = None if scores is None else {"images": scores.images, "absent": scores.absent, "recalls": _rows(scores)}
    counts = {"frames": done.frames, "perceived": len(done.cameras), "estimates": len(done.estimates)}
    return {"format": "bop/1", "results": out, **counts, "wrong": list(done.wrong), "scores": table, "note": why}
