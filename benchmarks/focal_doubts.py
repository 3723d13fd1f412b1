"""Count how often a wrong focal length is told, and the right one doubted: what the bars of `run/lens.py` come to.

Run as ``python benchmarks/focal_doubts.py [SCENES]``. Photographs of simulated towers, with seeds of their own from
70,000 up, are perceived with the right camera and with cameras whose focal length is off by each of ``SHARES``.
"""

from __future__ import annotations

import argparse
from dataclasses import replace

import numpy as np

from benchmarks.towers.bench import PLAN, scene_of
from plogic.base.clock import Stopwatch
from plogic.cycle.delta import Options
from plogic.run.perceive import perceiver_of
from plogic.run.sources import kb_of
from sensing.detectors.detector import detect

FIRST_SEED = 70_000
SHARES = 1.0, 0.7, 0.85, 1.2, 1.5


def main(scenes: int) -> None:
    """Print for each focal length how many of the scenes in which something was found were doubted."""
    kb = kb_of("towers")
    perceiver = perceiver_of(kb)
    kinds = [kind for kind in PLAN if kind != "decoys"]
    told, found = dict.fromkeys(SHARES, 0), dict.fromkeys(SHARES, 0)
    for i in range(scenes):
        scene = scene_of(kb, kinds[i % len(kinds)], FIRST_SEED + i)
        image = scene.photograph().image
        for share in SHARES:
            camera = replace(scene.camera, K=scene.camera.K * np.array([[share, share, 1], [1, share, 1], [1, 1, 1]]))
            gamma = detect(image, camera, kb.appearance_types)
            document = perceiver(gamma, Options(), image, Stopwatch())
            found[share] += any(h["status"] == "accepted" for h in document["hypotheses"])
            told[share] += "camera_doubt" in document
    for share in SHARES:
        print(f"{share:g} of the right focal length: told in {told[share]} of {found[share]}")  # noqa: T201 - a script


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("scenes", nargs="?", type=int, default=40, metavar="SCENES")
    main(parser.parse_args().scenes)
