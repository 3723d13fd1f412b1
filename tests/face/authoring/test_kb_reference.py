"""docs/formats.md on kb.yaml and object.yaml: the examples are read, and every key of the models is told."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from kb_page import models
from spoiled_box import MESH, TYPE, texts, written

from kb.files.read import read_kb
from kb.files.schema import json_schema

PAGE = (Path(__file__).parents[3] / "docs" / "formats.md").read_text(encoding="utf-8")
EXAMPLES = dict(re.findall(r"^## File (\S+)\n.*?^```yaml\n(.*?)^```$", PAGE, re.DOTALL | re.MULTILINE))


def test_the_examples_in_the_docs_are_read(tmp_path):
    files = {"kb.yaml": EXAMPLES["kb.yaml"], TYPE: EXAMPLES["object.yaml"], MESH: texts()[MESH]}
    files["kb.yaml"] = files["kb.yaml"].replace("hit: {corner: 0.9, sticker: 0.9}", "hit: {corner: 0.9}")
    kb = read_kb(written(tmp_path / "kb", files))
    assert [(kind.name, len(kind.features)) for kind in kb.types] == [("box", 2)]
    assert (kb.name, kb.rates.hit, kb.rates.prior) == ("mine", {"corner": 0.9}, {"box": 0.5})


@pytest.mark.parametrize("which", ["kb", "object"])
def test_every_key_is_told_and_explained(which):
    tables = dict(models(json_schema(which)))
    assert len(tables) >= 4
    for name, model in tables.items():
        section = PAGE.split(f"\n### {name}\n")[1].split("\n#")[0]
        for key, of in model["properties"].items():
            assert f"| `{key}` |" in section
            assert of["description"].split("\n")[0].replace("|", "\\|") in section
