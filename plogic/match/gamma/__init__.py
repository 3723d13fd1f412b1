"""Γ as arrays: what a search works on."""
