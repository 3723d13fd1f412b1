import json

import pytest
from small_kb import OBJECT, write_small

from kb.files.folder import shipped
from kb.files.read import read_kb
from kb.files.schema import json_schema
from kb.shown.show import check_report, tree_document, tree_text


@pytest.fixture
def small(tmp_path):
    return read_kb(write_small(tmp_path))


def test_the_report_counts_and_notes(small):
    assert check_report(small) == [
        "warning: tent: has 2 features, and a pose is taken from 4: it is never found",
        "small: 1 type, 2 appearance types, no mistakes",
        "tent: 3 features (apex 1, corner 2), 2 lobes, 4 facets, 0.433 m3, opaque, 3-fold symmetry",
    ]


def test_what_may_be_meant_otherwise_is_noted(tmp_path):
    text = OBJECT.replace("mesh: {file: mesh.obj, units: cm}\n", "").replace("{type: apex, lobe", "{type: corner, lobe")
    report = check_report(read_kb(write_small(tmp_path, object=text)))
    assert "note: tent: has no mesh, so it hides nothing" in report
    assert "note: no feature looks like 'apex'" in report


def test_a_symmetry_that_the_mesh_does_not_have_is_noted(tmp_path):
    report = check_report(read_kb(write_small(tmp_path, object=OBJECT.replace("fold: 3", "fold: 2"))))
    assert [line[:39] for line in report if line.startswith("note:")] == ["note: tent: symmetry 1 moves the mesh's"]


def test_a_feature_without_appearances_is_noted(tmp_path):
    text = OBJECT.replace("    features: []", "    features: [{feature: f, type: corner, at: [0, 0, 0]}]")
    report = check_report(read_kb(write_small(tmp_path, object=text)))
    assert "note: tent: body/f has no appearance, so it is never expected" in report


def test_the_tree_as_text(small):
    assert tree_text(small) == (
        "object tent\n"
        "  object roof at [0, 0, 0.5]\n"
        "    feature apex at [0.1, 0, 0.5], looks like apex\n"
        "    feature pair: corner at [0, 0, 0]\n"
        "      feature left: corner at [1, 0, 0], looks like corner\n"
        "  object body at [0, 0, 0]\n"
        "  stands as its mesh can, on 4 faces: "
        "[0, 0, -1] 0.5, [0.4472, -0.7746, 0.4472] 0.167, [-0.8944, 0, 0.4472] 0.167, [0.4472, 0.7746, 0.4472] 0.167\n"
    )


def test_the_document_is_plain_and_whole(small):
    document = json.loads(json.dumps(tree_document(small), allow_nan=False))
    assert (document["format"], document["name"], document["digest"]) == ("kb/1", "small", small.digest)
    (tent,) = document["types"]
    assert tent["features"] == {"apex": 1, "corner": 2}
    nodes = {node["id"]: node for node in tent["nodes"]}
    assert nodes["roof/pair/left"]["parent"] == "roof/pair"
    assert nodes["roof/apex#0"]["lobe"]["range"] == [0.2, 30.0]
    assert nodes[""]["parent"] is None


def test_the_towers_are_noted_as_nothing_odd():
    report = check_report(read_kb(shipped("towers")))
    assert report[0] == "towers: 2 types, 6 appearance types, no mistakes"
    assert not [line for line in report if "symmetry" in line and line.startswith("note:")]


@pytest.mark.parametrize("which", ["kb", "object"])
def test_every_key_of_the_schemas_is_documented(which):
    schema = json_schema(which)
    models = [schema, *schema["$defs"].values()]
    keys = [(model["title"], key, row) for model in models for key, row in model["properties"].items()]
    assert len(keys) >= 9
    assert [(title, key) for title, key, row in keys if not row.get("description")] == []
    assert all(model["additionalProperties"] is False for model in models)
