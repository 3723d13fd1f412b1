"""Hypotheses whose pose is not known: how detections tell that they stand to others (§8, last paragraph)."""
