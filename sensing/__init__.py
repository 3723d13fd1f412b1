"""Γ: what is detected.

Appearances, one file a detector, the simulated camera. Blind to every hypothesis that Γ will judge.
"""
