"""Constancy (§4.4): what triangulates to one place over moved views, and persists, is physical.

What does not is noise.
"""
