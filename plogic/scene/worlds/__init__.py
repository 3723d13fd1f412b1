"""Ranked possible worlds, the causes in each, and what a deadline left open."""
