"""The programs that the tests of this folder draw are in a module beside them."""

from __future__ import annotations

import sys
from pathlib import Path

from plogic.logic.safety.author import load_problog

load_problog()
sys.path.insert(0, str(Path(__file__).parent))
