"""Poses from matched points: POSIT, SoftPOSIT, least squares, and what places on the screen say of a pose."""
