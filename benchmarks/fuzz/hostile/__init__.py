"""Hostile programs: what they try, the doors through which they come, and what must not happen."""
