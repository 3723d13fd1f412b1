"""The third outcome through the console script.

Frames, what is unknown in them, a type made of it, and the frames explained by it.
"""

from __future__ import annotations

import json
from dataclasses import replace

from console import good
from written_kb import write_kb

from benchmarks.constancy.scenes import constancy_kb, sequence
from sensing.files.gamma_files import write_gamma


def test_frames_to_an_unknown_object_to_a_type_that_explains_them(tmp_path):
    whole = constancy_kb(3)
    moved = sequence(whole, 2003, 3)
    types = whole.types[:1]
    rates = replace(
        whole.rates, hit=dict.fromkeys(sorted({f.type for f in types[0].features}), 0.8), prior={types[0].name: 0.2}
    )
    write_kb(replace(whole, types=types, rates=rates), tmp_path / "kb")
    names = [f"{view.id}.json" for view in moved.views]
    for view, name in zip(moved.views, names, strict=True):
        write_gamma(view.gamma, tmp_path / name)
    rows = [{"frame": f"{view.id}.json", "T_world_camera": view.world_from_camera.tolist()} for view in moved.views]
    (tmp_path / "poses.json").write_text(json.dumps({"format": "poses/1", "frames": rows}))
    frames = [*names, "--kb", "kb", "--poses", "poses.json", "--reading", "posterior"]

    good("perceive", *frames, "-o", "before.json", cwd=tmp_path)
    before = json.loads((tmp_path / "before.json").read_text())
    assert set(before["noise"]) == set(before["undecided"]) == {"v1", "v2", "v3"}
    unknown = before["unknown"][0]
    assert len(unknown["features"]) > 15

    good("kb", "assimilate", "before.json", unknown["id"], "--kb", "kb", "--name", "found", cwd=tmp_path)
    good("perceive", *frames, "-o", "after.json", cwd=tmp_path)
    after = json.loads((tmp_path / "after.json").read_text())
    assert "found" in [row["type"] for row in after["objects"]]
    left = sum(len(one["features"]) for one in after["unknown"])
    assert left < sum(len(one["features"]) for one in before["unknown"]) - 0.5 * len(unknown["features"])
