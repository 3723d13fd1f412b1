"""The situations of ``tests/plogic_program`` are used here too."""

from __future__ import annotations

import sys
from pathlib import Path

from plogic.logic.safety.author import load_problog

load_problog()
sys.path.insert(0, str(Path(__file__).parent.parent / "plogic_program"))
