"""Fifteen causes of an empty answer, each made on purpose: the first line that is printed names it."""

from __future__ import annotations

import json
import re
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import pytest
from in_process import told
from spoiled_box import CAMERA, TYPE, gamma_file, sight, texts, written

from geometry.camera import camera_to_dict
from kb.files.folder import shipped
from kb.files.read import read_kb
from plogic.run.perceive import Perceiver
from plogic.run.silence.causes import why_nothing
from sensing.files.gamma_files import gamma_from_dict

RATES = "  hit: {corner: 0.9, sticker: 0.9}\n"


def edited(old, new, name=TYPE):
    files = texts()
    assert old in files[name]
    return files | {name: files[name].replace(old, new)}


def narrow():
    files = edited("75 deg", "10 deg")
    return files | {TYPE: files[TYPE].replace("126 deg", "15 deg")}


def kept(count):
    files = texts()
    head, *rows = files[TYPE].split("  - feature:")
    some = {0: [], 3: [rows[0], *rows[-2:]]}.get(count, rows[:count])
    text = "  - feature:".join([head, *some]) if some else head.replace("features:", "features: []")
    return files | {TYPE: text, "kb.yaml": files["kb.yaml"].replace(RATES, "")}


def inward():
    files = texts()
    turned = re.sub(r"axis: \[([^\]]+)\]", lambda m: f"axis: {[-float(x) for x in m[1].split(',')]}", files[TYPE])
    return files | {TYPE: turned.replace("126 deg", "60 deg")}


def empty():
    return {"kb.yaml": texts()["kb.yaml"].replace("priors: {box: 0.5}\n", "").replace(RATES, "")}


