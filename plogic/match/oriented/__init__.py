"""Δh generation over all types at once: oriented, typed appearances, pairs of neighbours in view cells (§6.3)."""
