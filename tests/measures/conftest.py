"""The synthetic towers are shared with the tests of the cycle, hand-made situations with those of the program."""

from __future__ import annotations

import sys
from pathlib import Path

for folder in ("cycle", "plogic_program"):
    sys.path.insert(0, str(Path(__file__).parent.parent / folder))
