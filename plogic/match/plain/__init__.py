"""Hypotheses of a type as the paper makes them: sets of four with POSIT, or SoftPOSIT.

Slow and plain, what the fast search is tested against.
"""
