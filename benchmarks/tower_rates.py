"""Count what the detectors do on simulated towers: the hit rates and clutter that `kb/towers/kb.yaml` states.

Run as ``python benchmarks/tower_rates.py [SCENES]``. The scenes have seeds of their own, from 50,000 up, which no
benchmark uses. A feature is hit where an appearance of one of its types lies within the match tolerance of its true
place; clutter is what lies near no visible feature.
"""

from __future__ import annotations

import argparse
from collections import Counter, defaultdict

import numpy as np

from benchmarks.towers.bench import PLAN, scene_of
from plogic.match.gamma.data import data_of
from plogic.match.judged.expectation import hidden_by, matched, pose_of
from plogic.measures.distinctiveness import compatible
from plogic.run.sources import kb_of
from sensing.detectors.detector import detect

FIRST_SEED = 50_000


def main(scenes: int) -> None:
    """Print hits per expected feature, clutter per image and the spread of the residuals."""
    kb = kb_of("towers")
    hits: dict[str, list[bool]] = defaultdict(list)
    clutter: Counter[str] = Counter()
    residuals: list[float] = []
    for i in range(scenes):
        scene = scene_of(kb, PLAN[i % len(PLAN)], FIRST_SEED + i)
        gamma = detect(scene.photograph().image, scene.camera, kb.appearance_types)
        data = data_of(gamma.appearances, gamma.camera)
        true = [(b.label, T) for b, T in zip(scene.bodies, scene.camera_from_bodies, strict=True) if b.label]
        posed = [pose_of(kb.type(label), T, data, kb) for label, T in true]
        used: set[int] = set()
        for one in posed:
            hidden = np.zeros(len(one.uv), dtype=bool)
            for other in posed:
                if other is not one:
                    hidden |= hidden_by(one, other)
            types = [frozenset(a.type for a in f.appearances) for f in one.object_type.features]
            found = matched(one, data, compatible(types, data.types), kb.rates.match_tolerance, hidden=hidden)
            expected = found.candidate & ~hidden
            for f in np.flatnonzero(expected):
                hits[found.object_type.features[f].type].append(bool(found.detected[f]))
            used |= {int(m) for m in found.matches[expected & found.detected]}
            residuals += found.residual[expected & found.detected].tolist()
        clutter.update(kind for a, kind in enumerate(data.types) if a not in used)
    for name, values in sorted(hits.items()):
        print(f"hit {name}: {np.mean(values):.3f} of {len(values)}")  # noqa: T201 - a script
    for name in kb.appearance_types:
        print(f"clutter {name}: {clutter[name] / scenes:.1f} an image")  # noqa: T201
    quantiles = np.quantile(residuals, [0.5, 0.68, 0.9, 0.97])
    print("residual px at 50, 68, 90, 97 %:", np.round(quantiles, 2).tolist())  # noqa: T201


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("scenes", nargs="?", type=int, default=48, metavar="SCENES", help="how many (48)")
    main(parser.parse_args().scenes)
