"""Proofs over a program: which choices entail a goal (§8, *explanation*), and which condition a failed goal fails at."""
