"""Pixels as evidence of a pose: how well a painted mesh, drawn there, is what a photo shows (formalism §9.10)."""
