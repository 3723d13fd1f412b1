"""What the tests of looking ahead share is in ``made_prospects``."""

from __future__ import annotations

from plogic.logic.safety.author import load_problog

load_problog()
