"""The laws are held to the situations, tangles and programs that the other tests draw."""

from __future__ import annotations

import sys
from pathlib import Path

from plogic.logic.safety.author import load_problog

load_problog()
HERE = Path(__file__).resolve().parent
sys.path[:0] = [
    str(HERE),
    *(str(HERE.parent / folder) for folder in ("plogic_program", "factors", "programs_engine", "cycle")),
]
