"""Points in space, cameras on a ring, a detector that misses and a clutter of its own: what constancy is tried on."""

from __future__ import annotations

import sys
from pathlib import Path

sys.path[:0] = [str(Path(__file__).parent), str(Path(__file__).parents[1] / "commands")]
