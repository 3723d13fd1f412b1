"""Posed bodies in space: shared volume, depth, gaps, contacts, and what rests on what."""
