"""Δ: what is believed. Measures, hypotheses, the perceptual cycle, program text, possible worlds, queries, explanations."""
