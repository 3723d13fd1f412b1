"""The synthetic towers are shared with the tests of the cycle, learnt clouds with those of the knowledge base."""

from __future__ import annotations

import sys
from pathlib import Path

for folder in ("cycle", "kb"):
    sys.path.insert(0, str(Path(__file__).parent.parent / folder))
