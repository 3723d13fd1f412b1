"""Sequences are drawn of the towers that the cycle's tests draw, and asked through the console script."""

from __future__ import annotations

import sys
from pathlib import Path

from plogic.logic.safety.author import load_problog

load_problog()
HERE = Path(__file__).resolve().parent
sys.path[:0] = [str(HERE), *(str(HERE.parent / folder) for folder in ("cycle", "commands"))]
