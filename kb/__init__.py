"""Σ: what can exist. Feature clouds, mereology, surfaces, reading and writing, authoring."""
