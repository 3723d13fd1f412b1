"""The situations to test with are those of the program's tests."""

from __future__ import annotations

import sys
from pathlib import Path

from plogic.logic.safety.author import load_problog

load_problog()
sys.path.insert(0, str(Path(__file__).resolve().parent.parent / "plogic_program"))
