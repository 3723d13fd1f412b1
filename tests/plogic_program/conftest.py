"""Situations for the tests of the program side: the two towers of §8, and random ones."""

from __future__ import annotations

import sys
from pathlib import Path

from plogic.logic.safety.author import load_problog

load_problog()
sys.path.insert(0, str(Path(__file__).parent))
