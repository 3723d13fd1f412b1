"""Proofs over a program: choices that entail a goal (§8, *explanation*), and conditions where a goal fails."""