def speckled():
    """The box with sixteen spots of two types, at random, on the two faces that are seen: no mirror image fits."""
    rng = np.random.default_rng(3)
    rows = []
    for i in range(24):
        x, y, z = rng.uniform([-0.15, -0.1, 0.0], [0.15, 0.1, 0.16])
        at, axis = (([x, -0.1, z], [0, -1, 0]), ([-0.15, y, z], [-1, 0, 0]), ([x, y, 0.16], [0, 0, 1]))[i % 3]
        look = ("corner", "sticker")[i // 3 % 2]
        lobe = f"lobe: {{axis: {axis}, half_angle: 75 deg, range: [0.2 m, 5 m]}}"
        place = [round(float(a), 4) for a in at]
        rows.append(f"  - {{feature: f{i}, type: {look}, at: {place}, appearances: [{{type: {look}, {lobe}}}]}}\n")
    files = texts()
    return files | {TYPE: files[TYPE].split("  - feature:")[0] + "".join(rows)}


def moved(change, document=None):
    """Γ with every place changed."""
    document = document or sight()
    for row in document["appearances"]:
        row["uv"] = change(*row["uv"])
    return document


def of_speckled(distance=1.5):
    with TemporaryDirectory() as folder:
        return sight(distance, home=written(Path(folder), speckled()))


def with_k(factor):
    """Γ of a camera whose focal length is stated that many times as long."""
    document = of_speckled(0.45)
    document["camera"]["K"][0][0] *= factor
    document["camera"]["K"][1][1] *= factor
    return document


def named(kind):
    document = sight()
    document["appearances"] = [row | {"type": kind} for row in document["appearances"] if row["type"] == "corner"]
    return document


def few():
    document = sight()
    return document | {"appearances": document["appearances"][:3]}


def with_angles():
    document = sight()
    rng = np.random.default_rng(1)
    for row in document["appearances"]:
        row["angle"] = round(float(rng.uniform(-3, 3)), 3)
    return document


def blurred(pixels):
    rng = np.random.default_rng(2)
    return moved(lambda u, v: [round(float(x), 2) for x in np.array([u, v]) + rng.normal(0, pixels, 2)])


def small_camera():
    document = sight()
    document["camera"] |= {"width": 200, "height": 150}
    return document


ANGLES = edited("sigma: 1.0", "sigma: 1.0\n  sigma_angle: 3 deg", "kb.yaml")
CAUSES = {
    "a knowledge base without types": (empty, sight, "has no object type"),
    "a type without features": (lambda: kept(0), sight, "box has no features"),
    "one feature type": (lambda: kept(8), sight, "every feature is of type 'corner'"),
    "too few features": (lambda: kept(3), sight, "has 3 features, and a pose is taken from 4"),
    "lobes that look inward": (inward, sight, "look inward"),
    "farther than the range": (
        lambda: edited("[0.2 m, 5 m]", "[0.2 m, 1 m]"),
        sight,
        re.compile(r"box: \d+ of \d+ corners are farther than their range: 1\.\d+ m, range 1 m"),
    ),
    "nearer than the range": (
        lambda: edited("[0.2 m, 5 m]", "[3 m, 8 m]"),
        sight,
        re.compile(r"box: \d+ of \d+ corners are nearer than their range: 1\.\d+ m, range from 3 m"),
    ),
    "narrow lobes": (narrow, sight, "its lobes never meet"),
    "no data": (texts, lambda: sight() | {"appearances": []}, "no appearances"),
    "data of another type": (
        lambda: edited("[corner, sticker]", "[corner, sticker, blob]", "kb.yaml"),
        lambda: named("blob"),
        "none of the 10 appearances is of a type that box looks like",
    ),
    "too few data": (texts, few, "only 3 appearances"),
    "a focal length of another camera": (speckled, lambda: with_k(3.0), "focal length"),
    "a mirrored picture": (speckled, lambda: moved(lambda u, v: [639.0 - u, v], of_speckled(0.6)), "mirror"),
    "angles by another convention": (lambda: ANGLES, with_angles, "angle"),
    "data beyond the tolerance": (
        lambda: edited("match_tolerance: 4.0", "match_tolerance: 1.2", "kb.yaml"),
        lambda: blurred(3),
        "match_tolerance",
    ),
    "places outside of the camera's image": (texts, small_camera, "is outside the image of 200x150"),
}


@pytest.mark.parametrize("name", CAUSES)
def test_the_first_line_names_the_cause(name, tmp_path):
    files, gamma, cause = CAUSES[name]
    folder = written(tmp_path / "kb", files())
    out = tmp_path / "out.json"
    lines = told("perceive", gamma_file(tmp_path, gamma()), "--kb", folder, "-o", out)
    assert (
        not [h for h in json.loads(out.read_text())["hypotheses"] if h["status"] == "accepted"]
        if out.exists()
        else True
    )
    assert re.search(cause, lines[0]) if isinstance(cause, re.Pattern) else cause in lines[0], "\n".join(lines)


def test_there_are_fifteen_and_one():
    assert len(CAUSES) == 16


def test_what_is_found_is_told_first(tmp_path):
    """The same Γ with nothing spoiled: the box, and no cause of silence."""
    lines = told("perceive", gamma_file(tmp_path, sight()), "--kb", "first", "-o", tmp_path / "out.json")
    assert len(lines) == 2
    assert "; 1 object; " in lines[0]
    assert lines[1].startswith("h1 box (")


def test_clutter_alone_is_seldom_given_a_far_fetched_cause():
    """Of Γ of noise alone: what would be found otherwise is told of at most one in twelve."""
    kb = read_kb(shipped("first"))
    perceiver, told_of, empty = Perceiver(kb), [], 0
    for seed in range(12):
        rng = np.random.default_rng(seed)
        rows = [
            {"id": f"a{i}", "type": str(rng.choice(["corner", "sticker"])), "uv": rng.uniform(0, [639, 479]).tolist()}
            for i in range(int(rng.integers(8, 40)))
        ]
        gamma = gamma_from_dict({"format": "gamma/1", "camera": camera_to_dict(CAMERA), "appearances": rows})
        document = perceiver(gamma)
        if all(h["status"] == "rejected" for h in document["hypotheses"]):
            empty += 1
            told_of += [line for line in why_nothing(document, gamma, kb) if " pose" not in line]
    assert empty >= 10
    assert len(told_of) <= 1, told_of
