"""Sequences of views."""
