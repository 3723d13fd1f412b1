"""Γ, images and stereo calibrations as files; files that are written whole or not at all."""
