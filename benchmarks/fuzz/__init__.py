"""Hostile input for every reader: what it is made of, who reads it, and what must not happen."""
