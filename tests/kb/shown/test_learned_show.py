"""What is shown of learned types: a few lines each, never a line a feature or a word.

And what of them may be meant otherwise.
"""

import json
from dataclasses import replace

import numpy as np
import pytest
from painted_cube import write_knowledge
from random_cloud import random_cloud, unit

from geometry.cones import even_directions
from kb.clouds.lobes import in_lobe
from kb.errors import KBErrors
from kb.files.read import read_kb
from kb.shown.cautions import MANY, learned_summary
from kb.shown.show import check_report, tree_document, tree_text
from plogic.face.authoring.kb_show import measures_command, show_command


def many(seed, axis=(0.0, 0, 1), features=300, spread=0.1):
    """A cloud of many features whose lobes look about one way."""
    rng = np.random.default_rng(seed)
    lobes = 2 * features
    along = unit(np.asarray(axis) + spread * rng.normal(size=(lobes, 3)))
    return random_cloud(
        seed,
        features,
        lobes,
        axis=along,
        up=unit(np.cross(along, rng.normal(size=(lobes, 3)))),
        half_angle=np.full(lobes, 0.7),
    )


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return write_knowledge(tmp_path_factory.mktemp("two"), {"one": many(1), "other": many(2)})


@pytest.fixture(scope="module")
def kb(folder):
    return read_kb(folder)


def test_a_learned_type_is_summed_up(kb):
    kind = kb.type("one")
    summary = learned_summary(kind)
    assert (summary.detector, summary.features, summary.appearances) == ("sift", 300, 600)
    assert summary.words == len(set(kind.lobes.types)) <= len(kb.words.names)
    assert summary.hit == pytest.approx(np.median(kind.learned.hit))
    assert summary.sigma == pytest.approx(np.median(kind.learned.sigma))
    counts = []
    for direction in even_directions(200):
        held = in_lobe(kind.lobes, kind.surface.centre + summary.distance * direction, 1.0)[0]
        counts.append(len(set(kind.lobes.feature[held].tolist())))
    assert summary.share == np.mean(np.array(counts) >= MANY)
    assert 0.03 < summary.share < 0.3  # a cone of 0.7 rad is 12 % of the sphere
    assert summary.most == max(counts) > 200


def test_keypoints_and_sides_of_edges_are_counted(tmp_path):
    cloud = many(1)
    sided = read_kb(
        write_knowledge(tmp_path, {"one": replace(cloud, size=np.where(cloud.feature < 40, 0.0, cloud.size))})
    )
    summary = learned_summary(sided.type("one"))
    assert (summary.features, summary.keypoints, summary.sides) == (300, 260, 40)
    told = "learned with sift: 260 keypoints and 40 sides of edges, 600 appearances, "
    assert told in check_report(sided)[1]
    assert told in tree_text(sided)
    learned = tree_document(sided)["types"][0]["learnt"]
    assert (learned["features"], learned["keypoints"], learned["sides"]) == (300, 260, 40)


def test_without_sides_of_edges_nothing_is_said_of_them(kb):
    summary = learned_summary(kb.type("one"))
    assert (summary.keypoints, summary.sides) == (300, 0)
    assert not any("edge" in line for line in summary.lines)


def test_the_report_has_two_lines_a_learned_type_and_no_notes(kb):
    head, *lines = check_report(kb)
    assert head == f"painted: 2 types, 0 appearance types, {len(kb.words.names)} visual words, no mistakes"
    assert len(lines) == 4
    assert lines[0].startswith("one: learned with sift: 300 features, 600 appearances, ")
    assert "12 facets" in lines[0]
    assert "hit rate" in lines[1]
    assert "of the view sphere" in lines[1]
    assert max(map(len, lines)) < 150


def test_the_tree_and_the_measures_are_short(folder, kb):
    assert len(tree_text(kb).splitlines()) == 8
    text, words = measures_command(str(folder), None, as_json=False), kb.words.names
    assert f" visual words of {len(words)}" in text
    assert not any(name in text for name in words)
    assert len(text.splitlines()) < 8
    assert len(show_command(str(folder), as_json=False).splitlines()) < 20


def test_documents_hold_everything(folder, kb):
    document = json.loads(json.dumps(tree_document(kb), allow_nan=False))
    one, _ = document["types"]
    assert one["learnt"]["features"] == 300
    assert sum(one["features"].values()) == 300
    rows = json.loads(measures_command(str(folder), None, as_json=True))["features"]
    assert {row["type"] for row in rows} <= set(kb.words.names)
    assert sum(row["instances"] for row in rows) == 600
    assert sum(row["p_dv"] for row in rows) == pytest.approx(1.0)


def test_the_same_cloud_twice_and_too_few_features_are_warned_of(tmp_path):
    clouds = {"a": many(1), "b": many(1), "few": many(3, features=9), "fewer": many(4, features=2)}
    warnings = [line for line in check_report(read_kb(write_knowledge(tmp_path, clouds))) if line.startswith("warning")]
    assert "warning: a: its cloud is the same as that of b: nothing tells them apart" in warnings
    assert any(line.startswith("warning: few: no viewpoint expects 20") for line in warnings)
    assert any(line.startswith("warning: fewer: no viewpoint expects 4") for line in warnings)
    assert len(warnings) == 3


def test_spoilt_files_are_mistakes_at_their_line(tmp_path):
    folder = write_knowledge(tmp_path, {"one": many(1, features=30)})
    (folder / "words.npz").write_bytes(b"nothing")
    (folder / "objects" / "one" / "cloud.npz").write_bytes(b"nothing")
    with pytest.raises(KBErrors) as caught:
        read_kb(folder)
    texts = [str(mistake) for mistake in caught.value.mistakes]
    assert any("kb.yaml:4:" in text and "is no vocabulary of visual words" in text for text in texts)
    assert any("object.yaml:3:" in text and "is no learned cloud" in text for text in texts)


@pytest.mark.parametrize(
    ("file", "old", "new", "said"),
    [
        ("kb.yaml", "words: {file: words.npz}\n", "", "the knowledge base has no words"),
        ("objects/one/object.yaml", "{file: cloud.npz}", "{file: gone.npz}", "gone.npz"),
        (
            "objects/one/object.yaml",
            "cloud: {file",
            "features: [{feature: f, type: t, at: [0, 0, 0]}]\ncloud: {file",
            "learned or written by hand",
        ),
        ("kb.yaml", "{file: words.npz}", "{file: ../words.npz}", "words.npz"),
    ],
)
def test_what_does_not_belong_together_is_a_mistake(tmp_path, file, old, new, said):
    folder = write_knowledge(tmp_path, {"one": many(1, features=30)})
    text = (folder / file).read_text()
    assert old in text
    (folder / file).write_text(text.replace(old, new))
    with pytest.raises(KBErrors) as caught:
        read_kb(folder)
    assert any(said in str(mistake) for mistake in caught.value.mistakes)


def test_words_that_are_fewer_than_the_cloud_knows_are_a_mistake(tmp_path):
    (tmp_path / "other").mkdir()
    folder, other = (
        write_knowledge(tmp_path, {"one": many(1, features=200)}),
        write_knowledge(tmp_path / "other", {"one": many(1, features=10)}),
    )
    (folder / "words.npz").write_bytes((other / "words.npz").read_bytes())
    with pytest.raises(KBErrors, match="was learned with other words"):
        read_kb(folder)
